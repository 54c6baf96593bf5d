"""The build: load, judge, make what is new, keep what is not, exchange the folder."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from dataclasses import asdict
from pathlib import Path
from typing import Any

from handgen import __version__, checks
from handgen.build import jobs, pictures
from handgen.build.plan import Planned, digests, groups, kept, plan
from handgen.build.pool import Workers, default_count
from handgen.build.store import CHECKS, MANIFEST, Store
from handgen.export import manifest
from handgen.geometry.actuator import adaptations
from handgen.geometry.catalogue import catalogue, select
from handgen.parameters.load import Loaded, load

Progress = Callable[[str], None]


def build(
    params: str | os.PathLike,
    out: str | os.PathLike | None = None,
    parts: Iterable[str] | None = None,
    verify: bool = True,
    progress: Progress | None = None,
    workers: int | None = None,
) -> dict[str, Any]:
    """Build the hand of the parameter file `params` into the folder `out` (`outputs/<name>`).

    `parts` limits what is made to names or globs (see `catalogue.select`); parts of an earlier
    build that are still right stay. `verify=False` writes even what breaks a rule. `progress`
    is told one line per part; `workers` is the number of processes (default: one a processor).

    Returns {"name", "out", "manifest", "checks", "passed"}: `manifest` as written,
    empty when a broken rule kept everything from being written; `checks` the contract's report.

    Raises:
        InputError: bad parameters, an unknown part, a folder that is not handgen's.
        GeometryError: a part cannot be made; the earlier build is left as it was.
        EngineError: a kernel or a worker gave up; the earlier build is left as it was.
    """
    loaded = load(params)
    listed = catalogue(loaded.hand)
    wanted = set(select(listed, parts or None))
    store = Store(Path(out) if out is not None else Path("outputs") / loaded.hand.name)
    report = checks.definition(loaded.hand)
    if verify and not report["passed"]:
        return _result(loaded, store, report, {})
    say = progress or (lambda line: None)
    with store.locked(lambda: say(f"waiting for another build of {store.final}")) as lock:
        return _Build(loaded, store, say, verify).run(
            plan(loaded.hand, listed.values()), wanted, workers or default_count(), lock)


def _result(loaded: Loaded, store: Store, report: dict, written: dict) -> dict[str, Any]:
    return {"name": loaded.hand.name, "out": str(store.final), "manifest": written,
            "checks": report, "passed": report["passed"]}


class _Build:
    """One run under the folder's lock."""

    def __init__(self, loaded: Loaded, store: Store, say: Progress, verify: bool):
        self.loaded, self.store, self.say, self.verify = loaded, store, say, verify
        self.previous = store.manifest()
        self.files: dict[str, str] = {}
        self.warnings: list[str] = []
        self.made = False

    def run(self, planned: list[Planned], wanted: set[str], workers: int, lock: int) -> dict[str, Any]:
        rows = kept(planned, self.store, self.previous)
        missing = [p for p in planned if p.part.name in wanted and p.part.name not in rows]
        present = [p for p in planned if p.part.name in rows or p in missing]
        try:
            for row in rows.values():
                self._keep(row["files"].values())
            with Workers(workers, lock) as pool:
                rows |= self._make(missing, pool, len(rows))
                ordered = [rows[p.part.name] for p in present]
                report = checks.everything(self.loaded.hand, ordered)
                if self.verify and not report["passed"]:
                    return _result(self.loaded, self.store, report, {})
                shown = self._show(present, pool)
            return self._finish(ordered, shown, report)
        finally:
            self.store.discard()

    def _keep(self, paths: Iterable[str]) -> None:
        """Files of the previous build that stay as they are."""
        files = digests(self.previous, paths)
        self.store.reuse(files)
        self.files |= files

    def _make(self, missing: list[Planned], pool: Workers, done: int) -> dict[str, dict]:
        """Make the missing parts; their rows of the manifest by name."""
        by_name = {p.part.name: p for p in missing}
        work = [[(p.part.name, jobs.make, (p.part, self.store.stage, p.extra)) for p in group]
                for group in groups(missing)]
        if done:
            self.say(f"unchanged: {done} parts")
        rows = {}
        for name, made in pool.run(work):
            planned = by_name[name]
            rows[name] = manifest.entry(
                planned.part, planned.key, made.facts, made.step_volume_mm3, made.files)
            self.files |= made.files
            self.made = True
            self.say(f"[{len(rows)}/{len(missing)}] {name}")
        return rows

    def _show(self, present: list[Planned], pool: Workers) -> list[dict[str, Any]]:
        """Assembly and previews: kept by key like parts; without OpenGL left out with a warning."""
        old = {row["file"]: row for row in (self.previous or {}).get("views", [])}
        shown, work = [], []
        for view in pictures.views(self.loaded.hand, self.loaded.sha256, present):
            row = {"file": view.file, "shows": list(view.shows), "key": view.key}
            if old.get(view.file) == row and self.store.intact(digests(self.previous, [view.file])):
                self._keep([view.file])
                shown.append(row)
            else:
                work.append((row, (view.file, view.make, (self.store.stage, view.file))))
        rows = {row["file"]: row for row, _ in work}
        for file, outcome in pictures.draw(pool, [job for _, job in work]):
            if outcome.sha256:
                self.files[file] = outcome.sha256
                self.made = True
                shown.append(rows[file])
                self.say(file)
            elif outcome.warning not in self.warnings:
                self.warnings.append(outcome.warning)
                self.say(f"warning: {outcome.warning}")
        return sorted(shown, key=lambda row: row["file"])

    def _finish(self, rows: list[dict], shown: list[dict], report: dict) -> dict[str, Any]:
        """Write manifest and checks and put the build in its place, unless nothing changed."""
        document = {
            "schema": manifest.SCHEMA,
            "name": self.loaded.hand.name,
            "handgen_version": __version__,
            "parameters_sha256": self.loaded.sha256,
            "verified": self.verify,
            "parts": rows,
            "views": shown,
            "adaptations": [asdict(a) for a in adaptations(self.loaded.hand)],
            "assumptions": self.loaded.assumptions,
            "notes": [jobs.BLENDED_NOTE] if any(r["name"] == jobs.HAND for r in rows) else [],
            "warnings": self.warnings,
            "files": dict(sorted(self.files.items())),
        }
        written = {MANIFEST: manifest.to_bytes(document), CHECKS: manifest.to_bytes(report)}
        if self.made or not self.store.same(written):
            self.store.write(written)
            self.store.carry_over({*(self.previous or {}).get("files", ()), MANIFEST, CHECKS})
            self.store.commit()
        return _result(self.loaded, self.store, report, document)
