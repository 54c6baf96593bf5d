"""Own weight that the model leaves out."""

from __future__ import annotations

from handgen.effects.effect import Effect
from handgen.effects.parameter import Parameter, Prior


class OwnWeight(Effect):
    """Brings back what `own_weight` of a model file leaves out; where all of it acts, nothing changes."""

    id = "own_weight"
    name = "own weight"
    sentence = "The finger hangs by its own weight, which the model leaves out (share {share:.2f} of it)"
    signature = ("droop at no pressure, less the more the finger is pressed; nothing where something carries "
                 "the part, opposite signs palm up and palm down")
    source = ("Section 5.2.3 leaves gravity out of the assembly and calls it insignificant; Table 5.8 shows "
              "39.5 mm at 0 kPa")
    settle = "weigh finger and actuator; hold the unloaded hand palm up and palm down and read the tip"
    parameters = (Parameter(
        "share", "1", 0.0, 1.3, 0.0, Prior("normal", (1.0, 0.1)),
        "of the own weight that the model leaves out, what really acts; 1 is what its densities give"),)

    def on_model(self, model, p):
        acting = model.own_weight
        more = {part: share + p["share"] * (1.0 - share) for part, share in acting.model_dump().items()}
        return model.model_copy(update={"own_weight": acting.model_copy(update=more)})


EFFECT = OwnWeight()
