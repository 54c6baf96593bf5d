"""Brings the worlds' finger near the solid model's, once: `python -m tests.worlds.calibrate`.

The solid model bends params/thesis_hand.yaml with params/models/calibrated.yaml: bare exoskeleton under
weights, free actuator, finger under pressure, fingertip force; palm down, palm up and weightless. The
chain's constants are fitted to these curves and written to constants.yaml. No measurement is seen, no effect
is switched on.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tests.worlds.finger import FILE, Finger, Pose, balance, free_elongation, with_values

HAND = Path(__file__).parents[2] / "params" / "thesis_hand.yaml"
PRESSURES = [0, 10, 20, 30, 40, 50, 60, 70, 80]
WEIGHTS = [0, 0.07, 0.16, 0.27, 0.40, 0.56]
CURVES = {
    "exoskeleton": (Pose("exoskeleton"), {"part": "exoskeleton", "tip_loads": WEIGHTS}),
    "exoskeleton, carried": (Pose("exoskeleton", 0.0), {
        "part": "exoskeleton", "tip_loads": WEIGHTS, "orientation": "weightless"}),
    "palm down": (Pose(), {"pressures": PRESSURES}),
    "palm up": (Pose(down=-1.0), {"pressures": PRESSURES, "orientation": "palm_up"}),
    "carried": (Pose(down=0.0), {"pressures": PRESSURES, "orientation": "weightless"}),
    "force": (Pose(plane=40.0), {"pressures": PRESSURES, "obstacle": 40}),
    "force, carried": (Pose(down=0.0, plane=40.0), {
        "pressures": PRESSURES, "obstacle": 40, "orientation": "weightless"}),
}
ACTUATOR = {"part": "actuator", "pressures": PRESSURES[:7], "orientation": "weightless"}
COUNTS = {"tip_drop": 1.0, "bend_angle": 0.4, "elongation": 1.0, "tip_force": 40.0}
"""What a mm, a degree, a newton off counts."""
FITTED = {
    "strip": (130, 40, 400), "harden": (0.0, -2, 400), "beam": (200, 50, 800), "area": (90, 40, 160),
    "arm": (8, 6, 10), "offset": (7, 3, 10), "wall.0": (0.34, 0.1, 1), "wall.1": (1.85, 0.2, 5),
    "wall.2": (0.0, -0.3, 0.3), "tube_mass": (10, 5, 15), "shell_mass": (6, 3, 12), "tip_mass": (1.2, 0.5, 4),
    "blur": (1.5, 0.1, 4), "bone": (50, 15, 200), "joints.0": (14.5, 12, 17), "loose": (0.4, 0.1, 1),
    "seated": (0.002, 2e-4, 0.01), "first": (1.2, 0.5, 2)}
"""Constant -> (start, least, most)."""


def solid(row: dict) -> list[dict]:
    """States of the solid model."""
    from handgen.bending import request, solve

    found = solve(request(HAND, finger="index", model="calibrated", **row)).curve
    return [{"pressure": s.pressure, "tip_load": s.tip_load, "tip_drop": s.tip_drop,
             "elongation": s.elongation,
             "bend_angle": np.degrees(s.bend_angle), "tip_force": s.tip_force} for s in found.states]


def residuals(finger: Finger, curves: dict[str, list[dict]]) -> list[tuple[str, float, str, float]]:
    """(curve, load in kPa or N, quantity, chain less solid) of every point."""
    found = []
    for name, states in curves.items():
        if name == "actuator":
            found += [(name, 1e3 * s["pressure"], "elongation",
                       free_elongation(finger, s["pressure"]) - s["elongation"]) for s in states]
            continue
        pose, start = CURVES[name][0], None
        for s in states:
            state = balance(finger, pose, s["pressure"], s["tip_load"], start)
            start = state.angles
            wanted = ["tip_force"] if pose.plane else ["tip_drop", "bend_angle"]
            wanted += ["elongation"] if pose.part == "assembly" and not pose.plane else []
            load = s["tip_load"] if pose.part == "exoskeleton" else 1e3 * s["pressure"]
            found += [(name, load, q, state.values[q] - s[q]) for q in wanted]
    return found


def fit(curves: dict[str, list[dict]]) -> dict[str, float]:
    """The constants of FITTED."""
    from scipy.optimize import least_squares

    start, low, high = np.array(list(FITTED.values()), float).T

    def misfit(u: np.ndarray) -> np.ndarray:
        finger = with_values(Finger(), dict(zip(FITTED, low + u * (high - low), strict=True)))
        # The exoskeleton and the actuator alone carry fewer points than the assembly.
        return np.array([COUNTS[q] * (3.0 if n == "actuator" else 1.5 if n.startswith("exo") else 1.0) * r
                         for n, _, q, r in residuals(finger, curves)])

    found = least_squares(misfit, (start - low) / (high - low), bounds=(0, 1), diff_step=1e-5, max_nfev=120)
    return dict(zip(FITTED, (float(f"{v:.5g}") for v in low + found.x * (high - low)), strict=True))


def main() -> None:
    import yaml

    curves = {name: solid(row) for name, (_, row) in CURVES.items()} | {"actuator": solid(ACTUATOR)}
    values = fit(curves)
    head = "# Written by `python -m tests.worlds.calibrate`; do not edit. See there.\n"
    FILE.write_text(head + yaml.safe_dump(values, sort_keys=False), encoding="utf-8")
    off = residuals(with_values(Finger(), values), curves)
    for name in curves:
        for quantity in COUNTS:
            row = [r for n, _, q, r in off if (n, q) == (name, quantity)]
            if row:
                print(f"{name:22s} {quantity:10s} RMS {np.sqrt(np.mean(np.square(row))):6.3f}   "
                      + " ".join(f"{r:+.2f}" for r in row))


if __name__ == "__main__":
    main()
