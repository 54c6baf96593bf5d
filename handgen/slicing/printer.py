"""The machines that profiles are written for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from handgen.parameters.process import Printing


@dataclass(frozen=True)
class Printer:
    """A machine as both slicers must know it; lengths in mm, mm/s2 and mm/s.

    `definition` and `extruder` name the files of Cura that describe it. In `start` and `end`,
    `{temperature}` and `{bed}` stand for degC.
    """

    name: str
    slug: str
    volume: tuple[float, float, float]
    definition: str
    extruder: str
    start: Sequence[str]
    end: Sequence[str]
    acceleration: float = 1000.0
    """Assumed, as `jerk`; at the speeds of Table B.1 a time changes little with it."""
    jerk: float = 10.0


HEPHESTOS = Printer(
    "BQ Hephestos 2", "bq_hephestos_2", (210.0, 297.0, 220.0), "bq_hephestos_2", "bq_hephestos_2_extruder_0",
    # Levels with its own probe, waits at the front, switches itself off by M801: Cura's definition of it.
    start=("M104 S{temperature}", "G28", "G29", "G90", "G0 X4 Y297 Z15 F4000", "G92 E0",
           "M109 S{temperature}"),
    end=("M801",))


def generic(volume: Sequence[float]) -> Printer:
    """Any machine with Marlin of this build volume."""
    return Printer(
        "Generic Marlin printer", "generic", tuple(volume), "fdmprinter", "fdmextruder",
        start=("M104 S{temperature}", "M140 S{bed}", "G28", "G90", "G0 Z15 F1200", "M190 S{bed}",
               "M109 S{temperature}", "G92 E0"),
        end=("M104 S0", "M140 S0", "M107", "G91", "G0 Z5 F1200", "G90", "G28 X0", "M84"))


def printer(printing: Printing) -> Printer:
    """The machine that a parameter file names."""
    if printing.printer == HEPHESTOS.name and tuple(printing.build_volume) == HEPHESTOS.volume:
        return HEPHESTOS
    return generic(printing.build_volume)
