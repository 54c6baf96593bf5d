"""A design without its files for makers: every mesh, what is measured on it, and the rules' report.

Meshes come from a build that still holds, else from the cache, else they are made; so do reports. A design
that breaks a rule is surveyed like any other: nothing here is for the printer.
"""

from __future__ import annotations

import json
import os
import shutil
import tempfile
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from handgen import checks
from handgen.builder import jobs
from handgen.builder.plan import Planned, groups, kept, plan
from handgen.builder.pool import Workers, default_count
from handgen.builder.shelf import Shelf
from handgen.builder.store import Store
from handgen.builder.verdict import Verdict, judged_key
from handgen.geometry.catalogue import catalogue
from handgen.geometry.measure import Facts, measure, read_stl
from handgen.geometry.part import Part
from handgen.parameters.load import Loaded, load

Progress = Callable[[str], None]


@dataclass(frozen=True)
class Surveyed:
    """A part with its mesh as it would be printed."""

    part: Part
    stl: Path
    facts: Facts


@dataclass(frozen=True)
class Survey:
    """A design as it stands; the STLs lie there as long as the survey is open."""

    loaded: Loaded
    parts: Mapping[str, Surveyed]
    report: Mapping[str, Any] | None
    """The contract's handgen.checks/1; None where only what is `known` was asked for and this is not."""
    built: Mapping[str, Any] | None
    """The manifest of a build of these very parts; None where there is none in the folder."""
    keys: Mapping[str, str]
    """Every part, surveyed or not -> key of its content: equal keys have equal files."""


@contextmanager
def survey(params: str | os.PathLike | Loaded, out: str | os.PathLike | None = None,
           progress: Progress | None = None, workers: int | None = None, *, known: bool = False
           ) -> Iterator[Survey]:
    """Survey the hand of `params`; `out` is where its build lies, if there is one (`outputs/<name>`).

    `known`: nothing is made or judged; parts and report are those of earlier runs.

    Raises:
        InputError: bad parameters, or a folder that is not handgen's.
        GeometryError: a part cannot be made.
        EngineError: a kernel, a worker or another package's rule gave up.
    """
    loaded = params if isinstance(params, Loaded) else load(params)
    checks.own_limits(loaded.hand, str(loaded.file))
    store = Store(Path(out) if out is not None else Path("outputs") / loaded.hand.name)
    planned = plan(loaded.hand, catalogue(loaded.hand).values())
    manifest = store.manifest()
    rows = kept(planned, store, manifest)
    with tempfile.TemporaryDirectory(prefix="handgen-") as place:
        survey_ = _Survey(loaded, planned, Path(place), progress or (lambda line: None))
        survey_.fetch({name: store.final / row["files"]["stl"] for name, row in rows.items()})
        report = survey_.judged() if known else survey_.work(workers or default_count())
        whole = len(rows) == len(planned) and manifest["parameters_sha256"] == loaded.sha256
        yield Survey(loaded, survey_.measured(), report, manifest if whole else None,
                     {one.part.name: one.key for one in planned})


class _Survey:
    """The meshes of one design in the folder `stage`, and the rules over them."""

    def __init__(self, loaded: Loaded, planned: list[Planned], stage: Path, say: Progress):
        self.loaded, self.planned, self.stage, self.say = loaded, planned, stage, say
        self.meshes, self.reports = Shelf("meshes", ".stl"), Shelf("checks", ".json")
        self.facts: dict[str, Facts] = {}

    def _path(self, name: str) -> Path:
        return self.stage / f"{name}.stl"

    def fetch(self, built: Mapping[str, Path]) -> None:
        """Bring the meshes that exist: `built` names those of a build."""
        for one in self.planned:
            name = one.part.name
            self._path(name).parent.mkdir(parents=True, exist_ok=True)
            if name in built:
                shutil.copyfile(built[name], self._path(name))
            elif (content := self.meshes.get(one.key)) is not None:
                self._path(name).write_bytes(content)
            try:
                self.facts[name] = measure(read_stl(self._path(name).read_bytes()))
            except (FileNotFoundError, ValueError):
                continue  # it is made anew

    def judged(self) -> dict[str, Any] | None:
        """The report that is known."""
        known = self.reports.get(judged_key(self.loaded, self.planned))
        return None if known is None else json.loads(known)

    def work(self, workers: int) -> dict[str, Any]:
        """Make the missing meshes and judge them all; returns the report."""
        missing = [one for one in self.planned if one.part.name not in self.facts]
        report = self.judged()
        if not missing and report is not None:
            return report
        with tempfile.TemporaryFile() as lock, Workers(workers, lock.fileno(), ("manifold3d",)) as pool:
            pool.warm(max(len(missing), 1))
            self._mesh(missing, pool)
            report = report or self._judge(pool)
        self.reports.put(judged_key(self.loaded, self.planned), json.dumps(report).encode())
        return report

    def _mesh(self, missing: list[Planned], pool: Workers) -> None:
        for group in groups(missing):
            pool.add([(one.part.name, jobs.mesh, (one.part, self.stage, {})) for one in group])
        keys = {one.part.name: one.key for one in missing}
        for name, result in pool.results():
            if isinstance(result, Exception):
                raise result
            self.facts[name] = result.facts
            self.meshes.put(keys[name], self._path(name).read_bytes())
        if missing:
            self.say(f"{len(missing)} parts meshed, {len(self.planned) - len(missing)} known")

    def _judge(self, pool: Workers) -> dict[str, Any]:
        verdict = Verdict(self.loaded, [one.part.name for one in self.planned], self.stage)
        verdict.start(pool)
        for name, result in pool.results():
            verdict.take(name, result)
            self.say(f"{name}: done")
        return verdict.report

    def measured(self) -> dict[str, Surveyed]:
        return {one.part.name: Surveyed(one.part, self._path(one.part.name), self.facts[one.part.name])
                for one in self.planned if one.part.name in self.facts}
