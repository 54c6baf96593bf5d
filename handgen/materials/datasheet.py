"""Does a law agree with the manufacturer's bulletin? Law value, bulletin value and their ratio."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handgen.materials.library import material
from handgen.materials.sets import ParameterSet, Reading
from handgen.materials.states import UNIAXIAL, nominal_stress


class Comparison(NamedTuple):
    """One reading of a bulletin beside a law; stresses in MPa."""

    reading: Reading
    law: float
    datasheet: float
    ratio: float
    """Law over bulletin: 1 agrees, above 1 the law is too stiff."""
    extrapolated: bool
    """The reading lies outside the strains that the law was fitted on."""


def compare(found: ParameterSet) -> list[Comparison]:
    """Every reading of the material's bulletin against the set's law; empty where there is none.

    At strain 0 the bulletin's tensile modulus is held against Young's modulus 3 G.
    """
    law = found.build()
    low, high = found.strain
    result = []
    for reading in material(found.material).readings:
        if reading.strain == 0:
            value = 3 * law.shear_modulus
        else:
            value = float(nominal_stress(law, UNIAXIAL, np.array(1 + reading.strain)))
        outside = not low <= reading.strain <= high
        result.append(Comparison(reading, value, reading.megapascals, value / reading.megapascals, outside))
    return result
