"""Neo-Hookean law: one constant, stable in every state; the safest law for what was not measured.

    W = c10 (I1 - 3)

c10 in MPa (Table 5.1 of the source calls it c_i); small-strain shear modulus G = 2 c10, E0 = 3 G.
I1 = tr C of the isochoric right Cauchy-Green tensor C. Without strain stiffening: not predictive
beyond a stretch of about 2.

Source: L. R. G. Treloar, Trans. Faraday Soc. 39 (1943) 241-246; R. S. Rivlin, Phil. Trans. R. Soc.
A 240 (1948) 459-490.
"""

from __future__ import annotations

FORM = "invariants"
CONSTANTS = ("c10",)


def value(i1, i2, c10):
    """W, MPa."""
    return c10 * (i1 - 3)


def first(i1, i2, c10):
    """(dW/dI1, dW/dI2), MPa."""
    return c10 + 0 * i1, 0 * i1


def second(i1, i2, c10):
    """(W11, W12, W22), second derivatives with respect to I1 and I2, MPa."""
    return 0 * i1, 0 * i1, 0 * i1


def shear_modulus(c10):
    """G at small strain, MPa."""
    return 2 * c10
