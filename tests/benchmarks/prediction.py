"""How far what Tables 5.4 and 5.6 leave open moves the prediction: `python -m tests.benchmarks.prediction`.

Every assumption of the calibration is varied with its own fit, and the finger as a whole is bent with each:
a markdown table of Table 5.8, RMS and residual at each load. Nothing is chosen by it.
"""

from __future__ import annotations

from dataclasses import replace

from handgen.bending import calibration, solve
from handgen.bending.comparison import asked, gap, observed
from handgen.measurements import load_measurements
from handgen.measurements.statistics import means

FRICTIONS = (0.3, 0.5, 1.2)
TAKEN = (0.5, 0.0)
"""Shares of the rest curl; 0: an elastic actuator, cast straight."""
TIGHT = 0.1
"""mm by which a printed bore may be too narrow, and ..."""
GAUGE = 3.5e-3
"""... MPa by which a gauge may read too little."""


def main() -> None:
    found = calibration.calibrate(progress=lambda line: None)
    measured = load_measurements(calibration.MEASUREMENTS)
    drop = measured.test("assembly-pressure")
    print("| assumption | RMS, mm | " + " | ".join(f"{p:g} kPa" for p in drop.load.values) + " |")
    print("|---" * (len(drop.load.values) + 2) + "|")
    for what, change in variations(found):
        print(row(what, drop, answer(measured, drop, change)), flush=True)


def variations(found: calibration.Calibration):
    """(words, case -> case) of the calibrated model and of each thing that could be otherwise."""
    def both(silicone, joints, friction=None, *, of_silicone=None, of_joints=None):
        def change(case):
            case = calibration.with_silicone(case, silicone.values, **(of_silicone or {}))
            case = calibration.with_joints(case, joints.values, **(of_joints or {}))
            rubbing = case.contact.friction if friction is None else friction
            return replace(case, contact=replace(case.contact, friction=rubbing))
        return change

    yield "calibrated", both(found.silicone, found.joints)
    for other in found.silicone_others:
        given = calibration.SILICONE_ASSUMPTIONS[other.what]
        yield other.what, both(other.fit, found.joints, of_silicone=given)
    for other in found.joints_others:
        given = calibration.JOINT_ASSUMPTIONS[other.what]
        yield other.what, both(found.silicone, other.fit, of_joints=given)
        if given.get("root"):
            yield from hanging(both(found.silicone, other.fit, of_joints=given))
    for taken in TAKEN:
        def strained(case, taken=taken):
            return replace(both(found.silicone, found.joints)(case), curl_taken=taken)

        yield f"actuator has taken {100 * taken:g} % of the rest curl", strained
    for friction in FRICTIONS:
        yield f"friction {friction:g}", both(found.silicone, found.joints, friction)


def hanging(root):
    """More that would let the finger which hangs from its root rest higher and bend further."""
    def tight(case):
        case = root(case)
        return replace(case, contact=replace(case.contact, clearance=-TIGHT))

    def low(case):
        case = tight(case)
        return replace(case, pressures=tuple(p + GAUGE if p else p for p in case.pressures))

    yield f"... and its bore is {TIGHT:g} mm tight all around", tight
    yield f"... and the gauge reads {1e3 * GAUGE:g} kPa too little as well", low


def answer(measured, test, change) -> list[float | None]:
    wanted = asked(measured, test, "calibrated")
    return observed(test, solve(replace(wanted, case=change(wanted.case))).curve)


def row(what: str, test, simulated: list[float | None]) -> str:
    residuals = [f"{s - m:+.1f}" if s is not None else "-"
                 for s, m in zip(simulated, means(test), strict=True)]
    return f"| {what} | {gap(test, simulated).rms:.1f} | {' | '.join(residuals)} |"


if __name__ == "__main__":
    main()
