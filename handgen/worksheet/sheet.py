"""`handgen worksheet`: gathers what the sheet says and writes worksheet.html."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from handgen import atomic
from handgen.errors import EngineError
from handgen.export import preview
from handgen.geometry.actuator import refuse_forbidden
from handgen.geometry.tooling import tooling
from handgen.parameters.load import Loaded, load
from handgen.worksheet import bill, pictures, prints, silicone, timeline
from handgen.worksheet.bill import Line, Winding
from handgen.worksheet.prints import Print
from handgen.worksheet.silicone import Portion, Pour
from handgen.worksheet.timeline import Timeline

FILE = "worksheet.html"
COMPARED = (1, 2, 7)
"""Numbers of moulds that the sheet compares, beside that at hand."""
LEFT_OUT = ("the sheet has no pictures: this machine cannot draw off screen; "
            f"on Debian: apt install {preview.PACKAGES}")


@dataclass(frozen=True)
class Sheet:
    """Everything that stands on the page."""

    loaded: Loaded
    prints: list[Print]
    hand_volume: float | None
    """Of the exoskeleton, mm3; None where there is no whole hand."""
    pours: dict[str, list[Pour]]
    windings: list[Winding]
    timelines: dict[int, Timeline]
    bill: list[Line]
    pictures: dict[str, tuple[str, ...]]
    """Actuator -> data URIs."""

    @property
    def day(self) -> Timeline:
        """With the moulds at hand."""
        return self.timelines[self.loaded.hand.casting.mould_sets]

    def numbers(self, actuator: str) -> dict[str, str]:
        """Role -> number of an actuator's tooling."""
        return {one.part.role: one.number for one in self.prints
                if one.part.name.startswith(f"tooling/{actuator}/")}

    def mixed(self, pours: list[timeline.Step]) -> Portion:
        """What one mix of the day takes."""
        filled = [pour for step in pours for pour in self.pours[step.actuators[0]]
                  if pour.layer == step.layer]
        return silicone.portion(filled, self.loaded.hand.casting)


def worksheet(params: str | os.PathLike, out: str | os.PathLike | None = None, moulds: int | None = None,
              progress: Callable[[str], None] | None = None) -> dict[str, Any]:
    """Write the worksheet of the parameter file `params` into `out` (`outputs/<name>`).

    `moulds` stands for `casting.mould_sets`. Times and masses of prints come from `handgen slice`, where that
    was run into the same folder. Returns {"name", "file", ...}: what the page says, as plain data.

    Raises:
        InputError: bad parameters, or layers that leave no core and may not be thinned.
        GeometryError: a part cannot be made.
    """
    from handgen.worksheet.page import page

    loaded = load(params)
    if moulds is not None:
        casting = loaded.hand.casting.model_copy(update={"mould_sets": moulds})
        loaded = Loaded(loaded.hand.model_copy(update={"casting": casting}), loaded.file, loaded.sha256,
                        loaded.assumptions)
    refuse_forbidden(loaded.hand, str(loaded.file))
    folder = Path(out) if out is not None else Path("outputs") / loaded.hand.name
    sheet = gather(loaded, folder, progress or (lambda line: None))
    atomic.write(folder / FILE, page(sheet))
    return document(sheet, str(folder / FILE))


def gather(loaded: Loaded, folder: Path, say: Callable[[str], None]) -> Sheet:
    """All numbers and pictures; a machine that cannot draw costs the pictures only."""
    hand = loaded.hand
    names = list(hand.actuators.present())
    wound = bill.windings(hand)
    poured = {name: silicone.pours(hand, name) for name in names}
    durations = timeline.Durations.of(hand.casting, {w.actuator: w.turns for w in wound})
    days = {n: timeline.plan(durations, n) for n in sorted({*COMPARED, hand.casting.mould_sets})}
    printed = prints.prints(hand, folder)
    whole = next((one.part for one in printed if one.profile.column == "hand"), None)
    volume = None if whole is None else float(whole.mesh.volume)
    sheet = Sheet(loaded, printed, volume, poured, wound, days, [], {})
    mixed = [sheet.mixed(pours) for _, pours in sheet.day.mixes]
    mixed += [silicone.portion([pour], hand.casting) for made in poured.values() for pour in made
              if pour.layer == silicone.TIP]
    return replace(sheet, bill=bill.bill(hand, printed, mixed), pictures=_pictures(sheet, names, say))


def _pictures(sheet: Sheet, names: list[str], say: Callable[[str], None]) -> dict[str, tuple[str, ...]]:
    shown, hand = {}, sheet.loaded.hand
    for name in names:
        try:
            tools = pictures.tools(tooling(hand, name), sheet.numbers(name))
            shown[name] = tools, pictures.filled(hand, name)
        except EngineError as error:
            say(f"warning: {LEFT_OUT} ({error})")
            return {}
        say(f"{name}: drawn")
    return shown


def document(sheet: Sheet, file: str) -> dict[str, Any]:
    """The sheet's numbers as plain data."""
    casting = sheet.loaded.hand.casting
    seconds, grams, unknown = prints.total([one for one in sheet.prints if one.needed])
    return {
        "schema": "handgen.worksheet/1", "name": sheet.loaded.hand.name, "file": file,
        "prints": {"time_s": seconds, "filament_g": round(grams, 1), "not_sliced": unknown},
        "pours": [{"actuator": name, "layer": pour.layer, "cavity_mm3": round(pour.cavity, 1),
                   "cup_mm3": round(pour.cup, 1)} for name, made in sheet.pours.items() for pour in made],
        "mixes": [{"start_min": round(mix.start, 2), "fills": [[s.actuators[0], s.layer] for s in pours],
                   **{k: round(v, 2) for k, v in vars(sheet.mixed(pours)).items()}}
                  for mix, pours in sheet.day.mixes],
        "mould_sets": casting.mould_sets,
        "days": {str(n): {"hours": round(day.end / 60, 3), "at_least_hours": round(day.bound / 60, 3)}
                 for n, day in sheet.timelines.items()},
        "cost": {"currency": sheet.loaded.hand.prices.currency, "sum": round(bill.cost(sheet.bill)[0], 2),
                 "without_price": bill.cost(sheet.bill)[1]},
    }
