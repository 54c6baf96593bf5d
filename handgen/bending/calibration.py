"""Fit what the source's tests of the single parts determine: `python -m handgen.bending.calibration`.

Two fits, apart from each other and from every test of the finger as a whole:

- silicone, from the free actuator (Table 5.6 up to 50 kPa): the exponent of a one-term Ogden law that meets
  the bulletin's stress at 100 % strain. The bulletin gives that one stress; the actuator works at a fifth of
  that strain, and there a neo-Hookean law of the same stress is a quarter too soft. Base held over the
  plug's length, thread as wound: the hand's.
- joints, from the bare exoskeleton (Table 5.4): place and rest angle of the MCP joint, arc of the strips,
  with the source's tuned set 3 for Ninjaflex. The source tuned it on the same table with the real joints in
  its CAD; here the joints are inferred with it.

Everything else that would serve as well is varied one by one, and the fit is repeated: that is the range of
what these tables cannot determine. Writes params/models/calibrated.yaml and says what belongs into
params/thesis_hand.yaml.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from handgen.bending.comparison import asked, gap, observed
from handgen.bending.fitting import Assumption, Fit, Simulate, Unknown, fit, spread
from handgen.bending.model import FOLDER, load_model
from handgen.bending.run import solve
from handgen.geometry.profile import FingerProfile
from handgen.materials import library
from handgen.materials.law import Law, ogden_law
from handgen.measurements.load import Measured, load_measurements
from handgen.measurements.model import Test
from handgen.simulation.case import Case

MEASUREMENTS = FOLDER.parent / "measurements" / "coimbra_index.yaml"
FILE = FOLDER / "calibrated.yaml"
BASE = "literature"
"""Model that everything which is not fitted is taken from."""
SILICONE, TPU_SET = "Ecoflex 00-50", "ninjaflex-mooney-rivlin-3"

EXPONENT = Unknown("alpha", "1", 2.0, 1.0, 4.0, 2)
"""From neo-Hookean (2) on; below 1 no rubber is stable."""
JOINTS = (
    Unknown("position", "mm", 15.0, 8.0, 25.0, 1),
    Unknown("palmar_arc", "deg", 90.0, 40.0, 170.0, 0),
    Unknown("rest_angle", "deg", 20.0, 0.0, 60.0, 1),
)
SILICONE_ASSUMPTIONS: dict[str, dict] = {
    "the bulletin's stress 10 % lower": {"share": 0.9},
    "the bulletin's stress 10 % higher": {"share": 1.1},
    "base held over 5 mm, not 10": {"held": 5.0},
    "base held over 15 mm, not 10": {"held": 15.0},
    "thread on the core's own radius": {"depth": 0.0},
    "thread in the middle of its drawn layer": {"depth": 0.25},
    "true pressure 3.5 kPa below the reading": {"offset": -3.5e-3},
    "true pressure 3.5 kPa above the reading": {"offset": 3.5e-3},
}
JOINT_ASSUMPTIONS: dict[str, dict] = {
    "modulus 0.48 of set 1 (density ratio 0.695, squared)": {"modulus": 0.48 / 0.317},
    "modulus of set 1 (literature)": {"modulus": 1 / 0.317},
    "slots of 6 mm": {"slot": 6.0},
    "slots of 12 mm": {"slot": 12.0},
    "rest curl shared over the joints, .40 .35 .25": {"shares": (0.40, 0.35, 0.25)},
    "finger hangs from its root, joints straight": {"shares": (0.0,), "root": 1.0},
    "PIP and DIP joint 3 mm nearer to the root": {"shift": -3.0},
    "PIP and DIP joint 3 mm farther from the root": {"shift": 3.0},
}
Progress = Callable[[str], None]


@dataclass(frozen=True)
class Calibration:
    """Both fits with all that was assumed."""

    silicone: Fit
    silicone_others: Sequence[Assumption]
    joints: Fit
    joints_others: Sequence[Assumption]
    actuator: Test
    exoskeleton: Test


def calibrate(file: Path = MEASUREMENTS, progress: Progress = lambda line: None) -> Calibration:
    """Both fits on the measurements `file`.

    Raises:
        InputError: of the measurements or the hand.
        EngineError: the solver gave up on the way.
    """
    measured = load_measurements(file)
    actuator, exoskeleton = measured.test("actuator-pressure"), measured.test("exoskeleton-weights")
    free = simulator(measured, actuator, with_silicone)
    bare = simulator(measured, exoskeleton, with_joints)
    silicone = _fits(actuator, (EXPONENT,), free, SILICONE_ASSUMPTIONS, progress)
    joints = _fits(exoskeleton, JOINTS, bare, JOINT_ASSUMPTIONS, progress)
    return Calibration(*silicone, *joints, actuator, exoskeleton)


def simulator(measured: Measured, test: Test, change: Callable[..., Case]) -> Simulate:
    """(values, assumptions) -> readings of `test` with its case changed by them."""
    base = asked(measured, test, BASE)

    def simulate(values, **assumptions) -> list[float | None]:
        case = change(base.case, values, **assumptions)
        return observed(test, solve(replace(base, case=case)).curve)

    return simulate


def _fits(test: Test, unknowns, simulate, assumptions, progress: Progress) -> tuple[Fit, list[Assumption]]:
    progress(f"{test.title}: {', '.join(u.name for u in unknowns)}")
    found = fit(test, unknowns, simulate)
    others = []
    for what, assumption in assumptions.items():
        progress(f"  if {what}")
        others.append(Assumption(what, fit(test, unknowns, simulate, found.values, **assumption)))
    return found, others


# Silicone


def silicone_law(alpha: float, share: float = 1.0) -> Law:
    """One-term Ogden law whose nominal stress at 100 % is `share` of the bulletin's."""
    return ogden_law([_shear(alpha, share)], [alpha], "2mu/alpha^2")


