"""The whole hand as one validated, frozen definition: the root of every parameter file."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import ConfigDict, Field

from handgen.parameters.finger import Actuator, Finger, Layers, Thread
from handgen.parameters.palm import Opposition, Palm
from handgen.parameters.prices import Prices
from handgen.parameters.process import Casting, Printing, Seal
from handgen.parameters.quantity import Model, item, quantity
from handgen.parameters.rules import Rules

SCHEMA = "handgen.hand/1"
FINGERS = ("index", "middle", "ring", "little", "thumb")
OPPOSITION = ("opposition_1", "opposition_2")


class Fingers(Model):
    """The exoskeletons of Table A.1; a file may define fewer than five."""

    index: Finger | None = None
    middle: Finger | None = None
    ring: Finger | None = None
    little: Finger | None = None
    thumb: Finger | None = None

    def present(self) -> dict[str, Finger]:
        return {n: f for n in FINGERS if (f := getattr(self, n)) is not None}


class Actuators(Model):
    """The actuators of Table A.2 and the two that oppose the thumb."""

    index: Actuator | None = None
    middle: Actuator | None = None
    ring: Actuator | None = None
    little: Actuator | None = None
    thumb: Actuator | None = None
    opposition_1: Actuator | None = None
    opposition_2: Actuator | None = None

    def present(self) -> dict[str, Actuator]:
        return {n: a for n in FINGERS + OPPOSITION if (a := getattr(self, n)) is not None}


class Exoskeleton(Model):
    """What all printed fingers share."""

    joint_fillet: float = quantity(
        "mm", 0, 5, "radius where a palmar strip meets the closed phalanx", default=1.5,
        assumed="a sharp corner there starts a tear; a quarter of a slot at most is used")


class Hand(Model):
    """One hand, or a part of one."""

    model_config = ConfigDict(title="handgen parameter file", populate_by_name=False)

    schema_: Literal["handgen.hand/1"] = Field(alias="schema", description="version of this format")
    name: Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9_-]{0,63}$")] = item(
        "names the output folder; letters, digits, _ and -")
    description: str = item("one line for people", default="", max_length=400)
    side: Literal["right", "left"] = item("a left hand is the mirror image", default="right")
    fingers: Fingers
    actuators: Actuators
    layers: Layers
    thread: Thread
    exoskeleton: Exoskeleton = item("shared by the fingers", default_factory=Exoskeleton)
    palm: Palm | None = item("left out: single fingers, no hand", default=None)
    opposition: Opposition | None = item("left out: a thumb that only bends", default=None)
    casting: Casting
    seal: Seal = item("plugs and collars", default_factory=Seal)
    printing: Printing
    prices: Prices = item("for the bill of materials", default_factory=Prices)
    rules: Rules = item("own limits and accepted findings of the design rules", default_factory=Rules)
    assumed: dict[str, str] = item(
        "key path (`*` for any key or list index) -> why this value, which the source does not give",
        default_factory=dict)

    def layers_of(self, actuator: str) -> Layers:
        return getattr(self.actuators, actuator).layers or self.layers

    def thread_of(self, actuator: str) -> Thread:
        return getattr(self.actuators, actuator).thread or self.thread
