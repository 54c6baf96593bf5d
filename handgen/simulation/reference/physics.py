"""The energies of what is bent, as NGSolve's symbolic expressions; it differentiates them itself.

Each function gives an energy density in MPa (of a volume) or N/mm (of a surface), per drawn volume or area.
"""

from __future__ import annotations

import math

from handgen.simulation.case import Substance, Winding


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

    Per turn E A / 2 (stretch - 1)^2 along the circle, a small share of it where it is pushed, and a turn to
    every `pitch` of the axis. `straight`: the drawn points' place in the straight finger, a field in mm; its
    x stands still along every circle, also of a curled actuator.
    """
    import ngsolve as ng

    along = ng.Grad(straight).Trace()[0, :]
    turns = ng.Norm(along) / winding.pitch
    circle = ng.Cross(ng.specialcf.normal(3), along) / ng.Norm(along)
    stretch = ng.Norm(surface * circle)
    share = ng.IfPos(stretch - 1, 1.0, winding.compressive)
    wound = ng.IfPos(straight[0] - winding.start, 1.0, 0.0) * ng.IfPos(winding.end - straight[0], 1.0, 0.0)
    stiffness = winding.young * math.pi / 4 * winding.diameter**2
    return wound * turns * stiffness / 2 * share * (stretch - 1) ** 2


def air(pressure, surface, place):
    """-p V of a chamber by its wall, whose normal points out of the silicone; `place` from its opening.

    The opening lies in a plane through the origin of `place` and adds nothing.
    """
    import ngsolve as ng

    return pressure / 3 * ng.InnerProduct(ng.Cof(surface) * ng.specialcf.normal(3), place)