def _shear(alpha: float, share: float = 1.0) -> float:
    """Its shear modulus at no strain, MPa, to 0.1 kPa."""
    import numpy as np

    from handgen.materials.states import UNIAXIAL, nominal_stress

    (reading,) = library.material(SILICONE).readings
    law = ogden_law([1.0], [alpha], "2mu/alpha^2")
    unit = float(nominal_stress(law, UNIAXIAL, np.array(1 + reading.strain)))
    return round(share * reading.megapascals / unit, 4)


def with_silicone(case: Case, values: Mapping[str, float], *, share: float = 1.0, held: float | None = None,
                  depth: float | None = None, offset: float = 0.0) -> Case:
    """`case` with the silicone of `values`, and what SILICONE_ASSUMPTIONS vary (`offset`: MPa)."""
    law = silicone_law(values["alpha"], share)
    ratio = case.silicone.bulk / case.silicone.law.shear_modulus
    return replace(
        case, silicone=replace(case.silicone, law=law, bulk=ratio * law.shear_modulus),
        winding=case.winding if depth is None else replace(case.winding, depth=depth),
        held=case.held if held is None else held,
        pressures=tuple(max(p + offset, 0.0) for p in case.pressures))


# Joints


def with_joints(case: Case, values: Mapping[str, float], *, modulus: float = 1.0, slot: float | None = None,
                shares: Sequence[float] = (1.0,), shift: float = 0.0, root: float = 0.0) -> Case:
    """`case` with the exoskeleton of `values`, and what JOINT_ASSUMPTIONS vary; `modulus`: times set 3's,
    `root`: share of the rest angle by which the finger hangs from its root."""
    chosen = library.parameter_set(TPU_SET)
    law = chosen.build()
    law = Law(law.name, tuple(modulus * constant for constant in law.constants))
    ratio = case.tpu.bulk / case.tpu.law.shear_modulus
    tpu = replace(case.tpu, law=law, bulk=ratio * law.shear_modulus, density=library.density(chosen))
    return replace(case, tpu=tpu, finger=_jointed(case, values, slot, shares, shift),
                   root_angle=math.radians(root * values["rest_angle"]))


def _jointed(case: Case, values: Mapping[str, float], slot: float | None, shares: Sequence[float],
             shift: float) -> FingerProfile:
    """The finger with its joints as fitted and assumed."""
    finger = case.finger.finger
    joints = []
    for i, joint in enumerate(finger.joints):
        share = shares[i] if i < len(shares) else 0.0
        joints.append(joint.model_copy(update={
            "position": values["position"] if i == 0 else joint.position + shift,
            "slot_length": joint.slot_length if slot is None else slot,
            "palmar_arc": values["palmar_arc"],
            "rest_angle": share * values["rest_angle"]}))
    return FingerProfile(finger.model_copy(update={"joints": joints}))


# What is written


def table(found: Calibration) -> str:
    """Values, ranges and residuals, for people."""
    lines = []
    for test, unknowns, fitted, others in _parts(found):
        held_out = gap(test, fitted.simulated, fitted=False)
        lines += [test.title, *(_line(unknown, fitted, others) for unknown in unknowns), _misfit(fitted)]
        if held_out:
            lines.append(f"  not fitted: {held_out.count} load(s), largest {held_out.largest:+.2f} mm")
        lines += [f"    {_values(unknowns, other.fit)}{_misfit(other.fit)}   if {other.what}"
                  for other in others]
    return "\n".join(lines)


