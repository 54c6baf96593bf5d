"""All effects by name: handgen's own, and those that other packages hang in (entry points)."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from importlib import import_module
from typing import Any, NamedTuple

from handgen.effects.effect import Effect
from handgen.errors import EngineError
from handgen.parameters.fault import Fault, Path, nearest
from handgen.plugins import entry_points

GROUP = "handgen.effects"
"""Entry points of this group are effects: an instance of `Effect`, under its id."""
OWN = (
    "own_weight", "rest_curl", "print_porosity", "silicone_softening", "wrong_convention",
    "uniaxial_only_law", "bore_clearance", "pressure_offset", "pressure_gain", "bore_friction",
    "base_compliance", "thread_spacing", "asymmetric_winding", "mullins", "creep", "self_contact",
    "scale_error", "contact_angle",
)
"""Modules of handgen.effects, each with its EFFECT."""
SCHEMA = "handgen.effects/1"


class Switched(NamedTuple):
    """An effect that is on, with all of its parameters."""

    effect: Effect
    parameters: dict[str, float]

    @property
    def sentence(self) -> str:
        return self.effect.said(self.parameters)


def catalogue() -> dict[str, Effect]:
    """Every effect by its id, handgen's own first.

    Raises:
        EngineError: another package's effect cannot be loaded, is none, or has a name that is taken.
    """
    found = {name: import_module(f"handgen.effects.{name}").EFFECT for name in OWN}
    for point in sorted(entry_points(group=GROUP), key=lambda one: one.name):
        try:
            effect = point.load()
        except Exception as error:  # another package's code may fail in any way
            raise EngineError(
                f"the effect {point.name!r} cannot be loaded: {type(error).__name__}: {error}") from error
        if not isinstance(effect, Effect) or effect.id != point.name:
            raise EngineError(f"the effect {point.name!r} of {point.value} is no Effect of this id")
        if point.name in found:
            raise EngineError(f"the effect {point.name!r} is registered twice, once by {point.value}")
        found[point.name] = effect
    return found


def document() -> dict[str, Any]:
    """The catalogue as JSON."""
    return {"schema": SCHEMA, "effects": [effect.document() for effect in catalogue().values()]}


def faults(at: Path, name: str, parameters: Mapping[str, float]) -> Iterator[Fault]:
    """What is wrong with an effect as a model file states it at the key path `at`."""
    known = catalogue()
    if name not in known:
        yield Fault((*at, "id"), "there is no effect of this name", name, "one of " + ", ".join(known),
                    nearest(name, known))
        return
    own = {one.name: one for one in known[name].parameters}
    for key, one in own.items():
        if key not in parameters and one.usual is None:
            yield Fault((*at, "parameters", key), f"missing: {name} has no usual one", None, one.range)
    for key, value in parameters.items():
        where = (*at, "parameters", key)
        if key not in own:
            yield Fault(where, f"{name} has no parameter of this name", value, "one of " + ", ".join(own),
                        nearest(key, own))
        elif not (math.isfinite(value) and own[key].allowed(value)):
            yield Fault(where, "is out of its physical range", value, own[key].range)
