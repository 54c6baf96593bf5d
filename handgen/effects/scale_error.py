"""Lengths read on a scale that is off."""

from __future__ import annotations

from handgen.effects.effect import Effect
from handgen.effects.parameter import Parameter, Prior

LENGTHS = ("tip_drop", "elongation")


class ScaleError(Effect):
    """Every length reads by the same factor too long; angles and forces do not know it."""

    id = "scale_error"
    name = "scale of lengths"
    sentence = "Lengths are read {factor:.3f} times their size"
    signature = ("all lengths of all tests, the bare exoskeleton's as well, off by the same share; angles "
                 "and forces right")
    source = ("Sections 5.2.1 and 5.2.2: readings against millimetre paper beside the finger, which a camera "
              "sees nearer or farther than the finger's own plane")
    settle = "photograph a ruler in the finger's plane beside the paper"
    parameters = (Parameter(
        "factor", "1", 0.85, 1.15, 1.0, Prior("normal", (1.0, 0.06)), "length as read over true length"),)

    def on_reading(self, quantity, loads, values, p):
        if quantity not in LENGTHS:
            return values
        return [None if value is None else p["factor"] * value for value in values]


EFFECT = ScaleError()
