"""Is a law a possible material over the strains it is used at? Where not: in which state, from which stretch.

A fit to uniaxial data alone can be nonsense in the states a finger is really in (a thread-wrapped tube
lengthens in planar tension, a ballooning one in equibiaxial). Four conditions, each at every stretch of
uniaxial, planar and equibiaxial tension, closed-form from a law's response, incompressible:

- `pull`: the nominal stress is positive (pulling needs force).
- `monotone`: the nominal stress rises with the stretch.
- `drucker`: d(tau) : d(e) > 0 for every volume-preserving increment of logarithmic strain e, tau the
  Kirchhoff stress (D. C. Drucker, J. Appl. Mech. 26 (1959) 101-106; Hill's form of it).
- `baker-ericksen`: the greater principal stress goes with the greater principal stretch (M. Baker,
  J. L. Ericksen, J. Wash. Acad. Sci. 44 (1954) 33-35); at equal stretches its limit.

Compression needs no state of its own: uniaxial compression to s^-2 is equibiaxial tension to s, and
planar compression is planar tension.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from handgen.materials.law import PAIRS, Law
from handgen.materials.states import STATES, State, nominal_stress, slope, squared_stretches

SAMPLES = 400
"""Stretches looked at in each state, equally spaced in log; failures narrower than that go unseen."""
BISECTIONS = 30

TRACELESS = np.array([[1, -1, 0], [1, 1, -2]]) / np.sqrt([[2], [6]])
"""Orthonormal volume-preserving increments of the principal logarithmic strains."""


@dataclass(frozen=True)
class Failure:
    """The first stretch of a state at which a law breaks a condition."""

    state: str
    stretch: float
    condition: str
    stress: float
    """Nominal stress there, MPa."""

    def __str__(self) -> str:
        meaning = {
            "pull": "its nominal stress is negative",
            "monotone": f"its nominal stress stops rising, at {1000 * self.stress:.3g} kPa",
            "drucker": "its tangent stiffness is not positive (Drucker)",
            "baker-ericksen": "the greater stretch no longer has the greater stress (Baker-Ericksen)",
        }[self.condition]
        return f"in {self.state} tension from {100 * (self.stretch - 1):.3g} % strain {meaning}"


def _pull(law: Law, state: State, s: np.ndarray) -> np.ndarray:
    """Nominal stress over strain: its limit at s = 1 is the slope."""
    strain = s - 1
    here = strain > 1e-6
    return np.where(here, nominal_stress(law, state, s) / np.where(here, strain, 1), slope(law, state, s))


def _drucker(law: Law, state: State, s: np.ndarray) -> np.ndarray:
    """Least eigenvalue of d(tau)/d(e) on volume-preserving increments, MPa."""
    x = squared_stretches(state, s)
    response = law.response(x)
    stiffness = 4 * x[..., :, None] * x[..., None, :] * response.second
    stiffness = stiffness + 4 * (x * response.first)[..., None] * np.eye(3)
    return np.linalg.eigvalsh(TRACELESS @ stiffness @ TRACELESS.T)[..., 0]


def _baker_ericksen(law: Law, state: State, s: np.ndarray) -> np.ndarray:
    """Least (sigma_a - sigma_b)/(x_a - x_b) of the three pairs, MPa; sigma_a = 2 x_a W_a - p."""
    x = squared_stretches(state, s)
    response = law.response(x)
    ratios = [
        2 * (x[..., a] * response.quotient[..., k] + response.first[..., b]) for k, (a, b) in enumerate(PAIRS)
    ]
    return np.min(ratios, axis=0)


CONDITIONS: Mapping[str, Callable[[Law, State, np.ndarray], np.ndarray]] = {
    "pull": _pull,
    "monotone": slope,
    "drucker": _drucker,
    "baker-ericksen": _baker_ericksen,
}
"""Each gives a number that must be positive, for stretches >= 1."""


def failures(law: Law, strain: float) -> list[Failure]:
    """Where `law` first breaks each condition in each state up to the nominal strain `strain` (1 is 100 %).

    The least strain comes first; an empty list means stable.
    """
    stretches = np.geomspace(1, 1 + strain, SAMPLES)
    found = []
    for state in STATES:
        for name, condition in CONDITIONS.items():
            bad = np.flatnonzero(~(condition(law, state, stretches) > 0))
            if len(bad):
                stretch = _onset(lambda s, c=condition, at=state: c(law, at, s), stretches, bad[0])
                stress = float(nominal_stress(law, state, np.array(stretch)))
                found.append(Failure(state.name, stretch, name, stress))
    return sorted(found, key=lambda failure: failure.stretch)


def stable_up_to(law: Law, strain: float) -> float:
    """The nominal strain, at most `strain`, up to which every condition holds in every state."""
    found = failures(law, strain)
    return found[0].stretch - 1 if found else strain


@lru_cache(maxsize=256)
def reason(law: Law, strain: float) -> str | None:
    """Why `law` is no possible material up to nominal strain `strain`; None if it is stable.

    Names the first failure in each state.
    """
    modulus = 3 * law.shear_modulus
    if not modulus > 0:
        return f"the law is unstable at no strain at all: its Young's modulus there is {modulus:.3g} MPa"
    found = failures(law, strain)
    if not found:
        return None
    first = {failure.state: failure for failure in reversed(found)}
    parts = [str(first[state.name]) for state in STATES if state.name in first]
    return f"the law is unstable within {100 * strain:.3g} % strain: " + "; ".join(parts)


def _onset(value: Callable[[np.ndarray], np.ndarray], stretches: np.ndarray, bad: int) -> float:
    """The stretch at which `value` turns from positive, between the sample `bad` and the one before."""
    if bad == 0:
        return 1.0
    low, high = stretches[bad - 1], stretches[bad]
    for _ in range(BISECTIONS):
        middle = (low + high) / 2
        if value(np.array([middle]))[0] > 0:
            low = middle
        else:
            high = middle
    return float(high)
