"""A finger that comes off the printer curled."""

from __future__ import annotations

from handgen.effects.effect import Effect
from handgen.effects.parameter import Parameter, Prior


class RestCurl(Effect):
    """All joints share the curl evenly, beside the rest angles that the hand states."""

    id = "rest_curl"
    name = "rest curl"
    sentence = "The printed finger is curled by {angle:.0f} degrees before anything acts on it"
    signature = ("all readings of exoskeleton and assembly start lower and bend further; most at no load, "
                 "least when the finger hangs straight down; the free actuator does not know it")
    source = "not in the source's drawings; its Table 5.4 asks for 20 to 40 degrees"
    settle = "lay the printed finger on its side on paper and draw around it"
    parameters = (Parameter(
        "angle", "deg", 0.0, 45.0, 0.0, Prior("normal", (18.0, 12.0)),
        "flexion at rest, summed over the joints, more than the hand's rest angles"),)

    def on_hand(self, hand, p):
        fingers = {name: _curled(finger, p["angle"]) for name, finger in hand.fingers.present().items()}
        return hand.model_copy(update={"fingers": hand.fingers.model_copy(update=fingers)})


def _curled(finger, angle: float):
    share = angle / len(finger.joints)
    joints = [joint.model_copy(update={"rest_angle": joint.rest_angle + share}) for joint in finger.joints]
    return finger.model_copy(update={"joints": joints})


EFFECT = RestCurl()
