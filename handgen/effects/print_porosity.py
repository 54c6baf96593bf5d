"""Voids between the lines of a print."""

from __future__ import annotations

from dataclasses import replace

from handgen.effects.effect import Effect
from handgen.effects.laws import softened
from handgen.effects.parameter import Parameter, Prior

POWER = 2.0
"""Of stiffness over density: cell walls that bend (Gibson and Ashby)."""


class PrintPorosity(Effect):
    """Density falls by the share of voids, stiffness by its square."""

    id = "print_porosity"
    name = "print porosity"
    sentence = "The print is lighter and softer than its law: a share of {porosity:.2f} of it is voids"
    signature = ("the bare exoskeleton bends further under weights, the assembly at every pressure; the "
                 "actuator not")
    source = ("equation 5.1: 0.827 g/cm3 weighed, 0.695 of the filament; stiffness by the square of density: "
              "L. J. Gibson, M. F. Ashby, Cellular Solids, 1997")
    settle = "weigh the printed finger and divide by the volume of its CAD model"
    parameters = (Parameter(
        "porosity", "1", 0.0, 0.45, 0.0, Prior("normal", (0.2, 0.12)),
        "share of voids, beyond what the model's density already holds"),)

    def on_case(self, case, p):
        if case.tpu is None:
            return case
        left = 1.0 - p["porosity"]
        return replace(case, tpu=softened(case.tpu, left**POWER, left))


EFFECT = PrintPorosity()
