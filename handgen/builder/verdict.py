"""The rules over meshes that lie in a folder, shared out to workers: what `check` and `build` ask first."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

from handgen import checks
from handgen.builder import jobs
from handgen.builder.plan import Planned, salt
from handgen.builder.pool import Workers
from handgen.builder.store import CHECKS, Store
from handgen.checks.rule import Outcome
from handgen.export import manifest
from handgen.geometry import csg
from handgen.parameters.load import Loaded

WALLS = ("wall.minimum", "wall.between-bores", "bore.breakthrough")
"""Rules that share one gauge per mesh, and take as long as all the others together."""


class Verdict:
    """Jobs for a pool, and the report once their results are in."""

    def __init__(self, loaded: Loaded, parts: Iterable[str], stage: Path):
        rest = tuple(name for name in checks.names() if name not in WALLS)
        self.loaded = loaded
        self.waiting = {"rules on walls": WALLS, "rules": rest}
        self.arguments = loaded.hand, tuple(parts), stage, str(loaded.file)
        self.outcomes: list[Outcome] = []

    def start(self, pool: Workers) -> None:
        for name, rules in self.waiting.items():
            pool.add([(name, jobs.judge, (rules, *self.arguments))])

    def take(self, name: str, result: Any) -> bool:
        """Whether `result` of job `name` is one of this verdict's; then it is kept.

        Raises:
            GeometryError, EngineError: a rule could not run.
        """
        if self.waiting.pop(name, None) is None:
            return False
        if isinstance(result, Exception):
            raise result
        self.outcomes += result
        return True

    @property
    def report(self) -> dict[str, Any] | None:
        """The contract's report; None while rules are still running."""
        return None if self.waiting else checks.report(self.loaded.hand, self.outcomes)


def judged_key(loaded: Loaded, present: Iterable[Planned]) -> str:
    """Key of a report: the rules, the parameters and the parts that they saw."""
    plugins = [f"{point.name} {point.value} {point.dist.version if point.dist else ''}"
               for point in checks.registered().values()]
    return csg.digest((salt(("checks", "mechanics", "geometry", "materials")), loaded.sha256, *plugins,
                       *(p.key for p in present)))


def publish(report: dict[str, Any], pictures: dict[str, bytes], folder: Path) -> None:
    """The report and its pictures (path -> PNG) as the folder's only content, exchanged as a whole.

    Raises:
        InputError: `folder` holds something that handgen did not write.
    """
    store = Store(folder, CHECKS)
    with store.locked(lambda: None):
        try:
            store.write({CHECKS: manifest.to_bytes(report), **pictures})
            store.commit()
        finally:
            store.discard()
