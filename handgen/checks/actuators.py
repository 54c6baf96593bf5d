"""Rules on the actuators' numbers: their layers, and how they fill their bores."""

from __future__ import annotations

from collections.abc import Mapping

from handgen.checks.limits import Limits
from handgen.checks.rule import Finding, Outcome, judged, skipped
from handgen.geometry.part import Part
from handgen.parameters.derive import tightest
from handgen.parameters.finger import Actuator, Finger
from handgen.parameters.model import Hand

ROUNDING = 1e-6


def present(hand: Hand, parts: Mapping[str, Part]) -> dict[str, Actuator]:
    """The hand's actuators by name, those that are among `parts`."""
    return {name: a for name, a in hand.actuators.present().items() if f"actuators/{name}" in parts}


def layers(hand: Hand, parts: Mapping[str, Part], limits: Limits) -> Outcome:
    """At the tip the asked layers must leave room for a small core that prints and can be pulled.

    The least room is a parameter, as the core is cut to it. Where `adapt` lets the layers be
    thinned the rule is overridden, and every place of it is listed; where it does not they are errors.
    """
    rule, least = "actuator.layers", hand.casting.minimum_core_tip_diameter
    found = present(hand, parts)
    if not found:
        return skipped(rule, "no actuator in this build")
    rooms = {name: hand.layers_of(name).core_room(a.tip_outer_diameter) for name, a in found.items()}
    findings = [_no_core(hand, name, a, rooms[name], least)
                for name, a in found.items() if rooms[name] < least - ROUNDING]
    measured = min(rooms.values())
    if findings and all(f.severity == "warning" for f in findings):
        reason = f"layers thinned in {len(findings)} actuators, see adaptations (`adapt: true`)"
        return Outcome(rule, "overridden", measured, least, "mm", reason, tuple(findings))
    return judged(rule, measured, least, "narrowest small core", findings)


def _no_core(hand: Hand, name: str, actuator: Actuator, room: float, least: float) -> Finding:
    widen = f"widen actuators.{name}.tip_outer_diameter, thin its layers"
    thinned = f"; thinned there to leave {least:g} mm" if actuator.adapt else ""
    return Finding(
        "actuator.layers", "warning" if actuator.adapt else "error", f"actuators/{name}", room, least, "mm",
        f"the layers leave a small core of {room:g} mm at the tip{thinned}",
        f"{widen}, or {'accept the adaptation' if actuator.adapt else 'let them be thinned (`adapt: true`)'}",
        "Table A.2; casting.minimum_core_tip_diameter",
        (actuator.outer_length - hand.layers_of(name).tip, 0.0, 0.0))


def clearance(hand: Hand, parts: Mapping[str, Part], limits: Limits) -> Outcome:
    """Nowhere may an actuator be wider than the bore that it slides into."""
    rule, least = "actuator.clearance", limits.get("actuator.clearance", "least")
    pairs = _pairs(hand, parts)
    if not pairs:
        return skipped(rule, "no actuator in this build fills a finger")
    gaps, findings = [], []
    for name, (actuator, finger) in pairs.items():
        x, outside, bore = tightest(actuator, finger)
        gaps.append(bore - outside)
        if gaps[-1] < least.value - ROUNDING:
            findings.append(Finding(
                rule, "error", f"actuators/{name}", gaps[-1], least.value, least.unit,
                f"{outside:.2f} mm wide in a bore of {bore:.2f} mm",
                f"narrow actuators.{name} or widen the bore of fingers.{name}",
                least.source, (x, 0.0, outside / 2)))
    return judged(rule, min(gaps), least.value, "least difference of diameters", findings)


def length(hand: Hand, parts: Mapping[str, Part], limits: Limits) -> Outcome:
    """An actuator ends where its bore ends: longer does not fit, shorter leaves a joint unmoved."""
    rule, most = "actuator.length", limits.get("actuator.length", "most_empty")
    pairs = _pairs(hand, parts)
    if not pairs:
        return skipped(rule, "no actuator in this build fills a finger")
    gaps = {name: finger.inner_length - actuator.outer_length for name, (actuator, finger) in pairs.items()}
    findings = [
        Finding(rule, "error" if gap < 0 else "warning", f"actuators/{name}", gap,
                0.0 if gap < 0 else most.value, most.unit,
                f"ends {abs(gap):g} mm {'beyond' if gap < 0 else 'before'} the end of its bore",
                f"set actuators.{name}.outer_length to {pairs[name][1].inner_length:g}", most.source,
                (pairs[name][0].outer_length, 0.0, 0.0))
        for name, gap in gaps.items() if not -ROUNDING <= gap <= most.value + ROUNDING
    ]
    worst = max(gaps.values(), key=lambda gap: max(-gap, gap - most.value))
    return judged(rule, worst, 0.0 if worst < 0 else most.value,
                  "bore left empty at the tip; below 0: the actuator stands out", findings)


def _pairs(hand: Hand, parts: Mapping[str, Part]) -> dict[str, tuple[Actuator, Finger]]:
    fingers = hand.fingers.present()
    return {name: (a, fingers[name]) for name, a in present(hand, parts).items() if name in fingers}
