"""The silicone of the actuators as a neo-Hookean solid."""

from __future__ import annotations


def shear_modulus(modulus_100: float) -> float:
    """Shear modulus from the bulletin's nominal stress at 100 % strain, both in MPa.

    Incompressible neo-Hookean solid in uniaxial tension: P = mu (L - 1/L^2), at L = 2
    P = 7/4 mu; 47 kPa for Ecoflex 00-50 (Appendix C of the source).
    """
    return modulus_100 / (2.0 - 0.25)
