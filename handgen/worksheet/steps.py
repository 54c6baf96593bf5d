"""What to do, in words: Section 4.2.2 with the numbers of this hand."""

from __future__ import annotations

from collections.abc import Sequence

from handgen.parameters.model import OPPOSITION, Hand
from handgen.tables import hours
from handgen.worksheet.bill import Winding
from handgen.worksheet.silicone import FIRST, SECOND, TIP, Portion, Pour


def preparation(hand: Hand) -> list[str]:
    """Before the first mix."""
    casting = hand.casting
    return [
        f"Room at {casting.cure_temperature:g} degC or a little above, never below"
        f" {casting.minimum_cure_temperature:g} degC: colder, {casting.silicone.name} does not cure.",
        "Coat moulds and cores with XTC-3D or clear lacquer and let it dry. Pull on vinyl gloves: latex and"
        " sulphur keep platinum silicone from curing.",
        "Before anything is mixed, try every core in its suspender, every pair of halves in base and"
        " suspender.",
        "Stir part A and part B in their containers.",
    ]


def mixing(hand: Hand) -> str:
    """How every mix is made."""
    casting = hand.casting
    return (f"Every mix: weigh A and B into one cup and mix {casting.mixing_time:g} min, scraping sides and"
            f" bottom; let it settle {casting.settling_time:g} min. All its moulds must be full"
            f" {casting.silicone.pot_life:g} min after A met B. Tilt the cup slowly and pour in a thin thread"
            " through one gate, so that air leaves through the others. Less than 10 g in all needs a scale"
            " that shows 0.01 g.")


def actuator(hand: Hand, winding: Winding, pours: Sequence[Pour],
             numbers: dict[str, str]) -> list[tuple[str, list[str]]]:
    """(heading, steps) for one actuator; `numbers` are its parts' by role."""
    casting, n = hand.casting, numbers
    by_layer = {pour.layer: pour for pour in pours}
    cup = abs(casting.pour_height * casting.cup_fill / 100)
    first, second = (_amount(by_layer[layer], hand) for layer in (FIRST, SECOND))
    groups = [
        ("II. Outer layer with the thread", [
            f"Cut {winding.cut / 1000:.2f} m of {winding.material} thread, {winding.diameter:g} mm, and wind"
            f" {winding.turns:.1f} turns {winding.pitch:g} mm apart on the large core {n['core_large']}."
            " Clamp the end in the slot of the flange. Clean thread, not too tight, no adhesive tape.",
            f"Close {n['mould_a']} and {n['mould_b']}, stand them in the base {n['mould_base']}, put the"
            f" suspender {n['suspender']} on top, a rubber band in each groove. Hang {n['core_large']} in the"
            " suspender: its flange lies on the hub.",
            f"Pour {first} slowly, until the silicone stands {cup:.0f} mm above the actuator's base.",
            f"Let it cure {casting.silicone.cure_time:g} h.",
            f"Open the mould at the notches and pull {n['core_large']} slowly out of the layer: the thread"
            " stays in the silicone. This needs most care. Trim the layer at the actuator's base, where the"
            " cup begins.",
        ]),
        ("III. Inner layer", [
            f"Put the layer back, close the mould, hang the small core {n['core_small']} in the suspender"
            f" {n['suspender']}.",
            f"Pour {second} to the same height.",
            f"Let it cure {casting.silicone.cure_time:g} h, open, pull {n['core_small']}, trim the base.",
        ]),
    ]
    if TIP in by_layer:
        groups.append(("Tip", [
            f"Standing it on its tip, fill the hole there from inside with {_amount(by_layer[TIP], hand)};"
            f" let it cure {casting.silicone.cure_time:g} h."]))
    seal = "IV. Seal the base" + (", after the oven (6)" if casting.post_cure else "")
    groups.append((seal, [
        f"Push the air tube into the plug {n['plug']} and glue it with {casting.adhesive}.",
        f"Glue the plug {hand.seal.plug_length:g} mm deep into the channel, the collar {n['collar']} on its"
        " neck behind the silicone.",
        _leak(hand),
    ]))
    return groups


def post_cure(hand: Hand, end: float) -> list[str]:
    """After the last demoulding, which the plan has at `end` min, for all actuators together."""
    steps = [f"{step.hours:g} h at {step.temperature:g} degC" for step in hand.casting.post_cure]
    if not steps:
        return ["No oven: full strength takes about a week at room temperature."]
    out = end / 60 + sum(step.hours for step in hand.casting.post_cure)
    return [f"All actuators into the oven, lying, not touching, without plugs and collars, which are PLA:"
            f" {', then '.join(steps)}. By the plan from {hours(60 * end)} to {hours(3600 * out)}.",
            f"Let them cool to room temperature, {hand.casting.cooling_time:g} h, then seal and test every"
            f" one by step IV of its sheet, from {hours(3600 * (out + hand.casting.cooling_time))} on."]


def assembling(hand: Hand) -> list[str]:
    """The order in which the hand is put together."""
    names = list(hand.actuators.present())
    fingers = [name for name in names if name not in OPPOSITION]
    thumb = [name for name in names if name in OPPOSITION]
    steps = ["Remove all support from the exoskeleton, also from bores and slots; blow through every"
             " channel."]
    if thumb:
        steps.append(f"{' and '.join(t.replace('_', ' ') for t in thumb).capitalize()} first: base into its"
                     " socket, while the thumb can be bent out of the way.")
    return [
        *steps,
        f"Then {', '.join(fingers)}: wet with soapy water, push in tip first until the collar sits in the"
        " bore.",
        "Lead every tube to the wrist and mark it with its actuator's letter.",
        f"One actuator after the other, slowly to {hand.seal.leak_pressure:g} kPa: nothing may hiss. Then on"
        " to the working pressure, not beyond what the finger's bend was computed for.",
    ]


def _amount(pour: Pour, hand: Hand) -> str:
    portion = Portion.of(pour.ml, hand.casting)
    return (f"{pour.ml:.1f} ml (mixed for it alone: A {portion.a_g:.1f} g + B {portion.b_g:.1f} g,"
            f" {portion.a_ml:.1f} + {portion.b_ml:.1f} ml)")


def _leak(hand: Hand) -> str:
    return (f"Leak test: {hand.seal.leak_pressure:g} kPa, the actuator under water,"
            f" {hand.seal.leak_time:g} min without a bubble at base and tip.")
