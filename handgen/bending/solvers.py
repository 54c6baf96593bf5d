"""Solvers by name: those of handgen, and those that other packages hang in (entry points)."""

from __future__ import annotations

import hashlib
import inspect
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from importlib.metadata import EntryPoint
from pathlib import Path

from handgen.bending import opposition
from handgen.errors import EngineError
from handgen.plugins import entry_points
from handgen.simulation.case import Case, Curve

GROUP = "handgen.solvers"
"""Entry points of this group are solvers: `simulate(case, progress=None) -> Curve`."""
ROD = "rod"
"""The reduced model, which knows whole fingers only."""
REVOLUTION = "revolution"
"""The section, which knows free actuators only."""
OWN = {
    "solid": "handgen.simulation.solid",
    "reference": "handgen.simulation.reference",
    ROD: "handgen.simulation.rod",
    REVOLUTION: "handgen.simulation.revolution",
    opposition.SOLVER: "handgen.bending.opposition",
}
"""Modules of handgen whose `simulate` is a solver; loaded when used. The first is the default."""
SOURCES = ("simulation", "materials", "mechanics", "geometry/profile.py", "geometry/finger.py",
           "geometry/csg.py", "geometry/strip.py", "parameters/derive.py", "bending/opposition.py")
"""What the own solvers' results depend on, in the package."""

Simulate = Callable[[Case, Callable[[str], None] | None], Curve]


@dataclass(frozen=True)
class Solver:
    """A solver that can be called; equal `version`s of one name give equal results."""

    name: str
    simulate: Simulate
    version: str


def registered() -> dict[str, EntryPoint]:
    """Solvers of other packages by name.

    Raises:
        EngineError: two packages register the same name, or one that handgen has.
    """
    found: dict[str, EntryPoint] = {}
    for point in entry_points(group=GROUP):
        if point.name in OWN or point.name in found:
            raise EngineError(f"the solver {point.name!r} is registered twice, once by {point.value}")
        found[point.name] = point
    return found


def names(part: str = "assembly") -> list[str]:
    """Solvers that bend `part`, handgen's own first."""
    if part == opposition.PART:
        return [opposition.SOLVER]
    only = {opposition.SOLVER: opposition.PART, ROD: "assembly", REVOLUTION: "actuator"}
    return [name for name in OWN if only.get(name, part) == part] + sorted(registered())


def solver(name: str) -> Solver:
    """The solver `name`, loaded.

    Raises:
        EngineError: it cannot be loaded, e.g. because a package that it needs is missing; the code of
            another package may fail in any way.
        KeyError: there is none of this name.
    """
    point = None if name in OWN else registered()[name]
    try:
        if point is None:
            return Solver(name, import_module(OWN[name]).simulate, _own_version())
        return Solver(name, point.load(), _version(point))
    except Exception as error:
        raise EngineError(
            f"the solver {name!r} cannot be loaded: {type(error).__name__}: {error}") from error


def _version(point: EntryPoint) -> str:
    """Package, version and the file that defines the solver: one that is being worked on is another one."""
    package = f"{point.dist.name} {point.dist.version}" if point.dist else ""
    try:
        file = Path(inspect.getsourcefile(inspect.unwrap(point.load())) or "")
        source = hashlib.sha256(file.read_bytes()).hexdigest()
    except (OSError, TypeError):
        source = ""
    return f"{point.value} {package} {source}"


def _files(path: Path) -> list[Path]:
    """Sources and data below `path`, or itself."""
    return sorted(p for p in path.rglob("*") if p.suffix in (".py", ".json")) if path.is_dir() else [path]


@cache
def _own_version() -> str:
    """Hash of the sources that the own solvers' results depend on."""
    root, total = Path(__file__).parents[1], hashlib.sha256()
    for name in SOURCES:
        path = root / name
        for file in _files(path):
            total.update(str(file.relative_to(root)).encode() + b"\0" + file.read_bytes())
    return total.hexdigest()