def _parts(found: Calibration):
    return ((found.actuator, (EXPONENT,), found.silicone, found.silicone_others),
            (found.exoskeleton, JOINTS, found.joints, found.joints_others))


def _line(unknown: Unknown, fitted: Fit, others: Sequence[Assumption]) -> str:
    low, high = spread(unknown.name, fitted, others)
    value, sigma, places = fitted.values[unknown.name], fitted.deviations[unknown.name], unknown.places
    return (f"  {unknown.name:<12}{value:>8.{places}f} {unknown.unit:<4} +- {sigma:.{places + 1}f} by the "
            f"repeats, {low:.{places}f} to {high:.{places}f} with all assumptions")


def _misfit(fitted: Fit) -> str:
    g = fitted.gap
    relative = f", {100 * g.rms_relative:.1f} %" if g.rms_relative is not None else ""
    return f"  RMS {g.rms:.2f} mm{relative}, largest {g.largest:+.2f} mm"


def _values(unknowns: Sequence[Unknown], fitted: Fit) -> str:
    return "".join(f"{u.name} {fitted.values[u.name]:.{u.places}f}  " for u in unknowns)


def model_text(found: Calibration) -> str:
    """params/models/calibrated.yaml."""
    alpha = found.silicone.values["alpha"]
    low, high = spread("alpha", found.silicone, found.silicone_others)
    arc_low, arc_high = spread("palmar_arc", found.joints, found.joints_others)
    return TEXT.format(
        alpha=alpha, mu=1e3 * _shear(alpha), low=low, high=high, arc=found.joints.values["palmar_arc"],
        arc_low=arc_low, arc_high=arc_high, percent=100 * found.silicone.gap.rms_relative,
        rms=found.joints.gap.rms, friction=load_model(BASE)[0].friction,
        fitted=", ".join((found.exoskeleton.id, found.actuator.id)))


TEXT = """\
# Written by `python -m handgen.bending.calibration`; do not edit. Fitted on the source's tests of the
# single parts: Table 5.4, and Table 5.6 up to 50 kPa. Nothing here has seen the finger as a whole (Table 5.8,
# fingertip force).
schema: handgen.model/1
name: calibrated
description: Fitted on the free actuator up to 50 kPa and on the bare exoskeleton, nothing else

materials:
  # RMS {rms:.2f} mm on Table 5.4, with the index joints of params/thesis_hand.yaml
  Ninjaflex: ninjaflex-mooney-rivlin-3
  # RMS {percent:.1f} % on Table 5.6 up to 50 kPa
  Ecoflex 00-50:
    law: ogden
    convention: 2mu/alpha^2
    unit: kPa
    constants: {{mu: [{mu:.1f}], alpha: [{alpha:.2f}]}}
    strain: [0, 1]
    source: alves2020
    notes:
      - The bulletin's 12 psi at 100 %; the exponent alone is fitted.
    assumed:
      - >-
        alpha is {low:.2f} to {high:.2f} if the bulletin's stress is off by 10 %, the base held over 5 to
        15 mm, the thread up to 0.25 mm outside the core, or the pressure sensor off by 3.5 kPa:
        these trade for it one by one
  # Not measured by the source: as in the literature
  Filaflex 82A: filaflex-82a-mooney-rivlin
  Ecoflex 00-30: ecoflex-00-30-neo-hookean
  Dragon Skin 30: dragon-skin-30-neo-hookean

friction: {friction:g}

fitted: [{fitted}]

assumed:
  friction: silicone on TPU, not measured, not fitted; literature.yaml says where it comes from
  materials.Ninjaflex: >-
    the source tuned set 3 on Table 5.4 with the real joints in its CAD. Modulus and arc of the strips
    trade one for the other: {arc:.0f} degrees with this set, {arc_low:.0f} to {arc_high:.0f} with other
    moduli up to the literature's, other slots, another curl

sources:
  alves2020: Alves, Coimbra 2020, Tables 5.4 and 5.6; the bulletin is its Appendix C
"""


def joints_text(found: Calibration) -> str:
    """What belongs into params/thesis_hand.yaml."""
    v = found.joints.values
    return (f"thesis_hand.yaml, fingers.index.joints: MCP position {v['position']:.1f}, rest_angle "
            f"{v['rest_angle']:.1f}; palmar_arc {v['palmar_arc']:.0f} of all")


def main() -> None:
    """Fit, tell, write."""
    found = calibrate(progress=lambda line: print(line, flush=True))
    print("\n" + table(found))
    FILE.write_text(model_text(found), encoding="utf-8")
    print(f"\nwrote {FILE.name}\n{joints_text(found)}")


if __name__ == "__main__":
    main()
