"""The arguments of `handgen bend` -> a case that can be solved, or everything that is wrong at once."""

from __future__ import annotations

import math
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from handgen.bending import loads, opposition, solvers
from handgen.bending.applied import Applied
from handgen.bending.compose import BODIES, Composer
from handgen.bending.loads import Faults, Numbers
from handgen.bending.model import BendModel, Choice, default_name, load_model
from handgen.bending.opposition import HingeCase
from handgen.effects import Course, Switched
from handgen.errors import InputError, Problem
from handgen.parameters.fault import nearest
from handgen.parameters.load import Loaded, load
from handgen.parameters.model import OPPOSITION, Hand
from handgen.simulation.case import Case, Contact

PARTS = ("assembly", "exoskeleton", "actuator", opposition.PART)
FINEST = 3
NAMES = ("--part", "--finger")
"""Options without which no case can be composed."""
REFERENCE = "reference"
NO_EFFECTS = "the section model of the thumb's hinge knows no effects"
FROM_THE_AXIS = "an actuator that lies in no finger: tip_drop is counted from its axis"


@dataclass(frozen=True)
class Request:
    """A bend that is well defined: what was asked, and the case that answers it."""

    hand: str
    """Name of the hand."""
    finger: str
    part: str
    orientation: str
    model: str
    solver: str
    case: Case | HingeCase
    choices: Mapping[str, Choice]
    """Body ("exoskeleton", "actuator") -> its parameter set."""
    materials: Mapping[str, str]
    """Body -> its material."""
    notes: tuple[str, ...]
    gauge: tuple[float, ...]
    """MPa that the gauge says where the chamber sees the case's pressures."""
    effects: tuple[Switched, ...] = ()
    """What is switched on; those that change readings are at work when the case is solved."""


def request(
    params: str | os.PathLike | Loaded,
    *,
    finger: str | None = None,
    part: str = "assembly",
    pressures: Numbers = None,
    tip_loads: Numbers = None,
    orientation: str | None = None,
    obstacle: float | str | None = None,
    model: str | os.PathLike | BendModel | None = None,
    solver: str | None = None,
    refine: int | str = 0,
    path: str = "loading",
    times: Sequence[float] = (),
    repeats: int = 1,
) -> Request:
    """What to solve.

    `params` is a parameter file, or a hand that is loaded already. `pressures` (kPa) and `tip_loads` (N)
    are "start:end:step", "a,b,c" or a list, rising; left out, 0:100:10 kPa and no weight. `obstacle`: a
    rigid plane so many mm below the palm side. `model`: a name of params/models, a file, or a model; left
    out, `default_name()`.

    `path`: how the loads follow one another: "loading" rises, "unloading" falls from where it was loaded to,
    "hold" and "cycle" are free; `times`, s, of the readings since the first load, and how often the course
    was run (`repeats`, whose mean is asked for) matter to silicone that remembers.

    `part="opposition"` gives the angle of the thumb's hinge instead, from a section model without own weight
    (`handgen.bending.opposition`). What is left out is the index finger, palm down, the solver "solid"; for
    the opposition the thumb, weightless, the solver "section".

    `sideways` bends without own weight, with a note: gravity then acts across the plane of bending, and the
    model is one of half a finger; a weight on the tip is refused there.

    Raises:
        InputError: everything wrong with hand, model and arguments at once.
    """
    problems: list[Problem] = []
    faults = Faults()
    loaded = params if isinstance(params, Loaded) else _attempt(problems, load, params)
    chosen = _attempt(problems, load_model, model if model is not None else default_name())
    _one_of("--part", part, PARTS, faults)
    hinged = part == opposition.PART
    finger = finger if finger is not None else "thumb" if hinged else "index"
    orientation = orientation if orientation is not None else "weightless" if hinged else "palm_down"
    solver = solver if solver is not None else solvers.names(part)[0]
    _one_of("--solver", solver, solvers.names(part), faults)
    gravity = loads.orientation(orientation, part, faults)
    kilopascals = loads.pressures(pressures, part, faults, path)
    newtons = loads.tip_loads(tip_loads, part, orientation, faults, path)
    plane = loads.obstacle(obstacle, part, faults)
    finer = _refine(refine, part, faults)
    if loaded is not None:
        _bendable(finger, part, loaded.hand, faults)
    composed = None
    if loaded is not None and chosen is not None and not any(p.path in NAMES for p in faults):
        composed = _composed(loaded, chosen, finger, part, dict(
            gravity=gravity, tip_loads=newtons, obstacle=plane, refine=finer),
            (kilopascals, path, times, repeats), problems)
    if solver == solvers.ROD and finer:
        faults.say("--refine", refine, "the rod has no mesh", "leave it out")
    if composed is not None and solver in (REFERENCE, solvers.ROD) and not hinged and composed[1].extended:
        faults.say("--solver", solver, f"does not know {', '.join(composed[1].extended)}", "solid")
    if composed is not None and solver == solvers.REVOLUTION and part == "actuator":
        _round(composed[1], orientation, faults)
    if problems or faults or composed is None:
        raise InputError([*problems, *faults])
    composer, case, switched = composed
    if hinged:
        case = composer.measured(case)
    materials = {body: composer.material(body)[0] for body in BODIES if part in (body, "assembly") or hinged}
    return Request(
        loaded.hand.name, finger, part, orientation, composer.model.name, solver, case,
        {body: composer.model.materials[name] for body, name in materials.items()}, materials,
        (*_notes(finger, part, orientation), *(one.sentence for one in switched)),
        tuple(1e-3 * p for p in kilopascals), switched)


