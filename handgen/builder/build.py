"""The build: load, judge, make what is new, keep what is not, exchange the folder."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from dataclasses import asdict
from pathlib import Path
from typing import Any

from handgen import __version__, checks
from handgen.builder import jobs, pictures
from handgen.builder.pictures import View
from handgen.builder.plan import Planned, digests, groups, kept, plan
from handgen.builder.pool import Workers, default_count
from handgen.builder.store import CHECKS, MANIFEST, Store
from handgen.errors import EngineError
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


def _view_row(view: View) -> dict[str, Any]:
    return {"file": view.file, "shows": list(view.shows), "key": view.key}


class _Build:
    """One run under the folder's lock."""

    def __init__(self, loaded: Loaded, store: Store, say: Progress, verify: bool):
        self.loaded, self.store, self.say, self.verify = loaded, store, say, verify
        self.previous = store.manifest()
        self.files: dict[str, str] = {}
        self.views: list[dict[str, Any]] = []
        self.warnings: list[str] = []
        self.changed = False

    def run(self, planned: list[Planned], wanted: set[str], workers: int, lock: int) -> dict[str, Any]:
        rows = kept(planned, self.store, self.previous)
        missing = [p for p in planned if p.part.name in wanted and p.part.name not in rows]
        present = [p for p in planned if p.part.name in rows or p in missing]
        try:
            for row in rows.values():
                self._keep(row["files"].values())
            with Workers(workers, lock) as pool:
                pool.warm(len(missing))
                self._make(missing, pictures.views(self.loaded.hand, self.loaded.sha256, present), rows, pool)
            ordered = [rows[p.part.name] for p in present]
            report = checks.everything(self.loaded.hand, ordered)
            if self.verify and not report["passed"]:
                return _result(self.loaded, self.store, report, {})
            return self._finish(ordered, report)
        finally:
            self.store.discard()

    def _keep(self, paths: Iterable[str]) -> None:
        """Files of the previous build that stay as they are."""
        files = digests(self.previous, paths)
        self.store.reuse(files)
        self.files |= files

    def _make(self, missing: list[Planned], views: list[View], rows: dict[str, dict], pool: Workers) -> None:
        """Make the missing parts, and each view as soon as its parts are there; extends `rows`."""
        if rows:
            self.say(f"unchanged: {len(rows)} parts")
        parts, total = {p.part.name: p for p in missing}, len(missing)
        for group in groups(missing):
            pool.add([(p.part.name, jobs.make, (p.part, self.store.stage, p.extra)) for p in group])
        waiting = self._start_views([view for view in views if not self._keep_view(view)], rows, pool)
        for name, result in pool.results():
            if name not in parts:
                self._shown(name, result, views)
                continue
            if isinstance(result, Exception):
                raise result
            made = parts.pop(name)
            rows[name] = manifest.entry(
                made.part, made.key, result.facts, result.step_volume_mm3, result.files)
            self.files |= result.files
            self.changed = True
            self.say(f"[{total - len(parts)}/{total}] {name}")
            waiting = self._start_views(waiting, rows, pool)

    def _keep_view(self, view: View) -> bool:
        """Keep a view by its key, as parts are."""
        row = _view_row(view)
        old = next((r for r in (self.previous or {}).get("views", []) if r == row), None)
        if old is None or not self.store.intact(digests(self.previous, [view.file])):
            return False
        self._keep([view.file])
        self.views.append(row)
        return True

    def _start_views(self, waiting: list[View], rows: dict[str, dict], pool: Workers) -> list[View]:
        """Queue the views whose parts are all made, those of the same parts together."""
        ready: dict[tuple[str, ...], list] = {}
        for view in (v for v in waiting if rows.keys() >= set(v.shows)):
            job = view.file, view.make, (self.store.stage, view.file)
            ready.setdefault(view.shows, []).append(job)
        for group in ready.values():
            pool.add(group)
        return [v for v in waiting if not rows.keys() >= set(v.shows)]

    def _shown(self, file: str, result: str | Exception, views: list[View]) -> None:
        """Enter a view; a machine that cannot draw costs the pictures only, with a warning."""
        if not isinstance(result, Exception):
            self.files[file] = result
            self.views.append(_view_row(next(view for view in views if view.file == file)))
            self.changed = True
        elif isinstance(result, EngineError) and file != pictures.ASSEMBLY:
            self.warnings = [pictures.LEFT_OUT]
            self.say(f"warning: {pictures.LEFT_OUT} ({result})")
        else:
            raise result

    def _finish(self, rows: list[dict], report: dict) -> dict[str, Any]:
        """Write manifest and checks and put the build in its place, unless nothing changed."""
        document = {
            "schema": manifest.SCHEMA,
            "name": self.loaded.hand.name,
            "handgen_version": __version__,
            "parameters_sha256": self.loaded.sha256,
            "verified": self.verify,
            "parts": rows,
            "views": sorted(self.views, key=lambda row: row["file"]),
            "adaptations": [asdict(a) for a in adaptations(self.loaded.hand)],
            "assumptions": self.loaded.assumptions,
            "notes": [jobs.BLENDED_NOTE] if any(r["name"] == jobs.HAND for r in rows) else [],
            "warnings": self.warnings,
            "files": dict(sorted(self.files.items())),
        }
        written = {MANIFEST: manifest.to_bytes(document), CHECKS: manifest.to_bytes(report)}
        if self.changed or not self.store.same(written):
            self.store.write(written)
            self.store.carry_over({*(self.previous or {}).get("files", ()), MANIFEST, CHECKS})
            self.store.commit()
        return _result(self.loaded, self.store, report, document)
