"""A law fitted on tension along one axis only, in a wall that is stretched one way and held another."""

from __future__ import annotations

from dataclasses import replace

from handgen.effects.effect import Effect
from handgen.effects.laws import as_ogden, scaled
from handgen.effects.parameter import Parameter, Prior
from handgen.materials.law import Law

SECOND_INVARIANT = -2.0
"""Power of the stretches that is the second invariant's."""
KEPT = 2.0
"""Stretch up to which tension along one axis keeps its stress: the bulletin's 100 %."""


class UniaxialOnlyLaw(Effect):
    """Part of the stress at 100 % comes from the second invariant, which tension along one axis cannot tell.

    What is taken from the law is given back by c (I2 - 3) so that the stress at KEPT stays in uniaxial
    tension; a wall whose circles are held (pure shear) then resists more.
    """

    id = "uniaxial_only_law"
    name = "law known from uniaxial tension only"
    sentence = ("The silicone's law rests on tension along one axis; held around, as in the wound wall, a "
                "share of {share:.2f} of its stress acts more strongly")
    signature = ("free actuator and assembly move less, the more so the further they are stretched; the "
                 "stress at 100 % agrees with the bulletin all the same; the bare exoskeleton is untouched")
    source = ("Table 5.2 (Elsayed 2014) is fitted on uniaxial tests and unstable in planar tension; R. S. "
              "Rivlin, D. W. Saunders, Phil. Trans. R. Soc. A 243 (1951) 251-288 on what the second "
              "invariant needs")
    settle = "pull a wide short strip of the pour (planar tension) beside a narrow one"
    parameters = (Parameter(
        "share", "1", 0.0, 0.6, 0.0, Prior("normal", (0.25, 0.12)),
        "of the uniaxial stress at 100 %, what the second invariant gives"),)

    def on_case(self, case, p):
        if case.silicone is None or p["share"] == 0.0:
            return case
        law = shared(case.silicone.law, p["share"])
        return replace(case, silicone=replace(case.silicone, law=law))


def shared(law: Law, share: float) -> Law:
    """`law` with `share` of its uniaxial stress at KEPT from the second invariant.

    Raises:
        ValueError: the law is no sum of powers.
    """
    from handgen.materials.states import UNIAXIAL, nominal_stress

    rest, unit = scaled(as_ogden(law), 1.0 - share), Law("ogden", ((-2.0,), (SECOND_INVARIANT,)))
    lost = share * float(nominal_stress(law, UNIAXIAL, KEPT))
    constant = lost / float(nominal_stress(unit, UNIAXIAL, KEPT))
    mu, alpha = rest.constants
    return Law("ogden", ((*mu, -2.0 * constant), (*alpha, SECOND_INVARIANT)))


EFFECT = UniaxialOnlyLaw()
