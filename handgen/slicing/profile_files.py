"""`handgen profiles`: the print settings of a parameter file as files for the slicers."""

from __future__ import annotations

import os
from pathlib import Path

from handgen import atomic
from handgen.errors import EngineError
from handgen.parameters.load import load
from handgen.parameters.model import Hand
from handgen.slicing import cura, engines, prusaslicer
from handgen.slicing.printer import HEPHESTOS, generic
from handgen.slicing.profile import profiles

FOLDER = "slicer_profiles"
GENERIC = generic((220.0, 220.0, 250.0))
"""The commonest size of printer; a hand of 195 mm fits."""
MACHINES = (HEPHESTOS, GENERIC)
BUNDLE = "prusaslicer/handgen_bundle.ini"


def contents(hand: Hand) -> dict[str, bytes]:
    """Path below the folder -> content, of all files that need no slicer."""
    found = profiles(hand)
    files = {BUNDLE: prusaslicer.bundle(found, MACHINES).encode()}
    for one in found:
        files[f"cura/{one.name}.curaprofile"] = cura.curaprofile(one)
        for machine in MACHINES:
            files[f"prusaslicer/{machine.slug}/{one.name}.ini"] = prusaslicer.flat(one, machine).encode()
    return files


def engine_contents(hand: Hand) -> dict[str, bytes]:
    """The files for CuraEngine, whose formulas only the installed definitions know.

    Raises:
        EngineError: Cura's definitions are not installed.
    """
    if absent := engines.missing(engines.CURA):
        raise EngineError(absent)
    return {f"curaengine/{machine.slug}/{name}": content.encode()
            for one in profiles(hand) for machine in MACHINES
            for name, content in cura.engine_files(one, machine).items()}


def write(params: str | os.PathLike, out: str | os.PathLike | None = None) -> list[str]:
    """Write all files into `out` (slicer_profiles/); returns their paths.

    Raises:
        InputError: bad parameters.
        EngineError: Cura is not installed; then nothing is written.
    """
    hand = load(params).hand
    folder = Path(out) if out is not None else Path(FOLDER)
    files = contents(hand) | engine_contents(hand)
    for path, content in files.items():
        atomic.write(folder / path, content)
    return [str(folder / path) for path in sorted(files)]

