"""The arguments of `handgen bend` -> a case that can be solved, or everything that is wrong at once."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from handgen.bending import loads, solvers
from handgen.bending.compose import Composer
from handgen.bending.loads import Faults, Numbers
from handgen.bending.model import Choice, default_name, load_model
from handgen.errors import InputError, Problem
from handgen.parameters.fault import nearest
from handgen.parameters.load import Loaded, load
from handgen.parameters.model import Hand
from handgen.simulation.case import Case, Contact

PARTS = ("assembly", "exoskeleton", "actuator")
FINEST = 3


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
    case: Case
    choices: Mapping[str, Choice]
    """Body ("exoskeleton", "actuator") -> its parameter set."""
    materials: Mapping[str, str]
    """Body -> its material."""
    notes: tuple[str, ...]


def request(
    params: str | os.PathLike | Loaded,
    *,
    finger: str = "index",
    part: str = "assembly",
    pressures: Numbers = None,
    tip_loads: Numbers = None,
    orientation: str = "palm_down",
    obstacle: float | str | None = None,
    model: str | os.PathLike | None = None,
    solver: str = "solid",
    refine: int | str = 0,
) -> Request:
    """What to solve.

    `params` is a parameter file, or a hand that is loaded already. `pressures` (kPa) and `tip_loads` (N)
    are "start:end:step", "a,b,c" or a list, rising; left out, 0:100:10 kPa and no weight. `obstacle`: a
    rigid plane so many mm below the palm side. `model`: a name of params/models or a file; left out,
    `default_name()`.

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
    _one_of("--orientation", orientation, loads.ORIENTATIONS, faults)
    _one_of("--solver", solver, solvers.names(), faults)
    kilopascals = loads.pressures(pressures, part, faults)
    newtons = loads.tip_loads(tip_loads, part, orientation, faults)
    plane = loads.obstacle(obstacle, part, faults)
    finer = _refine(refine, faults)
    if loaded is not None:
        _one_of("--finger", finger, _bendable(loaded.hand, part), faults)
    if problems or faults or loaded is None or chosen is None:
        raise InputError([*problems, *faults])
    composer = Composer(loaded, *chosen)
    case = _case(composer, finger, part, dict(
        contact=Contact(chosen[0].friction, chosen[0].bonded), gravity=loads.ORIENTATIONS[orientation],
        pressures=tuple(1e-3 * p for p in kilopascals), tip_loads=newtons, obstacle=plane, refine=finer))
    if case is None:
        raise InputError(composer.problems)
    bodies = [body for body in ("exoskeleton", "actuator") if part in (body, "assembly")]
    materials = {body: composer.material(body)[0] for body in bodies}
    return Request(
        loaded.hand.name, finger, part, orientation, chosen[0].name, solver, case,
        {body: chosen[0].materials[name] for body, name in materials.items()}, materials,
        (loads.SIDEWAYS,) if orientation == "sideways" else ())


def _case(composer: Composer, name: str, part: str, loading: dict) -> Case | None:
    """The case; None if the hand or the model do not allow it."""
    hand = composer.loaded.hand
    profile = winding = silicone = tpu = finger = None
    held = 0.0
    if part != "exoskeleton":
        profile, silicone = composer.actuator(name), composer.substance("actuator")
        if profile is not None:
            winding, held = composer.winding(name, profile), composer.held(profile)
    if part != "actuator":
        tpu = composer.substance("exoskeleton")
    if name in hand.fingers.present():
        finger = composer.finger(name)
    if composer.problems:
        return None
    return Case(part, finger, hand.exoskeleton.joint_fillet, profile, winding, tpu, silicone, held, **loading)


def _bendable(hand: Hand, part: str) -> list[str]:
    """Names that `--finger` may take: an opposition actuator can be bent on its own."""
    return list(hand.actuators.present() if part == "actuator" else hand.fingers.present())


def _refine(given: int | str, faults: Faults) -> int:
    text = str(given)
    if not (text.isdecimal() and int(text) <= FINEST):
        faults.say("--refine", given, "is no refinement", f"0, 1, ... {FINEST}")
        return 0
    return int(text)


def _one_of(option: str, given: str, valid: Mapping | tuple | list, faults: Faults) -> None:
    if given not in valid:
        faults.say(option, given, "there is none of this name", "one of " + ", ".join(valid),
                   nearest(given, valid))


def _attempt(problems: list[Problem], function, argument) -> Any:
    try:
        return function(argument)
    except InputError as error:
        problems += error.problems
        return None
