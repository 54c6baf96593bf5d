"""To which of Ogden's two conventions a set's constants belong, by the data sheet of its material.

Read in the wrong one, a set gives another stress by half its exponent. The data sheet's stress at a strain is
close to one of both, and no test of a finger is needed to see to which.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from handgen.bending.model import BendModel, Choice
from handgen.materials import library
from handgen.materials.law import Law
from handgen.materials.sets import Reading

OTHER = {"mu/alpha": "2mu/alpha^2", "2mu/alpha^2": "mu/alpha"}
SCATTER = 0.10
"""Of the logarithm of a set's stress over the data sheet's: the library's silicone sets, read as meant, give
0.91 to 1.06 of it..."""
ASTRAY, FAR = 0.1, 1.0
"""... but for some, by about so much: Elsayed's for Ecoflex 00-30 and Dragon Skin 30 give 0.18 and 0.55."""


def odds(model: BendModel, materials: Sequence[str]) -> float | None:
    """What the data sheets of `materials` make of the odds that their sets are misread; None if nothing.

    Above 1 they speak for the other convention, below 1 against it.
    """
    known = library.library().materials
    found = [ratio for name in materials
             if (choice := model.materials.get(name)) is not None and name in known
             and (ratio := _of_set(choice, known[name].readings)) is not None]
    return float(np.prod(found)) if found else None


def _of_set(choice: Choice, readings: Sequence[Reading]) -> float | None:
    """Of one set. Its readings share the batch: they count as one, their mean."""
    own = choice.parameters.convention
    if own is None or not readings:
        return None
    logs = [[np.log(ratio) if ratio > 0 else np.inf for ratio in
             (stress(choice.parameters.build(said), one) / one.megapascals for one in readings)]
            for said in (own, OTHER[own])]
    return likelihood_ratio(float(np.mean(logs[0])), float(np.mean(logs[1])))


def likelihood_ratio(own: float, other: float) -> float:
    """Of the other convention.

    `own`, `other`: logarithm of the set's stress over the data sheet's, read in its own and in the other.
    """
    return _density(other) / _density(own)


def _density(log: float) -> float:
    def normal(sigma: float) -> float:
        return float(np.exp(-(log / sigma) ** 2 / 2) / sigma) if np.isfinite(log) else 0.0
    return (1 - ASTRAY) * normal(SCATTER) + ASTRAY * normal(FAR) + 1e-9


def stress(law: Law, reading: Reading) -> float:
    """Nominal uniaxial stress of `law` where the data sheet gives one, MPa; at no strain Young's modulus."""
    from handgen.materials.states import UNIAXIAL, nominal_stress

    if reading.strain == 0.0:
        return 3.0 * law.shear_modulus
    return float(nominal_stress(law, UNIAXIAL, np.array(1.0 + reading.strain)))