def _composed(loaded: Loaded, chosen: tuple[BendModel, str], finger: str, part: str, loading: dict,
              course: tuple, problems: list[Problem]) -> tuple[Composer, Case | HingeCase, tuple] | None:
    """(composer, case, effects that are on); None, and why in `problems`, if hand or model do not allow it.

    `course`: kPa that the gauge says, path, times and repeats.
    """
    model, file = chosen
    switched = tuple(model.switched)
    if switched and part == opposition.PART:
        problems.append(Problem(file, "effects", switched[0].effect.id, NO_EFFECTS, "another --part"))
        return None
    applied = Applied(switched, file, problems)
    model = applied.model(model)
    gauge, path, times, repeats = course
    seen = gauge if part == "exoskeleton" else applied.chamber(gauge)
    composer = Composer(applied.hand(loaded, finger), model, file, pressures=tuple(1e-3 * p for p in seen))
    loading["gravity"] = _acting(loading["gravity"], model, part)
    loading["contact"] = Contact(model.friction, model.bonded)
    if part in ("assembly", "exoskeleton"):
        loading |= dict(curl_taken=model.curl_taken, root_angle=math.radians(model.root_angle))
    case = _case(composer, finger, part, loading)
    problems += (p for i, p in enumerate(composer.problems) if p not in composer.problems[:i])
    if case is not None and part != opposition.PART:
        case = applied.case(case, Course(tuple(seen), path, tuple(times), repeats))
    return None if case is None else (composer, case, switched)


def _round(case: Case, orientation: str, faults: Faults) -> None:
    """Whether the actuator of `case` stays round about its axis."""
    if case.extended:
        faults.say("--solver", solvers.REVOLUTION, f"does not know {', '.join(case.extended)}", "solid")
    if any(case.gravity):
        faults.say("--orientation", orientation, loads.OFF_AXIS, loads.WEIGHTLESS)


def _acting(gravity: tuple[float, ...], model: BendModel, part: str) -> tuple[float, ...]:
    """Gravity as the model lets it act on `part`."""
    share = getattr(model.own_weight, part, 1.0)
    return tuple(share * g for g in gravity)


def _notes(finger: str, part: str, orientation: str) -> Iterator[str]:
    """What a user must know of all points."""
    if part == opposition.PART:
        yield opposition.NO_WEIGHT
    if orientation == "sideways":
        yield loads.SIDEWAYS
    if part == "actuator" and finger in OPPOSITION:
        yield FROM_THE_AXIS


def _case(composer: Composer, name: str, part: str, loading: dict) -> Case | HingeCase | None:
    """The case; None if the hand or the model do not allow it."""
    if part == opposition.PART:
        return composer.hinge()
    hand = composer.loaded.hand
    profile = winding = silicone = tpu = finger = None
    held = 0.0
    if part != "exoskeleton":
        profile, silicone = composer.actuator(name), composer.substance("actuator")
        if profile is not None:
            winding, held = composer.winding(name, profile), composer.held(profile)
            composer.bears(name, profile, winding, held, silicone)
    if part != "actuator":
        tpu = composer.substance("exoskeleton")
    if name in hand.fingers.present():
        finger = composer.finger(name, curled=part != "actuator")
    if composer.problems:
        return None
    return Case(part, finger, hand.exoskeleton.joint_fillet, profile, winding, tpu, silicone, held,
                pressures=composer.pressures, **loading)


def _bendable(finger: str, part: str, hand: Hand, faults: Faults) -> None:
    """Whether `--finger` names what has this part: an opposition actuator can be bent on its own."""
    if part != opposition.PART:
        there = hand.actuators.present() if part == "actuator" else hand.fingers.present()
        _one_of("--finger", finger, there, faults)
    elif hand.opposition is None or hand.palm is None:
        faults.say("--part", part, f"the thumb of {hand.name} has no hinge",
                   "a hand with `palm` and `opposition`")
    else:
        _one_of("--finger", finger, ["thumb"], faults)


def _refine(given: int | str, part: str, faults: Faults) -> int:
    text = str(given)
    if not (text.isdecimal() and int(text) <= FINEST):
        faults.say("--refine", given, "is no refinement", f"0, 1, ... {FINEST}")
        return 0
    if part == opposition.PART and int(text):
        faults.say("--refine", given, "the section model of the thumb's hinge has no mesh", "leave it out")
    return int(text)


def _one_of(option: str, given: str, valid: Iterable[str], faults: Faults) -> None:
    valid = list(valid)
    if given not in valid:
        faults.say(option, given, "there is none of this name", "one of " + ", ".join(valid),
                   nearest(given, valid))


def _attempt(problems: list[Problem], function, argument) -> Any:
    try:
        return function(argument)
    except InputError as error:
        problems += error.problems
        return None
