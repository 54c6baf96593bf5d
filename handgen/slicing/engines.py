"""The two slicers as programs: where they are, which version, and one run without a window."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from handgen.errors import EngineError
from handgen.slicing import cura, definitions, prusaslicer
from handgen.slicing.printer import Printer
from handgen.slicing.profile import Profile

PRUSASLICER, CURA = "prusaslicer", "cura"
SLICERS = (PRUSASLICER, CURA)
PROGRAMS = {PRUSASLICER: ("prusa-slicer", "prusa-slicer"), CURA: ("CuraEngine", "cura-engine cura")}
"""Slicer -> its program, and the Debian packages that bring it with what it reads."""
DURATION = re.compile(r"(?:(\d+)d )?(?:(\d+)h )?(?:(\d+)m )?(\d+)s")
LONGEST = 3 * 3600
"""s after which a slicer hangs."""


@dataclass(frozen=True)
class Run:
    """What the slicer itself says of a file that it wrote: time in s, filament in mm."""

    print_time: float
    filament: float
    warnings: tuple[str, ...]


def missing(slicer: str) -> str | None:
    """What to install for a slicer that is not there."""
    program, packages = PROGRAMS[slicer]
    if shutil.which(program) is None:
        return f"{program} is not installed; on Debian: apt install {packages}"
    if slicer == CURA and not (definitions.RESOURCES / "definitions").is_dir():
        return f"Cura's definitions are not in {definitions.RESOURCES}; on Debian: apt install cura"
    return None


@cache
def version(slicer: str) -> str:
    """As the program states it.

    Raises:
        EngineError: it is not installed or says nothing.
    """
    if absent := missing(slicer):
        raise EngineError(absent)
    program = PROGRAMS[slicer][0]
    done = _call([program, "help" if slicer == CURA else "--help"], {})
    found = re.search(r"version ([\d.]+\w*)|PrusaSlicer-([\d.]+\w*)", done.stdout + done.stderr)
    if not found:
        raise EngineError(f"{program} does not say its version: {_tail(done)}")
    return next(filter(None, found.groups()))


def settings(slicer: str, profile: Profile, machine: Printer) -> str:
    """Everything that `slicer` is told, as text: what a slice depends on beside its part."""
    if slicer == PRUSASLICER:
        return prusaslicer.flat(profile, machine)
    return "".join(cura.engine_files(profile, machine).values())


def run(slicer: str, profile: Profile, machine: Printer, stl: Path, gcode: Path) -> Run:
    """Slice one STL, which stands on z = 0 about the origin, into `gcode`.

    Raises:
        EngineError: the slicer is absent or gave up; with the last that it said.
    """
    version(slicer)
    done = (_prusaslicer if slicer == PRUSASLICER else _cura)(profile, machine, stl, gcode)
    if done.returncode or not gcode.is_file() or not gcode.stat().st_size:
        raise EngineError(f"{PROGRAMS[slicer][0]} gave up on {stl.name}: {_tail(done)}")
    return (_read_prusaslicer if slicer == PRUSASLICER else _read_cura)(done, profile, gcode)


def _prusaslicer(profile: Profile, machine: Printer, stl: Path, gcode: Path) -> subprocess.CompletedProcess:
    x, y, _ = machine.volume
    with tempfile.TemporaryDirectory(prefix="handgen-") as place:
        config = Path(place) / f"{profile.name}.ini"
        config.write_text(prusaslicer.flat(profile, machine), encoding="utf-8")
        return _call(["prusa-slicer", "--load", str(config), "--center", f"{x / 2:g},{y / 2:g}",
                      "-g", str(stl), "-o", str(gcode)], {})


def _cura(profile: Profile, machine: Printer, stl: Path, gcode: Path) -> subprocess.CompletedProcess:
    with tempfile.TemporaryDirectory(prefix="handgen-") as place:
        for name, content in cura.engine_files(profile, machine).items():
            (Path(place) / name).write_text(content, encoding="utf-8")
        return _call(["CuraEngine", "slice", "-v", "-m1", "-j", f"{place}/{profile.name}.def.json",
                      "-o", str(gcode), "-l", str(stl)],
                     {"CURA_ENGINE_SEARCH_PATH": f"{place}:{cura.known(machine).search_path}"})


def _call(command: Sequence[str], environment: Mapping[str, str]) -> subprocess.CompletedProcess:
    try:
        return subprocess.run(command, capture_output=True, text=True, errors="replace", check=False,
                              timeout=LONGEST, stdin=subprocess.DEVNULL, env={**os.environ, **environment})
    except subprocess.TimeoutExpired:
        raise EngineError(f"{command[0]} did not finish within {LONGEST / 3600:g} h") from None


def _tail(done: subprocess.CompletedProcess) -> str:
    """The last that a program said, without the settings that CuraEngine repeats."""
    lines = [line for line in (done.stdout + done.stderr).splitlines() if line.strip() and " -s " not in line]
    how = f"exit {done.returncode}" if done.returncode >= 0 else f"signal {-done.returncode}"
    return f"{how}; {' / '.join(line.strip()[:200] for line in lines[-3:])}"


def _read_prusaslicer(done: subprocess.CompletedProcess, profile: Profile, gcode: Path) -> Run:
    text = _end_of(gcode)
    filament = re.search(r"^; filament used \[mm\] = ([\d.]+)", text, re.M)
    time = re.search(r"^; estimated printing time \(normal mode\) = (.+)$", text, re.M)
    if not filament or not time:
        raise EngineError(f"PrusaSlicer wrote no time or filament into {gcode.name}")
    days, hours, minutes, seconds = (int(part or 0) for part in DURATION.fullmatch(time[1].strip()).groups())
    warnings = [line.partition("print warning:")[2].strip() for line in done.stdout.splitlines()
                if "print warning:" in line]
    return Run(((days * 24 + hours) * 60 + minutes) * 60.0 + seconds, float(filament[1]), tuple(warnings))


def _read_cura(done: subprocess.CompletedProcess, profile: Profile, gcode: Path) -> Run:
    """From the log: the G-code's own header is a form that the engine's caller fills in."""
    time = re.search(r"^Print time \(s\): ([\d.]+)", done.stderr, re.M)
    volume = re.search(r"^Filament \(mm\^3\): ([\d.]+)", done.stderr, re.M)
    if not time or not volume:
        raise EngineError(f"CuraEngine says no time or filament: {_tail(done)}")
    told = [line for line in done.stderr.splitlines() if line.startswith(("[WARNING]", "[ERROR]"))]
    warnings = [line.partition("]")[2].strip() for line in told
                if not any(own in line for own in (" -s ", "JSON setting"))]
    return Run(float(time[1]), float(volume[1]) / profile.filament_area, tuple(dict.fromkeys(warnings)))


def _end_of(path: Path, size: int = 200_000) -> str:
    with open(path, "rb") as file:
        file.seek(max(0, path.stat().st_size - size))
        return file.read().decode(errors="replace")
