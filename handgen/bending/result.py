"""What a bend gives: the contract's `handgen.bend/1`, with what a user must know of every point."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from handgen import __version__
from handgen.bending.request import Request
from handgen.errors import EngineError
from handgen.simulation.case import Curve, State

SCHEMA = "handgen.bend/1"
ABOUT: dict[str, tuple[str, Callable[[float], float]]] = {
    "tip_drop_mm": ("tip_drop", float),
    "bend_angle_deg": ("bend_angle", math.degrees),
    "elongation_mm": ("elongation", float),
    "tip_force_N": ("tip_force", float),
    "max_stretch": ("max_stretch", float),
    "residual": ("residual", float),
}
"""Key of a point -> the state's value, and the conversion from inside units."""


@dataclass(frozen=True)
class Bend:
    """A bend with its arrays: `curve.states[i].positions["exoskeleton"]` are nodes, mm."""

    request: Request
    curve: Curve
    cached: bool
    """Taken from an earlier run that was the same in everything that matters."""

    @property
    def complete(self) -> bool:
        """Every point converged."""
        return all(state.converged for state in self.curve.states)

    @property
    def reached(self) -> str:
        """How far it got, in words."""
        unit = "N" if self.request.part == "exoskeleton" else "kPa"
        if not any(state.converged for state in self.curve.states):
            return f"reached no point: {self.curve.stopped or 'not converged'}"
        return f"reached {reached(self.request, self.curve):.4g} {unit}" + (
            f": {self.curve.stopped}" if self.curve.stopped else "")

    @property
    def document(self) -> dict[str, Any]:
        """The contract's JSON: kPa, deg, mm, N; null where a point did not converge."""
        asked, curve = self.request, self.curve
        return {
            "schema": SCHEMA,
            "name": asked.hand,
            "finger": asked.finger,
            "part": asked.part,
            "orientation": asked.orientation,
            "solver": asked.solver,
            "model": asked.model,
            "materials": {body: {"material": asked.materials[body], "parameters": choice.name}
                          for body, choice in asked.choices.items()},
            "obstacle_mm": asked.case.obstacle,
            "refine": asked.case.refine,
            "points": [point(asked, state) for state in curve.states],
            "reached": reached(asked, curve),
            "reached_unit": "N" if asked.part == "exoskeleton" else "kPa",
            "folds_kPa": [_clean(1e3 * p) for p in curve.folds],
            "stopped": curve.stopped,
            "unknowns": curve.unknowns,
            "factorisations": curve.factorisations,
            "wall_s": round(curve.wall, 3),
            "cached": self.cached,
            "notes": list(asked.notes),
            "handgen_version": __version__,
        }


def reached(request: Request, curve: Curve) -> float:
    """Up to which load every point converged: kPa, or N of a bare exoskeleton."""
    return _clean(curve.reached if request.part == "exoskeleton" else 1e3 * curve.reached)


def point(request: Request, state: State) -> dict[str, Any]:
    """One point of the contract's `points`."""
    values = {key: getattr(state, name) for key, (name, _) in ABOUT.items()}
    return {
        "pressure_kPa": _clean(1e3 * state.pressure),
        "tip_load_N": _clean(state.tip_load),
        "converged": state.converged,
        **{key: ABOUT[key][1](value) if state.converged and value is not None else None
           for key, value in values.items()},
        **({"bend_angle_error_deg": math.degrees(state.bend_error)} if state.bend_error is not None else {}),
        "note": state.note,
        "flags": list(flags(request, state)) if state.converged else [],
    }


def flags(request: Request, state: State) -> Iterator[str]:
    """Where the strain goes beyond what the law of a body was fitted on."""
    known = {body: float(stretch.max()) for body, stretch in state.stretch.items()}
    if not known and state.max_stretch is not None:
        known = dict.fromkeys(request.choices, state.max_stretch)  # it may be any body's
    for body, most in known.items():
        fitted = request.choices[body].parameters.strain[1]
        if most - 1.0 > fitted:
            yield (f"{body} strained {100 * (most - 1):.0f} %; its law rests on data up to "
                   f"{100 * fitted:.0f} %")


def judged(request: Request, curve: object) -> Curve:
    """`curve` as a solver returned it, once it is certain that it is one.

    Raises:
        EngineError: another thing, another number of points, other loads, or a number that is none.
    """
    who = f"the solver {request.solver!r}"
    if not isinstance(curve, Curve):
        raise EngineError(f"{who} returned no curve but {type(curve).__name__}")
    case = request.case
    wanted = ([(0.0, load) for load in case.tip_loads] if case.part == "exoskeleton"
              else [(pressure, case.tip_loads[0]) for pressure in case.pressures])
    if [(s.pressure, s.tip_load) for s in curve.states] != wanted:
        raise EngineError(f"{who} did not return the points that were asked for")
    for state in curve.states:
        numbers = [getattr(state, name) for name, _ in ABOUT.values()]
        arrays = [*state.positions.values(), *state.stretch.values()]
        if state.converged and not (all(np.isfinite(n) for n in numbers if n is not None)
                                    and all(np.isfinite(a).all() for a in arrays)):
            raise EngineError(f"{who} called a state converged that has no finite numbers, at "
                              f"{1e3 * state.pressure:g} kPa, {state.tip_load:g} N")
    return curve


def _clean(number: float) -> float:
    """Without the last digits that a change of unit leaves: 0.03 MPa is 30 kPa."""
    return float(f"{number:.12g}")
