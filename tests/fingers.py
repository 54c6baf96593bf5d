"""Cases and systems of the adult index finger for the solid model's tests."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from handgen.bending.request import request
from handgen.simulation.case import Case, Contact
from handgen.simulation.system import Load, System

PARAMS = Path(__file__).parent.parent / "params"


def case(part: str, *, params: str = "adult.yaml", friction: float = 0.0, bonded: bool = False,
         **arguments) -> Case:
    """The case of `handgen bend` with the model of the literature, frictionless unless asked."""
    asked = request(PARAMS / params, part=part, model="literature", **arguments)
    return replace(asked.case, contact=Contact(friction, bonded))


def stiffness(system: System, values: np.ndarray):
    """The symmetric matrix whose lower triangle has `values`."""
    from scipy.sparse import csc_matrix, tril

    p = system.pattern
    lower = csc_matrix((values, (p.rows, p.columns)), shape=(p.size, p.size))
    return (lower + tril(lower, -1).T).tocsc()


def assembler(system: System, load: Load):
    """q -> (energy, force, stiffness and friction's part) as `small_solids.slope_error` takes them."""
    from scipy.sparse.linalg import LinearOperator, aslinearoperator

    def assemble(q):
        energy, force, values, least = system.assemble(q, load, exact=True)
        assert least > 0, "an element is turned inside out"
        tangent, friction = aslinearoperator(stiffness(system, values)), system.coupling()
        if friction:
            tangent = tangent + LinearOperator(tangent.shape, friction)
        return energy, force, tangent

    return assemble


def shaken(system: System, by: float = 0.03, turn: float = 0.05) -> np.ndarray:
    """Unknowns of a state of general strain: nodes moved up to `by` mm, bones turned up to `turn` rad."""
    q = np.random.default_rng(2).uniform(-by, by, system.size)
    q[system.turns] *= turn / by
    return q


def only_pairs(system: System, chosen: np.ndarray) -> None:
    """Leave nothing in `system` but the `chosen` (k,) pairs of contact: no elements, no threads."""
    count = len(system.pair_bodies)
    for name, value in vars(system).items():
        if isinstance(value, np.ndarray) and len(value) == count and value.ndim and name != "straight":
            setattr(system, name, value[chosen])
    system.groups["pairs"] = tuple(a[chosen] for a in system.groups["pairs"])
    system.blocks, system.threads = [], system.threads[:0]
