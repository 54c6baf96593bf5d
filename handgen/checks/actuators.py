"""Rules on the actuators' numbers: their layers, and how they fill their bores."""

from __future__ import annotations

from handgen.checks.rule import RULES, Finding, Outcome, judged, skipped
from handgen.parameters.derive import tightest
from handgen.parameters.model import Hand

ROUNDING = 1e-6


def layers(hand: Hand) -> Outcome:
    """At the tip the asked layers must leave room for a small core that prints and can be pulled.

    Where `adapt` lets them be thinned the rule is overridden, and every place of it is listed.
    """
    rule, least = RULES["actuator.layers"], hand.casting.minimum_core_tip_diameter
    rooms = {name: hand.layers_of(name).core_room(a.tip_outer_diameter)
             for name, a in hand.actuators.present().items()}
    findings = [
        Finding(rule.name, "warning", f"actuators/{name}", room, least, rule.unit,
                f"the layers leave a small core of {room:g} mm at the tip; thinned to leave {least:g} mm",
                f"widen actuators.{name}.tip_outer_diameter, thin its layers, or accept the adaptation",
                rule.source)
        for name, room in rooms.items() if room < least - ROUNDING
    ]
    measured = min(rooms.values())
    if findings:
        reason = f"layers thinned in {len(findings)} actuators, see adaptations (`adapt: true`)"
        return Outcome(rule.name, "overridden", measured, least, rule.unit, reason, tuple(findings))
    return judged(rule.name, measured, least, "narrowest small core", [])


def clearance(hand: Hand) -> Outcome:
    """Nowhere may an actuator be wider than the bore that it slides into."""
    rule = RULES["actuator.clearance"]
    pairs = _pairs(hand)
    if not pairs:
        return skipped(rule.name, "no actuator fills a finger")
    gaps, findings = [], []
    for name, (actuator, finger) in pairs.items():
        x, outside, bore = tightest(actuator, finger)
        gaps.append(bore - outside)
        if gaps[-1] < rule.limit - ROUNDING:
            findings.append(Finding(
                rule.name, "error", f"actuators/{name}", gaps[-1], rule.limit, rule.unit,
                f"{outside:.2f} mm wide in a bore of {bore:.2f} mm", "narrow the actuator or widen the bore",
                rule.source, (x, 0.0, 0.0)))
    return judged(rule.name, min(gaps), rule.limit, "least difference of diameters", findings)


def length(hand: Hand) -> Outcome:
    """An actuator ends where its bore ends: longer does not fit, shorter leaves a joint unmoved."""
    rule = RULES["actuator.length"]
    pairs = _pairs(hand)
    if not pairs:
        return skipped(rule.name, "no actuator fills a finger")
    gaps = {name: finger.inner_length - actuator.outer_length for name, (actuator, finger) in pairs.items()}
    findings = [
        Finding(rule.name, "error" if gap < 0 else "warning", f"actuators/{name}", gap, rule.limit, rule.unit,
                f"ends {abs(gap):g} mm {'beyond' if gap < 0 else 'before'} the end of its bore",
                f"set actuators.{name}.outer_length to {pairs[name][1].inner_length:g}", rule.source)
        for name, gap in gaps.items() if not -ROUNDING <= gap <= rule.limit + ROUNDING
    ]
    worst = max(gaps.values(), key=abs)
    return judged(rule.name, worst, rule.limit, "bore left empty at the tip", findings)


def _pairs(hand: Hand) -> dict:
    fingers = hand.fingers.present()
    return {name: (actuator, fingers[name])
            for name, actuator in hand.actuators.present().items() if name in fingers}
