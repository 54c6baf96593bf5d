"""Ogden law: a sum of powers of the principal stretches, written in two conventions that get confused.

    "mu/alpha"     W = sum_k mu_k/a_k     (l1^a_k + l2^a_k + l3^a_k - 3),  G = sum mu_k a_k/2
    "2mu/alpha^2"  W = sum_k 2 mu_k/a_k^2 (l1^a_k + l2^a_k + l3^a_k - 3),  G = sum mu_k

l1, l2, l3: isochoric principal stretches; mu_k in MPa, a_k = alpha_k without unit, not zero; G: small-strain
shear modulus. The first is Ogden's own and the one of Table 5.1 of the source; the second is that of Abaqus,
with which Yap fitted and to which Elsayed's constants belong. Numbers of the one read as the other are
another material (Elsayed's: 8 times stiffer at no strain), so a set always names its convention.

The functions below take the coefficients of "mu/alpha" (`converted` makes them) and are elementwise: W is
the sum over the directions of w(x), x = l^2, w(x) = sum_k mu_k/a_k (x^(a_k/2) - 1).

Source: R. W. Ogden, Proc. R. Soc. Lond. A 326 (1972) 565-584. Tables 5.2 and 5.7 of the thesis head
their mu MPa; they are Pa (library.yaml, `corrections`).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np

FORM = "separable"
CONSTANTS = ("mu", "alpha")

Convention = Literal["mu/alpha", "2mu/alpha^2"]


def converted(mu: Sequence[float], alpha: Sequence[float], source: Convention, target: Convention) -> tuple:
    """The `mu` of `target` that are the same material as `mu` in `source`.

    mu/alpha of the first equals 2 mu/alpha^2 of the second: mu_first = 2 mu_second / alpha.
    """
    if source == target:
        return tuple(mu)
    if source == "2mu/alpha^2":
        return tuple(2 * m / a for m, a in zip(mu, alpha, strict=True))
    return tuple(m * a / 2 for m, a in zip(mu, alpha, strict=True))


def value(x, mu, alpha):
    """w(x), MPa; expm1 keeps its digits at small strain."""
    total = 0.0 * x
    for k in range(len(mu)):
        total = total + mu[k] / alpha[k] * np.expm1(alpha[k] / 2 * np.log(x))
    return total


def first(x, mu, alpha):
    """dw/dx, MPa."""
    total = 0.0 * x
    for k in range(len(mu)):
        total = total + mu[k] / 2 * x ** (alpha[k] / 2 - 1)
    return total


def second(x, mu, alpha):
    """d2w/dx2, MPa."""
    total = 0.0 * x
    for k in range(len(mu)):
        total = total + mu[k] / 2 * (alpha[k] / 2 - 1) * x ** (alpha[k] / 2 - 2)
    return total


def quotient(x, y, mu, alpha):
    """(w'(x) - w'(y))/(x - y) of two squared stretches, MPa; w''(x) where they coincide.

    (x^p - y^p)/(x - y) = y^(p-1) expm1(p t)/expm1(t) with t = log(x/y): nothing cancels.
    """
    t = np.log(x / y)
    apart = t != 0
    t = np.where(apart, t, 1.0)
    total = 0.0 * x
    for k in range(len(mu)):
        p = alpha[k] / 2 - 1
        total = total + mu[k] / 2 * y ** (p - 1) * np.where(apart, np.expm1(p * t) / np.expm1(t), p)
    return total


def shear_modulus(mu, alpha):
    """G at small strain, MPa."""
    return sum(m * a for m, a in zip(mu, alpha, strict=True)) / 2
