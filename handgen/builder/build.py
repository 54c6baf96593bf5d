"""The build: load, mesh, judge, make what is new, keep what is not, exchange the folder."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from dataclasses import asdict
from pathlib import Path
from typing import Any

from handgen import __version__, checks
from handgen.builder import jobs, pictures, spotted
from handgen.builder.pictures import View
from handgen.builder.plan import Planned, digests, groups, kept, plan
from handgen.builder.pool import Workers, default_count
from handgen.builder.store import CHECK_FOLDER, CHECKS, MANIFEST, Store
from handgen.builder.verdict import Verdict, judged_key, publish
from handgen.errors import EngineError
from handgen.export import manifest
from handgen.geometry.actuator import adaptations, refuse_forbidden
from handgen.geometry.catalogue import catalogue, select
from handgen.parameters.load import Loaded, load

Progress = Callable[[str], None]
FINDINGS = "previews/findings"
"""Of a build's pictures of what the rules found."""


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

    Returns {"name", "out", "manifest", "checks", "passed"}: `manifest` as written, empty when a
    broken rule kept everything printable from being written; `checks` the contract's report, which
    then lies in the folder `checks` of `out`.

    Raises:
        InputError: bad parameters, an unknown part, a folder that is not handgen's, or (with
            `verify=False`) layers that leave no core and may not be thinned.
        GeometryError: a part cannot be made; the earlier build is left as it was.
        EngineError: a kernel or a worker gave up; the earlier build is left as it was.
    """
    loaded = load(params)
    listed = catalogue(loaded.hand)
    wanted = set(select(listed, parts or None))
    checks.own_limits(loaded.hand, str(loaded.file))
    if not verify:
        refuse_forbidden(loaded.hand, str(loaded.file))
    store = Store(Path(out) if out is not None else Path("outputs") / loaded.hand.name)
    say = progress or (lambda line: None)
    with store.locked(lambda: say(f"waiting for another build of {store.final}")) as lock:
        return _Build(loaded, store, say, verify).run(
            plan(loaded.hand, listed.values()), wanted, workers or default_count(), lock)


def _result(loaded: Loaded, store: Store, report: dict, written: dict) -> dict[str, Any]:
    return {"name": loaded.hand.name, "out": str(store.final), "manifest": written,
            "checks": report, "passed": report["passed"]}


def _view_row(view: View) -> dict[str, Any]:
    return {"file": view.file, "shows": list(view.shows), "key": view.key}


def _sound(result: Any) -> Any:
    """A job's result, or its error raised."""
    if isinstance(result, Exception):
        raise result
    return result


