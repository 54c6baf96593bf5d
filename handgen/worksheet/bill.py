"""Bill of materials: how much of everything, what it weighs and what it costs."""

from __future__ import annotations

import math
from dataclasses import dataclass

from handgen.geometry.actuator import thread_length, thread_turns
from handgen.parameters.model import Hand
from handgen.worksheet.prints import Print, total
from handgen.worksheet.silicone import Portion

CONSUMABLES = (
    ("rubber bands", "2 a mould"),
    ("vinyl gloves", "latex keeps the silicone from curing (Appendix C)"),
    ("mixing cups with straight sides, flat stirrers", "1 a mix"),
    ("syringe or spouted cup", "the gates are 3.5 mm wide"),
    ("XTC-3D or clear acrylic lacquer", "on moulds and cores, so that silicone comes off (Section 4.1.2)"),
)


@dataclass(frozen=True)
class Line:
    """One material; what is not known is None and left out of the sums."""

    item: str
    amount: str
    grams: float | None
    ml: float | None
    price: float | None
    note: str = ""


@dataclass(frozen=True)
class Winding:
    """The thread of one actuator, mm; `cut` is what to cut from the spool, both ends included."""

    actuator: str
    material: str
    diameter: float
    pitch: float
    turns: float
    length: float
    cut: float


def windings(hand: Hand) -> list[Winding]:
    found = []
    for name in hand.actuators.present():
        thread, length = hand.thread_of(name), thread_length(hand, name)
        found.append(Winding(name, thread.material, thread.diameter, thread.pitch, thread_turns(hand, name),
                             length, length + 2 * hand.casting.thread_ends))
    return found


def bill(hand: Hand, printed: list[Print], mixed: list[Portion]) -> list[Line]:
    """Everything that is bought by the gram, the metre or the piece."""
    return [*_filaments(hand, printed), *_silicone(hand, mixed), *_threads(hand), *_seals(hand)]


def cost(lines: list[Line]) -> tuple[float, list[str]]:
    """(sum of all known prices, items without one)."""
    return sum(line.price or 0.0 for line in lines), [line.item for line in lines if line.price is None]


def _filaments(hand: Hand, printed: list[Print]) -> list[Line]:
    lines = []
    for material in dict.fromkeys(one.profile.process.material for one in printed):
        chosen = [one for one in printed if one.profile.process.material == material]
        needed = [one for one in chosen if one.needed] or chosen
        _, grams, unknown = total(needed)
        known = grams > 0 and not unknown
        per_kg = hand.prices.filament.get(material)
        note = "single fingers, for trials: the hand has its own" if not needed[0].needed else ""
        lines.append(Line(
            f"{material} filament, {needed[0].profile.filament_diameter:g} mm",
            f"{len(needed)} part{'s' * (len(needed) > 1)}", grams if known else None,
            grams / needed[0].profile.process.density if known else None,
            per_kg * grams / 1000 if known and per_kg is not None else None,
            note if known else "run handgen slice for the mass"))
    return lines


def _silicone(hand: Hand, mixed: list[Portion]) -> list[Line]:
    silicone, per_kg = hand.casting.silicone, hand.prices.silicone
    lines = []
    for part, ml, grams in (("A", sum(m.a_ml for m in mixed), sum(m.a_g for m in mixed)),
                            ("B", sum(m.b_ml for m in mixed), sum(m.b_g for m in mixed))):
        lines.append(Line(f"{silicone.name} part {part}", f"{len(mixed)} mixes", grams, ml,
                          None if per_kg is None else per_kg * grams / 1000,
                          f"with {hand.casting.mixing_loss:g} % loss"))
    return lines


def _threads(hand: Hand) -> list[Line]:
    wound = windings(hand)
    lines = []
    for kind in dict.fromkeys((w.material, w.diameter) for w in wound):
        metres = sum(w.cut for w in wound if (w.material, w.diameter) == kind) / 1000
        ml = metres * 1000 * math.pi * kind[1] ** 2 / 4 / 1000
        price = None if hand.prices.thread is None else hand.prices.thread * metres
        lines.append(Line(f"{kind[0]} thread, {kind[1]:g} mm", f"{metres:.1f} m", None, ml, price,
                          f"with {hand.casting.thread_ends:g} mm at each end"))
    return lines


def _seals(hand: Hand) -> list[Line]:
    seal, count = hand.seal, len(hand.actuators.present())
    metres = count * seal.tube_length / 1000
    return [
        Line(f"air tube, {seal.tube_outer_diameter:g} mm outside", f"{metres:.1f} m", None, None,
             None if hand.prices.tube is None else hand.prices.tube * metres,
             f"{count} of {seal.tube_length:g} mm"),
        Line(hand.casting.adhesive, "1 bottle", None, None, hand.prices.adhesive, "plugs, collars, tubes"),
    ]
