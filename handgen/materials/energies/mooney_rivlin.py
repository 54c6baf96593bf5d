"""Mooney-Rivlin law: two constants, the second for the drop of stiffness at moderate stretch.

    W = c10 (I1 - 3) + c01 (I2 - 3)

c10, c01 in MPa (c_1, c_2 in Table 5.1 of the source, C_10, C_01 in Tables 5.3 and 5.5); small-strain
shear modulus G = 2 (c10 + c01). I1, I2: first and second invariant of the isochoric right
Cauchy-Green tensor. With both constants positive it is stable in every state.

Source: M. Mooney, J. Appl. Phys. 11 (1940) 582-592; R. S. Rivlin, Phil. Trans. R. Soc. A 241 (1948)
379-397.
"""

from __future__ import annotations

FORM = "invariants"
CONSTANTS = ("c10", "c01")


def value(i1, i2, c10, c01):
    """W, MPa."""
    return c10 * (i1 - 3) + c01 * (i2 - 3)


def first(i1, i2, c10, c01):
    """(dW/dI1, dW/dI2), MPa."""
    return c10 + 0 * i1, c01 + 0 * i2


def second(i1, i2, c10, c01):
    """(W11, W12, W22), second derivatives with respect to I1 and I2, MPa."""
    return 0 * i1, 0 * i1, 0 * i1


def shear_modulus(c10, c01):
    """G at small strain, MPa."""
    return 2 * (c10 + c01)
