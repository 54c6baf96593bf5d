"""A profile in PrusaSlicer's words: flat .ini for the command line, a bundle for the window.

`--load` takes a flat file only: a bundle is ignored without a word, and presets have no names there.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from handgen.parameters.process import PrintProcess
from handgen.slicing.printer import Printer
from handgen.slicing.profile import Profile
from handgen.slicing.shared import AIR_GAP, RAFT_LAYERS, RAFT_MARGIN, RETRACTION_SPEED, SLOWEST, SUPPORT_XY

PATTERNS = {"concentric": "concentric", "grid": "grid", "lines": "line", "gyroid": "gyroid"}
SPEEDS = ("perimeter_speed", "external_perimeter_speed", "small_perimeter_speed", "infill_speed",
          "solid_infill_speed", "top_solid_infill_speed", "bridge_speed", "gap_fill_speed",
          "support_material_speed", "support_material_interface_speed", "first_layer_speed",
          "first_layer_speed_over_raft")
WIDTHS = ("extrusion_width", "perimeter_extrusion_width", "external_perimeter_extrusion_width",
          "infill_extrusion_width", "solid_infill_extrusion_width", "top_infill_extrusion_width",
          "support_material_extrusion_width", "first_layer_extrusion_width")
AXES = ("x", "y", "e")

Settings = dict[str, object]


@dataclass(frozen=True)
class Presets:
    """The three presets that make a print: how, with what, on what."""

    print: Settings
    filament: Settings
    printer: Settings


def presets(profile: Profile, machine: Printer) -> Presets:
    """`profile` on `machine`."""
    return Presets(_print(profile), _filament(profile), _printer(profile, machine))


def flat(profile: Profile, machine: Printer) -> str:
    """The file for `prusa-slicer --load`."""
    found = presets(profile, machine)
    return _lines(found.print | found.filament | found.printer)


def bundle(profiles: Iterable[Profile], machines: Iterable[Printer]) -> str:
    """The file for File > Import > Import Config Bundle: every profile on every machine.

    A filament or machine that several profiles share stands there once.
    """
    sections: dict[str, Settings] = {}
    first: dict[str, str] = {}
    for profile in profiles:
        for machine in machines:
            found = presets(profile, machine)
            nozzle = f"{machine.name} {profile.process.nozzle_size:g} mm"
            named = {"print": (profile.title, found.print),
                     "filament": (f"handgen {profile.process.material}", found.filament),
                     "printer": (f"handgen {nozzle}", found.printer)}
            for kind, (name, settings) in named.items():
                sections.setdefault(f"{kind}:{name}", settings)
                first.setdefault(kind, name)
    sections["presets"] = first
    return "\n".join(f"[{name}]\n{_lines(settings)}" for name, settings in sections.items())


def _print(profile: Profile) -> Settings:
    process = profile.process
    pattern = PATTERNS[process.infill_pattern]
    skin = "concentric" if pattern == "concentric" else "monotonic"
    return {
        "layer_height": process.layer_height, "first_layer_height": process.layer_height,
        **dict.fromkeys(WIDTHS, line_width(process)),
        "perimeters": process.walls, "perimeter_generator": "classic", "thin_walls": 0,
        "gap_fill_enabled": 1, "extra_perimeters": 0, "ensure_vertical_shell_thickness": 0,
        "top_solid_layers": profile.solid_layers, "bottom_solid_layers": profile.solid_layers,
        "top_solid_min_thickness": 0, "bottom_solid_min_thickness": 0,
        "fill_density": f"{process.infill_density:g}%", "fill_pattern": pattern,
        "top_fill_pattern": skin, "bottom_fill_pattern": skin,
        "infill_anchor": 0, "infill_anchor_max": 0,
        "solid_infill_below_area": 0, "infill_only_where_needed": 0,
        **dict.fromkeys(SPEEDS, process.speed),
        "travel_speed": process.travel_speed, "max_volumetric_speed": 0, "max_print_speed": process.speed,
        "default_acceleration": 0,
        "avoid_crossing_perimeters": int(not process.retraction), "elefant_foot_compensation": 0,
        "complete_objects": 0,
        **_adhesion(profile), **_support(profile),
    }


def line_width(process: PrintProcess) -> float:
    """mm. PrusaSlicer draws a line with round edges and lays the next one that much closer, Cura a rectangle.

    With this width both lay the same plastic, and lines as far apart as the nozzle is wide.
    """
    return round(process.nozzle_size + process.layer_height * (1 - math.pi / 4), 4)


def _adhesion(profile: Profile) -> Settings:
    """Nothing but what is asked for: PrusaSlicer's own default lays a skirt around everything."""
    return {
        "skirts": int(profile.adhesion == "skirt"), "skirt_height": 1, "skirt_distance": 3,
        "brim_type": "outer_only" if profile.adhesion == "brim" else "no_brim",
        "brim_width": profile.process.brim_width if profile.adhesion == "brim" else 0,
        "brim_separation": 0,
        "raft_layers": RAFT_LAYERS if profile.adhesion == "raft" else 0,
        "raft_contact_distance": AIR_GAP, "raft_expansion": RAFT_MARGIN,
        "raft_first_layer_expansion": 0, "raft_first_layer_density": "50%",
    }


