"""Equilibrium from no load to full load: plain Newton on the exact tangent, steps cut back where it fails.

Each step starts from the line through the last two states. What comes out is a balance of forces with every
Jacobian positive; whether it is stable is not asked.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

LONGEST = np.array([0.25, 0.01, 0.1])
"""Longest step: share of own weight, pressure in MPa, tip load in N."""
SHORTEST = 1 / 32
"""Of the longest step; below it the search ends."""
ITERATIONS, SLIDING_ITERATIONS = 12, 30
"""At most in a step; where surfaces slide, new pairs in every one of them cost the quadratic end."""
ENERGY = 1e-9
"""mJ (N mm) that a Newton step may still gain in balance."""
HOPELESS = 1e6


@dataclass
class Balance:
    """Follows `form` (an energy that its element-wise unknowns are condensed from) as `loads` grow."""

    form: object
    space: object
    loads: tuple
    """Three NGSolve parameters: share of own weight, pressure MPa, tip load N."""
    upright: Callable[[object], bool]
    """Asked of every state in balance: is none of its elements turned inside out?"""
    find: Callable[[object], None] | None = None
    """Pairs sliding surfaces as they lie in a state."""
    factorisations: int = 0
    now: np.ndarray = field(default_factory=lambda: np.zeros(3))

    def __post_init__(self):
        import ngsolve as ng

        self.state = ng.GridFunction(self.space)
        self._free = self.space.FreeDofs(True)
        self._before, self._before_at = None, None
        self._residual, self._step = (self.state.vec.CreateVector() for _ in range(2))

    def reach(self, target: np.ndarray) -> bool:
        """Go to `target` (three loads) in as many steps as it takes; False: `now` is how far it went."""
        size = 1.0
        while (way := np.abs(target - self.now) / LONGEST).max() > 1e-9:
            share = min(1.0, size / way.max())
            if self._advance(target if share == 1.0 else self.now + share * (target - self.now)):
                size = min(1.0, 1.5 * size)
            elif (size := min(size, way.max()) / 2) < SHORTEST:
                return False
        return True

    def _advance(self, target: np.ndarray) -> bool:
        here = self.state.vec.CreateVector()
        here.data = self.state.vec
        for load, value in zip(self.loads, target, strict=True):
            load.Set(float(value))
        if self._before is not None:
            past, ahead = self.now - self._before_at, target - self.now
            # Only straight on: after a corner the last direction says nothing.
            if np.count_nonzero(past) == 1 and np.array_equal(past != 0, ahead != 0):
                self.state.vec.data = here + float(ahead.sum() / past.sum()) * (here - self._before)
        if not self._newton():
            self.state.vec.data = here
            for load, value in zip(self.loads, self.now, strict=True):
                load.Set(float(value))
            return False
        self._before, self._before_at, self.now = here, self.now, np.array(target, float)
        return True

    def _newton(self) -> bool:
        import ngsolve as ng
        from netgen.libngpy._meshing import NgException

        form, state, step, residual = self.form, self.state.vec, self._step, self._residual
        for _ in range(SLIDING_ITERATIONS if self.find else ITERATIONS):
            if self.find:
                self.find(self.state)
            try:
                form.Apply(state, residual)
                form.AssembleLinearization(state)
                residual.data += form.harmonic_extension_trans * residual
                step.data = form.mat.Inverse(self._free, inverse="sparsecholesky") * residual
            except NgException:
                return False
            self.factorisations += 1
            gain = abs(ng.InnerProduct(step, residual))
            step.data += form.harmonic_extension * step
            step.data += form.inner_solve * residual
            state.data -= step
            if not gain < HOPELESS:
                return False
            if gain < ENERGY:
                return self.upright(self.state)
        return False

    def residual(self) -> float:
        """Largest out-of-balance force over the largest of the acting ones."""
        free = np.array(list(self.space.FreeDofs()))
        forces = []
        for share in (1.0, 0.0):
            for load, value in zip(self.loads, self.now, strict=True):
                load.Set(share * float(value))
            self.form.Apply(self.state.vec, self._residual)
            forces.append(np.abs(self._residual.FV().NumPy()[free]).max())
        for load, value in zip(self.loads, self.now, strict=True):
            load.Set(float(value))
        return float(forces[0] / forces[1]) if forces[1] > 0 else 0.0