class _Build:
    """One run under the folder's lock."""

    def __init__(self, loaded: Loaded, store: Store, say: Progress, verify: bool):
        self.loaded, self.store, self.say, self.verify = loaded, store, say, verify
        self.previous = store.manifest()
        self.present: list[Planned] = []
        self.files: dict[str, str] = {}
        self.views: list[dict[str, Any]] = []
        self.warnings: list[str] = []
        self.changed = False

    def run(self, planned: list[Planned], wanted: set[str], workers: int, lock: int) -> dict[str, Any]:
        rows = kept(planned, self.store, self.previous)
        missing = [p for p in planned if p.part.name in wanted and p.part.name not in rows]
        self.present = present = [p for p in planned if p.part.name in rows or p in missing]
        verdict = Verdict(self.loaded, [p.part.name for p in present], self.store.stage)
        try:
            for row in rows.values():
                self._keep(row["files"].values())
            with Workers(workers, lock) as pool:
                pool.warm(len(missing))
                meshed = self._mesh(missing, rows, pool)
                report = self._known_report(present)
                if report is None:
                    verdict.start(pool)
                views = pictures.views(self.loaded.hand, self.loaded.sha256, present)
                views += spotted.views(report, present, FINDINGS) if report else []
                report = self._make(missing, meshed, views, rows, pool, verdict, report)
            if self.verify and not report["passed"]:
                with Workers(workers, lock, ("manifold3d",)) as pool:
                    return self._failed(report, pool)
            key = judged_key(self.loaded, present)
            return self._finish([rows[p.part.name] for p in present], report, key)
        finally:
            self.store.discard()

    def _known_report(self, present: list[Planned]) -> dict[str, Any] | None:
        """The report of the previous build, where the same rules judged the same parts."""
        if self.previous is None or self.previous.get("checks_key") != judged_key(self.loaded, present):
            return None
        return self.store.report()

    def _mesh(self, missing: list[Planned], rows: dict[str, dict], pool: Workers) -> dict[str, jobs.Meshed]:
        """The missing parts' meshes, in the staging folder."""
        if rows:
            self.say(f"unchanged: {len(rows)} parts")
        for group in groups(missing):
            pool.add([(p.part.name, jobs.mesh, (p.part, self.store.stage, p.extra)) for p in group])
        return {name: _sound(result) for name, result in pool.results()}

    def _keep(self, paths: Iterable[str]) -> None:
        """Files of the previous build that stay as they are."""
        files = digests(self.previous, paths)
        self.store.reuse(files)
        self.files |= files

    def _make(self, missing: list[Planned], meshed: dict[str, jobs.Meshed], views: list[View],
              rows: dict[str, dict], pool: Workers, verdict: Verdict, report: dict | None) -> dict[str, Any]:
        """Make the rest of the missing parts and the views while the rules run; extends `rows` and `views`.

        Returns the report, at once if a rule keeps everything from being written.
        """
        parts, total = {p.part.name: p for p in missing}, len(missing)
        for group in groups(missing):
            pool.add([(p.part.name, jobs.solid, (p.part, self.store.stage, meshed[p.part.name]))
                      for p in group])
        waiting = self._start_views(self._new(views), rows, pool)
        for name, result in pool.results():
            if verdict.take(name, result):
                report = verdict.report
                if self.verify and report and not report["passed"]:
                    return report
                if report:
                    found = spotted.views(report, self.present, FINDINGS)
                    views += found
                    waiting = self._start_views(waiting + self._new(found), rows, pool)
            elif name in parts:
                made = parts.pop(name)
                rows[name] = self._row(made, meshed[name], _sound(result))
                self.say(f"[{total - len(parts)}/{total}] {name}")
                waiting = self._start_views(waiting, rows, pool)
            else:
                self._shown(name, result, views)
        return report

    def _row(self, made: Planned, meshed: jobs.Meshed, solid: jobs.Solid) -> dict[str, Any]:
        files = dict(sorted((meshed.files | solid.files).items()))
        self.files |= files
        self.changed = True
        return manifest.entry(made.part, made.key, meshed.facts, solid.volume_mm3, files)

    def _failed(self, report: dict[str, Any], pool: Workers) -> dict[str, Any]:
        """Nothing printable, but what is wrong and where, beside where the user looks for the build."""
        drawn, warning = spotted.draw(report, self.present, self.store.stage, pool)
        if warning:
            self.say(f"warning: {warning}")
        publish(report, drawn, self.store.final / CHECK_FOLDER)
        return _result(self.loaded, self.store, report, {})

    def _new(self, views: list[View]) -> list[View]:
        """Those of `views` that must be drawn; the others are kept."""
        return [view for view in views if not self._keep_view(view)]

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

    def _finish(self, rows: list[dict], report: dict, judged: str) -> dict[str, Any]:
        """Write manifest and checks and put the build in its place, unless nothing changed."""
        document = {
            "schema": manifest.SCHEMA,
            "name": self.loaded.hand.name,
            "handgen_version": __version__,
            "parameters_sha256": self.loaded.sha256,
            "verified": self.verify,
            "checks_key": judged,
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
            self.store.carry_over({*(self.previous or {}).get("files", ()), MANIFEST, CHECKS,
                                    CHECK_FOLDER, f".{CHECK_FOLDER}.lock"})
            self.store.commit()
        return _result(self.loaded, self.store, report, document)