def _support(profile: Profile) -> Settings:
    """PrusaSlicer's threshold counts from the horizontal, Table B.1 (and Cura) from the vertical.

    0 would stand for its own guess.
    """
    process = profile.process
    return {
        "support_material": int(profile.support != "none"), "support_material_auto": 1,
        "support_material_buildplate_only": int(profile.support == "touching build plate"),
        "support_material_threshold": max(1, round(90 - process.support_angle)),
        "support_material_pattern": "rectilinear", "support_material_style": "snug",
        "support_material_spacing": round(process.nozzle_size * (100 / process.support_density - 1), 4),
        # A raft takes its density from the interface of supports.
        "support_material_interface_layers": RAFT_LAYERS - 1 if profile.adhesion == "raft" else 0,
        "support_material_interface_spacing": 0, "support_material_bottom_interface_layers": 0,
        "support_material_with_sheath": 0, "support_material_xy_spacing": SUPPORT_XY,
        "support_material_contact_distance": process.layer_height,
        "dont_support_bridges": 0,
    }


def _filament(profile: Profile) -> Settings:
    process = profile.process
    bed = process.heated_bed or 0
    back = process.retraction_length if process.retraction else 0
    return {
        "filament_retract_length": back, "filament_retract_speed": RETRACTION_SPEED,
        "filament_deretract_speed": RETRACTION_SPEED, "filament_retract_before_travel": 2,
        "filament_retract_layer_change": int(process.retraction), "filament_retract_lift": 0,
        "filament_wipe": 0,
        "filament_type": "PLA" if profile.column == "tooling" else "FLEX",
        "filament_diameter": profile.filament_diameter, "filament_density": process.density,
        "temperature": process.nozzle_temperature, "first_layer_temperature": process.nozzle_temperature,
        "bed_temperature": bed, "first_layer_bed_temperature": bed,
        "extrusion_multiplier": process.flow / 100, "filament_max_volumetric_speed": 0,
        "cooling": 1, "slowdown_below_layer_time": process.minimum_layer_time, "min_print_speed": SLOWEST,
        "fan_always_on": 1, "min_fan_speed": 100, "max_fan_speed": 100, "bridge_fan_speed": 100,
        "disable_fan_first_layers": 1, "full_fan_speed_layer": 2,
    }


def _printer(profile: Profile, machine: Printer) -> Settings:
    process, (x, y, z) = profile.process, machine.volume
    return {
        "printer_technology": "FFF", "gcode_flavor": "marlin", "nozzle_diameter": process.nozzle_size,
        "bed_shape": ",".join(f"{a:g}x{b:g}" for a, b in ((0, 0), (x, 0), (x, y), (0, y))),
        "max_print_height": z,
        "use_firmware_retraction": 0, "use_relative_e_distances": 0,
        "start_gcode": _gcode(machine.start), "end_gcode": _gcode(machine.end),
        "machine_limits_usage": "time_estimate_only",
        **{f"machine_max_acceleration_{axis}": machine.acceleration for axis in AXES},
        "machine_max_acceleration_extruding": machine.acceleration,
        "machine_max_acceleration_retracting": machine.acceleration,
        "machine_max_acceleration_travel": machine.acceleration,
        "machine_max_jerk_x": machine.jerk, "machine_max_jerk_y": machine.jerk,
    }


def _gcode(lines: Iterable[str]) -> str:
    """Lines with PrusaSlicer's names of the temperatures, on one line of the file."""
    names = {"temperature": "[first_layer_temperature]", "bed": "[first_layer_bed_temperature]"}
    return "\\n".join(line.format(**names) for line in lines)


def _lines(settings: Mapping[str, object]) -> str:
    return "".join(f"{key} = {value:g}\n" if isinstance(value, float) else f"{key} = {value}\n"
                   for key, value in settings.items())
