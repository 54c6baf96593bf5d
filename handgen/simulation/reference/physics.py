"""The energies of what is bent, as NGSolve's symbolic expressions; it differentiates them itself.

Each function gives an energy density in MPa (of a volume) or N/mm (of a surface), per drawn volume or area.
"""

from __future__ import annotations

import math

from handgen.simulation.case import Substance, Winding
from handgen.simulation.fibre import KNEE


def rubber(substance: Substance, gradient, level):
    """W(I1, I2) + level (J - 1) - level^2 / (2 bulk), I1 and I2 of the volume-free deformation.

    `level` is the volumetric stress, an unknown of its own; without it, in balance, bulk/2 (J - 1)^2 is left.

    Raises:
        ValueError: a law of principal stretches, which NGSolve cannot differentiate.
    """
    import ngsolve as ng

    energy = substance.law.energy
    if energy.FORM != "invariants":
        raise ValueError(f"the reference knows laws of invariants only, not {substance.law.name}")
    volume = ng.Det(gradient)
    free = ng.exp(-2 / 3 * ng.log(volume))
    green = gradient.trans * gradient
    first = ng.Trace(green)
    second = (first * first - ng.InnerProduct(green, green)) / 2
    stored = energy.value(free * first, free * free * second, *substance.law.constants)
    return stored + level * (volume - 1) - level * level / (2 * substance.bulk)


def thread(winding: Winding, surface, straight):
    """Energy per area of the turns on a surface of deformation gradient `surface`.

    Per turn E A / 2 strain^2 along the circle, and a turn to every `pitch` of the axis. Where it is pushed
    its stiffness falls to a small share, linearly over the strain KNEE. `straight`: the drawn points' place
    in the straight finger, a field in mm; its x stands still along every circle, also of a curled actuator.
    """
    import ngsolve as ng

    along = ng.Grad(straight).Trace()[0, :]
    turns = ng.Norm(along) / winding.pitch
    circle = ng.Cross(ng.specialcf.normal(3), along) / ng.Norm(along)
    strain, share = ng.Norm(surface * circle) - 1, winding.compressive
    # The integral of the stiffness 1, 1 + (1 - share) strain / KNEE, share, twice over.
    knee = strain**2 / 2 + (1 - share) * strain**3 / (6 * KNEE)
    flat = (share * strain**2 - (1 - share) * KNEE * strain) / 2 - (1 - share) * KNEE**2 / 6
    stored = ng.IfPos(strain, strain**2 / 2, ng.IfPos(strain + KNEE, knee, flat))
    wound = ng.IfPos(straight[0] - winding.start, 1.0, 0.0) * ng.IfPos(winding.end - straight[0], 1.0, 0.0)
    stiffness = winding.young * math.pi / 4 * winding.diameter**2
    return wound * turns * stiffness * stored


def air(pressure, surface, place):
    """-p V of a chamber by its wall, whose normal points out of the silicone; `place` from its opening.

    The opening lies in a plane through the origin of `place` and adds nothing.
    """
    import ngsolve as ng

    return pressure / 3 * ng.InnerProduct(ng.Cof(surface) * ng.specialcf.normal(3), place)
