"""A profile in Cura's words: settings for CuraEngine, .curaprofile for the window."""

from __future__ import annotations

import io
import json
import zipfile
from collections.abc import Mapping
from functools import cache

from handgen.slicing.definitions import Definitions
from handgen.slicing.printer import Printer
from handgen.slicing.profile import Profile
from handgen.slicing.shared import AIR_GAP, COMBING, RAFT_MARGIN, RETRACTION_SPEED, SLOWEST, SUPPORT_XY

PATTERNS = {"concentric": "concentric", "grid": "grid", "lines": "lines", "gyroid": "gyroid"}
SUPPORTS = {"none": "buildplate", "touching build plate": "buildplate", "everywhere": "everywhere"}
SPEEDS = ("speed_print", "speed_infill", "speed_wall", "speed_wall_0", "speed_wall_x", "speed_topbottom",
          "speed_roofing", "speed_support", "speed_support_infill", "speed_support_interface",
          "speed_support_roof", "speed_support_bottom", "speed_layer_0", "speed_print_layer_0",
          "skirt_brim_speed", "raft_speed", "raft_surface_speed", "raft_interface_speed", "raft_base_speed",
          "speed_ironing", "speed_prime_tower")
"""Cura derives the walls' speed and half a dozen more from `speed_print`; Table B.1 knows one speed."""
TEMPERATURES = ("material_print_temperature", "material_print_temperature_layer_0",
                "material_initial_print_temperature", "material_final_print_temperature")
GLOBAL = {"layer_height", "layer_height_0", "material_bed_temperature", "material_bed_temperature_layer_0",
          "speed_slowdown_layers", "adhesion_type", "support_enable", "support_type"}
"""Settings that Cura keeps for the machine, the others for the extruder."""
SETTING_VERSION = 19
"""Of the files that Cura 4.13 writes; later ones read and upgrade them."""

Settings = dict[str, object]


def settings(profile: Profile) -> Settings:
    """What differs from Cura's definitions, in the order of its window; formulas follow."""
    process = profile.process
    solid = profile.solid_layers
    return {
        "layer_height": process.layer_height, "layer_height_0": process.layer_height,
        "line_width": process.nozzle_size,
        "wall_line_count": process.walls, "wall_thickness": round(process.walls * process.nozzle_size, 4),
        "top_layers": solid, "bottom_layers": solid, "initial_bottom_layers": solid,
        "top_bottom_pattern": _skin(process.infill_pattern),
        "top_bottom_pattern_0": _skin(process.infill_pattern),
        "infill_sparse_density": process.infill_density, "infill_pattern": PATTERNS[process.infill_pattern],
        **dict.fromkeys(TEMPERATURES, process.nozzle_temperature),
        "material_bed_temperature": process.heated_bed or 0,
        "material_bed_temperature_layer_0": process.heated_bed or 0,
        "material_flow": process.flow, "material_flow_layer_0": 100,
        **dict.fromkeys(SPEEDS, process.speed),
        "speed_travel": process.travel_speed, "speed_travel_layer_0": process.travel_speed,
        "speed_slowdown_layers": 1,
        "retraction_enable": process.retraction, "retraction_amount": process.retraction_length,
        "retraction_speed": RETRACTION_SPEED, "retraction_combing_max_distance": COMBING,
        "cool_min_layer_time": process.minimum_layer_time, "cool_min_speed": SLOWEST, "cool_fan_speed": 100,
        "support_enable": profile.support != "none", "support_type": SUPPORTS[profile.support],
        "support_angle": process.support_angle, "support_infill_rate": process.support_density,
        "support_xy_distance": SUPPORT_XY, "support_z_distance": process.layer_height,
        "adhesion_type": profile.adhesion, "brim_width": process.brim_width,
        "raft_margin": RAFT_MARGIN, "raft_airgap": AIR_GAP, "layer_0_z_overlap": 0,
    }


