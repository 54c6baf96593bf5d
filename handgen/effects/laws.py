"""Laws made stiffer or softer, as effects need them."""

from __future__ import annotations

from dataclasses import replace

from handgen.materials.law import Law
from handgen.simulation.case import Substance


def scaled(law: Law, factor: float) -> Law:
    """`law` with all of its stresses times `factor`."""
    if law.name == "ogden":
        mu, alpha = law.constants
        return replace(law, constants=(tuple(factor * m for m in mu), alpha))
    return replace(law, constants=tuple(factor * c for c in law.constants))


def softened(substance: Substance, factor: float, density: float = 1.0) -> Substance:
    """`substance` with all of its stresses times `factor` and its density times `density`."""
    return Substance(scaled(substance.law, factor), factor * substance.bulk, density * substance.density)


def as_ogden(law: Law) -> Law:
    """The same law as sums of powers of stretches.

    Raises:
        ValueError: it is none: only neo-Hookean, Mooney-Rivlin and Ogden laws are.
    """
    if law.name == "ogden":
        return law
    if law.name == "neo_hookean":
        return Law("ogden", ((2.0 * law.constants[0],), (2.0,)))
    if law.name == "mooney_rivlin":
        c10, c01 = law.constants
        return Law("ogden", ((2.0 * c10, -2.0 * c01), (2.0, -2.0)))
    raise ValueError(f"a law of the form {law.name} cannot be written in powers of stretches")
