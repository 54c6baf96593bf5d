"""An ensemble of fingers within tolerance of the drawn one: what a model of a drawing gets wrong."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from handgen.geometry.profile import ActuatorProfile, FingerProfile
from handgen.simulation.case import Case, Substance

TOLERANCES: Mapping[str, float] = {
    "joint 1": 0.5, "joint 2": 0.5, "joint 3": 0.5,
    "rest 1": 1.5, "rest 2": 1.0, "rest 3": 1.0,
    "slot": 0.3, "arc": 4.0, "outside": 0.15, "bore": 0.1,
    "wall": 0.1, "depth": 0.05, "pitch": 0.1, "held": 1.0, "density": 0.03,
}
"""Standard deviations: mm; deg of rests and arc; density as a share. FFF prints to 0.1 to 0.3 mm and warps by
a degree or two; layers are cast against printed cores; a thread is wound by hand."""
MEMBERS = 32


def members(count: int = MEMBERS, seed: int = 0) -> list[dict[str, float]]:
    """Deviations of `count` fingers, quasi-random (Sobol) and normal, each within 2.5 deviations."""
    from scipy.stats import norm, qmc

    uniform = qmc.Sobol(len(TOLERANCES), seed=seed).random(count)
    low, high = norm.cdf(-2.5), norm.cdf(2.5)
    normal = norm.ppf(low + uniform * (high - low))
    return [{name: float(sigma * z) for (name, sigma), z in zip(TOLERANCES.items(), row, strict=True)}
            for row in normal]


def deviating(case: Case, by: Mapping[str, float]) -> Case:
    """`case` of a finger that deviates `by` so much from its drawing."""
    changes: dict = {
        "tpu": _weighing(case.tpu, by["density"]), "silicone": _weighing(case.silicone, by["density"])}
    if case.finger is not None:
        changes["finger"] = _finger(case.finger, by)
    if case.actuator is not None:
        changes["actuator"] = _actuator(case.actuator, by)
        changes["held"] = max(case.held + by["held"], 0.0) if case.held else 0.0
    if case.winding is not None:
        changes["winding"] = replace(case.winding, depth=case.winding.depth + by["depth"],
                                     pitch=case.winding.pitch + by["pitch"])
    return replace(case, **changes)


def _weighing(substance: Substance | None, share: float) -> Substance | None:
    return None if substance is None else replace(substance, density=substance.density * (1 + share))


def _finger(profile: FingerProfile, by: Mapping[str, float]) -> FingerProfile:
    finger = profile.finger
    joints = [joint.model_copy(update={
        "position": joint.position + by.get(f"joint {i}", 0.0),
        "slot_length": max(joint.slot_length + by["slot"], 2.0),
        "palmar_arc": min(max(joint.palmar_arc + by["arc"], 30.0), 180.0),
        "rest_angle": max(joint.rest_angle + by.get(f"rest {i}", 0.0), 0.0)})
        for i, joint in enumerate(finger.joints, start=1)]
    return FingerProfile(finger.model_copy(update={
        "joints": joints,
        **{f"{end}_outer_diameter": getattr(finger, f"{end}_outer_diameter") + 2 * by["outside"]
           for end in ("base", "tip")},
        **{f"{end}_bore_diameter": getattr(finger, f"{end}_bore_diameter") + 2 * by["bore"]
           for end in ("base", "tip")}}))


def _actuator(profile: ActuatorProfile, by: Mapping[str, float]) -> ActuatorProfile:
    layers = profile.layers
    return replace(profile, layers=layers.model_copy(update={"internal": layers.internal + by["wall"]}))
