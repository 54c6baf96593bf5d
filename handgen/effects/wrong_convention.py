"""Ogden constants read in the wrong one of the two conventions."""

from __future__ import annotations

from handgen.effects.effect import Effect
from handgen.effects.parameter import Parameter, Prior

OTHER = {"mu/alpha": "2mu/alpha^2", "2mu/alpha^2": "mu/alpha"}


class WrongConvention(Effect):
    """Reads every Ogden set of the model in the other convention; sets of other laws have none."""

    id = "wrong_convention"
    name = "wrong convention"
    sentence = ("The Ogden constants belong to the other convention, sum mu/alpha against sum 2 mu/alpha^2: "
                "read so, the silicone is another material")
    signature = ("the silicone is off by one factor at small and another at large stretch, and off the "
                 "bulletin's stress at 100 %; free actuator and assembly, not the bare exoskeleton")
    source = ("Tables 5.2 and 5.7 print Elsayed's constants, which belong to Abaqus's convention, for a "
              "solver of Table 5.1's")
    settle = "compute the stress at 100 % strain by hand and compare with the bulletin (Appendix C)"
    parameters = (Parameter(
        "misread", "1", 0.0, 1.0, 0.0, Prior("point", (1.0,)),
        "1: the constants are the other convention's"),)

    def on_model(self, model, p):
        if p["misread"] == 0.0:
            return model
        return model.model_copy(update={
            "materials": {name: _other(choice) for name, choice in model.materials.items()}})


def _other(choice):
    found = choice.parameters
    if found.convention is None:
        return choice
    read = found.model_copy(update={"convention": OTHER[found.convention]})
    return choice.model_copy(update={"parameters": read, "name": f"{choice.name}, read in {read.convention}"})


EFFECT = WrongConvention()
