"""What a bend is computed with and no hand says: parameter sets, friction, how the base is held.

A file of `schema: handgen.model/1`; those that come with handgen lie in params/models and go by their name.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, ValidationError

from handgen import effects
from handgen.errors import InputError, Problem
from handgen.materials import library
from handgen.materials.sets import ParameterSet
from handgen.parameters import explain
from handgen.parameters.document import Document
from handgen.parameters.fault import Fault, nearest, text
from handgen.parameters.quantity import Model, item, quantity
from handgen.parameters.single import load_single, validated

SCHEMA = "handgen.model/1"
FOLDER = Path(__file__).parents[2] / "params" / "models"
DEFAULTS = ("calibrated", "literature")
"""The first of them that exists is used where none is named."""


class Choice(Model):
    """The parameter set of one material."""

    name: str = item("of a set of the library, or where an own one stands")
    parameters: ParameterSet

    @property
    def density(self) -> float | None:
        """tonne/mm3; None where neither the set nor the library's material has one."""
        if self.parameters.density is None and self.parameters.material not in library.library().materials:
            return None
        return library.density(self.parameters)


class BulkRatio(Model):
    """Bulk over shear modulus: how nearly incompressible."""

    exoskeleton: float = quantity(
        "1", 5, 1e5, "of the printed exoskeleton", default=50.0,
        assumed="no source gives TPU's bulk modulus; Poisson's ratio of 0.490 is usual for solid TPU")
    actuator: float = quantity(
        "1", 5, 1e5, "of the silicone", default=1000.0,
        assumed="silicones' bulk moduli are of the order of 1 GPa; beyond 1000 only the effort changes")


class ThreadModel(Model):
    """Where the thread is taken to lie."""

    depth: float | None = quantity(
        "mm", -2, 3, "how far its centre lies outside the large core; null: as wound, half its diameter "
        "(0 in a groove)", default=None)


class OwnWeight(Model):
    """How much of its own weight acts on a part, where something does not carry it (`--orientation`)."""

    assembly: float = quantity("1", 0, 2, "share for a finger with its actuator", default=1.0)
    exoskeleton: float = quantity("1", 0, 2, "share for a bare exoskeleton", default=1.0)
    actuator: float = quantity("1", 0, 2, "share for a free actuator", default=1.0)


class Effect(Model):
    """A physical effect that is switched on: `handgen effects` lists them."""

    id: str = item("name of the effect")
    parameters: dict[str, float] = item(
        "its parameters by name; one that is left out has its usual value", default_factory=dict)
    intervals: dict[str, Annotated[list[float], Field(min_length=2, max_length=2)]] = item(
        "[from, to] within which a parameter lies with 90 %, where measurements have found it; for people",
        default_factory=dict)


class BendModel(Model):
    """All that a bend needs beside the hand."""

    schema_: Literal["handgen.model/1"] = Field(alias="schema", description="version of this format")
    name: Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9_-]{0,63}$")] = item("names the model")
    description: str = item("one line for people", default="", max_length=400)
    materials: dict[str, Choice] = item(
        "material as parameter files call it -> set of the library, or a set of its own", min_length=1)
    bulk_ratio: BulkRatio = item("bulk over shear modulus", default_factory=BulkRatio)
    friction: float = quantity(
        "1", 0, 2, "Coulomb's coefficient between actuator and bore, along the axis", default=0.8,
        assumed="silicone on TPU, not measured; dry silicone rubber slides at 1 and more, dust and release "
                "agent take some of it; with less than 0.3 the finger folds below 100 kPa")
    bonded: bool = item("the actuator sticks to the bore: no model of a hand, for comparison", default=False)
    held_length: float | None = quantity(
        "mm", 0, 40, "over which plug and collar hold the actuator's base; null: the plug's length",
        default=None)
    curl_taken: float = quantity(
        "1", 0, 1, "share of a finger's rest curl in which its actuator, cast straight, is free of stress; "
        "with 0 it pulls the resting finger towards straight, as an elastic body does", default=1.0,
        assumed="platinum silicone takes a set of a few percent: a curl of the strips would strain the "
                "actuator; what hangs from the finger's root strains none, and no test of the bare finger "
                "tells the two apart: with 0 the source's finger would hang 9 mm too high at rest")
    root_angle: float = quantity(
        "deg", -90, 90, "by which a finger, at its root, hangs below the palm's plane before it bends",
        default=0.0)
    thread: ThreadModel = item("the reinforcement", default_factory=ThreadModel)
    own_weight: OwnWeight = item("what of it the model takes into account", default_factory=OwnWeight)
    effects: list[Effect] = item("switched on", default_factory=list)
    fitted: list[str] = item(
        "ids of the tests of a measurements file that its numbers were fitted on", default_factory=list)
    assumed: dict[str, str] = item("key path -> why this value, which no source gives", default_factory=dict)
    sources: dict[str, str] = item("key -> where numbers come from", default_factory=dict)

    @property
    def switched(self) -> list[effects.Switched]:
        """The effects that are on, in their order, with all of their parameters."""
        known = effects.catalogue() if self.effects else {}
        return [effects.Switched(known[one.id], known[one.id].filled(one.parameters)) for one in self.effects]