def machine_settings(profile: Profile, machine: Printer) -> Settings:
    """The machine, for CuraEngine: Cura's window has its own list of machines."""
    x, y, z = machine.volume
    start, end = ("\n".join(line.format(temperature=f"{profile.process.nozzle_temperature:g}",
                                        bed=f"{profile.process.heated_bed or 0:g}") for line in lines)
                  for lines in (machine.start, machine.end))
    return {
        "machine_name": machine.name, "machine_width": x, "machine_depth": y, "machine_height": z,
        "machine_heated_bed": profile.process.heated_bed is not None,
        "machine_nozzle_size": profile.process.nozzle_size, "material_diameter": profile.filament_diameter,
        "machine_start_gcode": start, "machine_end_gcode": end,
        # The engine's own heating commands would come before the start G-code and heat a bed that is none.
        "material_print_temp_prepend": False, "material_bed_temp_prepend": False,
        "machine_acceleration": machine.acceleration, "machine_max_acceleration_x": machine.acceleration,
        "machine_max_acceleration_y": machine.acceleration, "machine_max_jerk_xy": machine.jerk,
    }


@cache
def known(machine: Printer) -> Definitions:
    """Cura's own definitions of a machine.

    Raises:
        EngineError: they are not installed.
    """
    return Definitions(machine.definition, machine.extruder)


def resolved(profile: Profile, machine: Printer) -> Settings:
    """Every setting of CuraEngine, with all formulas worked out."""
    return known(machine).resolve(settings(profile) | machine_settings(profile, machine))


def engine_files(profile: Profile, machine: Printer) -> dict[str, str]:
    """File name -> content: a machine for `CuraEngine slice -j`, and its extruder, always a file of its own.

    They inherit from Cura's definitions, and state every value that is not these definitions' own default.

    Raises:
        EngineError: Cura's definitions are not installed.
    """
    installed = known(machine)
    values = resolved(profile, machine)
    told = {key: value for key, value in values.items()
            if value is not None and value != installed.settings[key].get("default_value")}
    extruder = f"{profile.name}_extruder"
    return {
        f"{profile.name}.def.json": _json(
            f"{machine.name}, {profile.title}", machine.definition, told,
            {"machine_extruder_trains": {"0": extruder}}),
        f"{extruder}.def.json": _json(
            f"Extruder, {profile.title}", "fdmextruder",
            {key: values[key] for key in ("machine_nozzle_size", "material_diameter")}, {}),
    }


def _json(name: str, inherits: str, told: Mapping[str, object], metadata: Mapping[str, object]) -> str:
    overrides = {key: {"default_value": told[key]} for key in sorted(told)}
    return json.dumps({"version": 2, "name": name, "inherits": inherits, "metadata": metadata,
                       "overrides": overrides}, indent=1) + "\n"


def curaprofile(profile: Profile) -> bytes:
    """The file for Settings > Profile > Manage Profiles > Import: a zip of two lists of settings."""
    kept = settings(profile)
    shared = {key: value for key, value in kept.items() if key in GLOBAL}
    own = {key: value for key, value in kept.items() if key not in GLOBAL}
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, values, place in ((profile.name, shared, ""),
                                    (f"{profile.name}-extruder", own, "position = 0\n")):
            # A fixed date, so that the same profile has the same bytes.
            entry = zipfile.ZipInfo(name, (1980, 1, 1, 0, 0, 0))
            archive.writestr(entry, _container(profile, values, place), zipfile.ZIP_DEFLATED)
    return content.getvalue()


def _container(profile: Profile, values: Mapping[str, object], place: str) -> str:
    lines = "".join(f"{key} = {value}\n" for key, value in values.items())
    return (f"[general]\nversion = 4\nname = {profile.title}\ndefinition = fdmprinter\n\n"
            f"[metadata]\ntype = quality_changes\nquality_type = normal\n{place}"
            f"setting_version = {SETTING_VERSION}\n\n[values]\n{lines}\n")


def _skin(pattern: str) -> str:
    """Full infill is bottom from end to end to Cura: its skin must have the infill's pattern then."""
    return "concentric" if pattern == "concentric" else "lines"
