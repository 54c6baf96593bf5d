"""Yeoh law: a cubic in I1 alone; c20 < 0 and c30 > 0 give the S-shaped curve of filled rubber.

    W = c10 (I1 - 3) + c20 (I1 - 3)^2 + c30 (I1 - 3)^3

c10, c20, c30 in MPa (Table 5.1 of the source; a set of N = 2 has c30 = 0); small-strain shear modulus
G = 2 c10. I1: first invariant of the isochoric right Cauchy-Green tensor. dW/dI1 must stay positive:
negative higher constants make it fail at some stretch.

Source: O. H. Yeoh, Rubber Chem. Technol. 66 (1993) 754-771. Table 5.2 of the thesis heads its
values MPa; they are Pa (library.yaml, `corrections`).
"""

from __future__ import annotations

FORM = "invariants"
CONSTANTS = ("c10", "c20", "c30")


def value(i1, i2, c10, c20, c30):
    """W, MPa."""
    k = i1 - 3
    return k * (c10 + k * (c20 + k * c30))


def first(i1, i2, c10, c20, c30):
    """(dW/dI1, dW/dI2), MPa."""
    k = i1 - 3
    return c10 + k * (2 * c20 + 3 * k * c30), 0 * i1


def second(i1, i2, c10, c20, c30):
    """(W11, W12, W22), second derivatives with respect to I1 and I2, MPa."""
    return 2 * c20 + 6 * c30 * (i1 - 3), 0 * i1, 0 * i1


def shear_modulus(c10, c20, c30):
    """G at small strain, MPa."""
    return 2 * c10