def default_name() -> str:
    """The model that is used where none is named."""
    return next(name for name in DEFAULTS if name in names() or name == DEFAULTS[-1])


def names() -> list[str]:
    """Models that come with handgen."""
    return sorted(path.stem for path in FOLDER.glob("*.yaml"))


def load_model(wanted: str | os.PathLike | BendModel) -> tuple[BendModel, str]:
    """The model of a name ("literature") or file, and the file that it stands in; a model is taken as it is.

    Raises:
        InputError: no such model, with the nearest name; every error of the file; wrong effects of a model.
    """
    if isinstance(wanted, BendModel):
        where = f"model {wanted.name}"
        if found := _wrong_effects(wanted):
            raise InputError([Problem(where, text(f.path), f.value, f.message, f.allowed, f.suggestion)
                              for f in found])
        return wanted, where
    file = path_of(wanted)
    return load_single(file, BendModel, SCHEMA, _chosen, _wrong_effects), file


def model_of(data: Mapping[str, Any], file: str) -> BendModel:
    """The model that `data` spells out; `file` is named in errors.

    Raises:
        InputError: every error of it.
    """
    return validated(Document(file, dict(data)), BendModel, SCHEMA, _chosen, _wrong_effects)


def path_of(wanted: str | os.PathLike) -> str:
    """The file of the model that `wanted` names ("literature") or is.

    Raises:
        InputError: there is none of this name, with the nearest.
    """
    word = os.fspath(wanted)
    named = not (os.sep in word or word.endswith((".yaml", ".yml")) or os.path.exists(word))
    if named and word not in names():
        raise InputError([Problem("command line", "--model", word, "there is no model of this name",
                                  f"a YAML file, or one of {', '.join(names())}", nearest(word, names()))])
    return str(FOLDER / f"{word}.yaml") if named else word


def _chosen(data: dict) -> list[Fault]:
    """Replace the sets of `materials` by what they name or spell out; those that cannot be are dropped."""
    found = data.get("materials")
    if not isinstance(found, dict):
        return []
    faults: list[Fault] = []
    data["materials"] = {}
    for material, given in found.items():
        at = ("materials", material)
        if isinstance(given, str):
            wrong = list(_misnamed(at, material, given))
        elif isinstance(given, dict):
            wrong = list(_misspelt(at, material, given))
        else:
            wrong = [Fault(at, "should name a set of the library, or be one", given)]
        faults += wrong
        if not wrong:
            data["materials"][material] = _choice(material, given)
    if faults and not data["materials"]:
        del data["materials"]
        faults.append(Fault(("materials",), "no material is left"))
    return faults


def _choice(material: str, given: str | Mapping[str, Any]) -> Choice:
    if isinstance(given, str):
        return Choice(name=given, parameters=library.parameter_set(given))
    return Choice(name=f"materials.{material}", parameters=_own(material, given))


def _own(material: str, given: Mapping[str, Any]) -> ParameterSet:
    return ParameterSet.model_validate({**given, "material": material})


def _misnamed(at: tuple[str, str], material: str, name: str) -> Iterator[Fault]:
    sets = library.library().sets
    if name not in sets:
        yield Fault(at, "the library has no set of this name", name, "one of " + ", ".join(sets),
                    nearest(name, sets))
    elif sets[name].material != material:
        fitting = [key for key, one in sets.items() if one.material == material]
        yield Fault(at, f"is a set of {sets[name].material}", name,
                    "one of " + ", ".join(fitting) if fitting else "a set of its own")


def _misspelt(at: tuple[str, str], material: str, given: dict) -> Iterator[Fault]:
    """An own set is one of library.yaml without `material`, which is its key here."""
    if "material" in given:
        yield Fault((*at, "material"), "unknown key: the set stands under its material", given["material"])
        return
    try:
        _own(material, given)
    except ValidationError as error:
        for fault in explain.faults(ParameterSet, error):
            yield fault._replace(path=(*at, *fault.path), message=fault.message.removeprefix("Value error, "))


def _wrong_effects(model: BendModel) -> list[Fault]:
    found = [fault for i, one in enumerate(model.effects)
             for fault in effects.faults(("effects", i), one.id, one.parameters)]
    found += [Fault(("effects", i, "intervals", name), "belongs to no parameter that is stated", span,
                    "one of " + ", ".join(one.parameters) if one.parameters else "none")
              for i, one in enumerate(model.effects) for name, span in one.intervals.items()
              if name not in one.parameters]
    before = [one.id for one in model.effects]
    return found + [Fault(("effects", i, "id"), "is switched on twice", name, "each effect once")
                    for i, name in enumerate(before) if name in before[:i]]
