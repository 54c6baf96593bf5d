"""Masses and times of the print beside the source's, and why they differ."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

from handgen.builder.survey import Survey
from handgen.parameters.model import Hand
from handgen.report import markup
from handgen.report.dimensions import source
from handgen.slicing import known

HAND = "exoskeleton/hand"
WORKSHEET = "worksheet.html"
UNSLICED = "Not sliced yet: `handgen slice` adds the times and masses of a real slicer."
MM3 = 1e-3
"""cm3."""


def density(hand: Hand, part) -> float | None:
    """g/cm3 of what fills the part; None for tooling, whose infill only a slicer knows."""
    if part.role == "actuator":
        return hand.casting.silicone.density
    if part.role != "exoskeleton":
        return None
    return (hand.printing.hand if part.name == HAND else hand.printing.finger).density


def masses(survey: Survey) -> dict[str, float | None]:
    """Part -> g, filled; None where the infill decides."""
    found = {}
    for name, each in survey.parts.items():
        dense = density(survey.loaded.hand, each.part)
        found[name] = None if dense is None else dense * each.facts.volume_mm3 * MM3
    return found


def worksheet(folder: Path) -> str | None:
    """Where the worksheet lies, relative to `folder`."""
    places = (folder / WORKSHEET, *sorted(folder.glob(f"*/{WORKSHEET}")))
    return next((file.relative_to(folder).as_posix() for file in places if file.exists()), None)


def section(survey: Survey, folder: Path) -> str:
    """Print time and mass of the hand, ours and the source's; every sliced part."""
    sliced, content = known.rows(survey.loaded.hand, folder), []
    if HAND in survey.parts:
        content += [_beside(survey, sliced), *(f"<p>{words}</p>" for words in _why(survey, sliced))]
    if sliced:
        content.append(markup.folded(f"All sliced parts ({len(sliced)})", _sliced(sliced)))
    else:
        content.append(markup.quiet(UNSLICED))
    if (place := worksheet(folder)) is not None:
        content.append(f'<p><a href="{markup.text(place)}">Worksheet for casting and assembly</a></p>')
    return markup.section("making", "Print time and mass", *content)


def _beside(survey: Survey, sliced: Iterable[dict[str, Any]]) -> str:
    told = source()["hand"]
    ours = survey.parts[HAND]
    length = ours.facts.bbox_mm[1][0] - ours.facts.bbox_mm[0][0]
    curled = any(joint.rest_angle for finger in survey.loaded.hand.fingers.present().values()
                 for joint in finger.joints)
    rows = [
        ("length", told["length"], length, "mm", "measured on the mesh" + ", fingers curled" * curled),
        ("volume", told["volume"], ours.facts.volume_mm3 * MM3, "cm3", "measured on the mesh"),
        ("mass", told["mass"], masses(survey)[HAND], "g", "filled; volume times filament density"),
    ]
    for row in (r for r in sliced if r["part"] == HAND):
        words = f"sliced by {row['slicer']}"
        rows += [("mass", told["mass"], row["filament_g"], "g", f"{words}, with supports"),
                 ("print time", told["time"], row["print_time_s"] / 3600.0, "h", words)]
    heads = ["", "source", "ours", "unit", "ours is", "source's place"]
    return markup.table("The hand beside the source's", heads, [
        (markup.text(what), markup.number(theirs["value"]), markup.number(value, 1), unit, markup.text(how),
         markup.text(theirs["where"])) for what, theirs, value, unit, how in rows], (1, 2))


def _why(survey: Survey, sliced: Iterable[dict[str, Any]]) -> Iterable[str]:
    """Why the source's mass and time fit each other but not its volume; worked out from its own settings."""
    told, process = source()["hand"], survey.loaded.hand.printing.hand
    rate = process.rate * 3600.0 * MM3
    volume, mass, hours = (told[key]["value"] for key in ("volume", "mass", "time"))
    weighed = mass / process.density
    yield markup.text(
        f"The source's numbers do not fit together: laying down its {volume:.1f} cm3 at "
        f"{process.nozzle_size:g} x {process.layer_height:g} mm and {process.speed:g} mm/s "
        f"({rate:.2f} cm3 an hour, no travel) takes at least {volume / rate:.0f} hours, not about {hours:g}. "
        f"Its {mass:g} g of filament of {process.density:g} g/cm3 are {weighed:.1f} cm3, "
        f"{weighed / volume:.0%} of that volume, and take {weighed / rate:.0f} hours.")
    yield markup.text(
        "So its print laid down about that share of the drawn volume: it was under-extruded or porous, as "
        f"its own density of {mass / volume:.3f} g/cm3 says too. Ours are the numbers of a solid print; they "
        "are not tuned to match.")
    if any(row["part"] == HAND for row in sliced):
        yield f"Slicers add {process.flow:g} % flow, support and travel to that least time."


def _sliced(rows: Iterable[dict[str, Any]]) -> str:
    return markup.table("Sliced parts", ["part", "slicer", "hours", "filament, g", "layers"], [
        (markup.text(row["part"]), markup.text(f"{row['slicer']} {row.get('version', '')}".strip()),
         markup.number(row["print_time_s"] / 3600.0), markup.number(row["filament_g"], 1),
         markup.text(row.get("layers", ""))) for row in rows], (2, 3, 4))
