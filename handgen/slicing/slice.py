"""`handgen slice`: every printed part through both slicers, what they say of it, and Table B.1 read back."""

from __future__ import annotations

import hashlib
import os
import tempfile
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from handgen.builder.plan import salt
from handgen.errors import EngineError, InputError, Problem
from handgen.export import stl
from handgen.geometry import csg
from handgen.geometry.actuator import refuse_forbidden
from handgen.geometry.catalogue import catalogue, select
from handgen.geometry.measure import measure_mesh
from handgen.geometry.part import Part
from handgen.parameters.load import load
from handgen.parameters.model import Hand
from handgen.slicing import engines, files, gcode, table
from handgen.slicing.printer import Printer, printer
from handgen.slicing.profile import Profile, column, profile
from handgen.slicing.standing import standing

Progress = Callable[[str], None]


@dataclass(frozen=True)
class Job:
    """One part for one slicer."""

    part: Part
    profile: Profile
    machine: Printer
    slicer: str
    asked: str
    key: str
    """Names the content: equal keys have equal G-code."""

    @property
    def gcode(self) -> str:
        """Below the output folder."""
        return f"{files.FOLDER}/{self.part.name}.{self.slicer}.gcode"


def slice_parts(
    params: str | os.PathLike,
    out: str | os.PathLike | None = None,
    slicers: Iterable[str] | None = None,
    parts: Iterable[str] | None = None,
    progress: Progress | None = None,
    workers: int | None = None,
) -> dict[str, Any]:
    """Slice the printed parts of the parameter file `params` into `out` (`outputs/<name>`).

    `slicers` and `parts` limit what is done (names or globs, see `catalogue.select`); what was sliced before
    and is still right is kept. Returns {"name", "out", "rows", "passed", "failed"}: `rows` what stands in
    slices.json of the asked parts, `passed` whether every one agrees with Table B.1, `failed` the errors of
    slicers that gave up, whose other parts are kept.

    Raises:
        InputError: bad parameters, an unknown slicer or part, or one that is cast and not printed.
        EngineError: a slicer is not installed.
    """
    loaded = load(params)
    refuse_forbidden(loaded.hand, str(loaded.file))
    asked = _slicers(slicers)
    listed = printed(loaded.hand)
    chosen = [listed[name] for name in select(listed, parts or None)]
    for absent in filter(None, map(engines.missing, asked)):
        raise EngineError(absent)
    folder = Path(out) if out is not None else Path("outputs") / loaded.hand.name
    store = files.Slices(folder)
    jobs = [_job(loaded.hand, part, slicer) for part in chosen for slicer in asked]
    say = progress or (lambda line: None)
    rows, failed = _run(jobs, store, say, workers or os.cpu_count() or 1)
    store.write(rows)
    return {"name": loaded.hand.name, "out": str(folder), "rows": rows, "failed": failed,
            "passed": all(row["agrees"] for row in rows)}


def printed(hand: Hand) -> dict[str, Part]:
    """The parts of a hand that come out of a printer, by name."""
    return {name: part for name, part in catalogue(hand).items() if column(part.role, name)}


def _slicers(asked: Iterable[str] | None) -> list[str]:
    asked = list(dict.fromkeys(asked or engines.SLICERS))
    problems = [Problem("--slicer", "", name, "no such slicer", "one of " + ", ".join(engines.SLICERS))
                for name in asked if name not in engines.SLICERS]
    if problems:
        raise InputError(problems)
    return asked


def asked_key(hand: Hand, part: Part) -> str:
    """Of what is printed and how, whichever slicer does it: known without a slicer, and without a mesh."""
    used = profile(hand.printing, column(part.role, part.name), part.role)
    return csg.digest((part.key, used.name, used.adhesion, used.support, used.filament_diameter,
                       used.process.model_dump_json(), printer(hand.printing).name,
                       *printer(hand.printing).volume))


def _job(hand: Hand, part: Part, slicer: str) -> Job:
    used, machine = profile(hand.printing, column(part.role, part.name), part.role), printer(hand.printing)
    key = csg.digest((salt(("geometry", "slicing")), part.key, slicer, engines.version(slicer),
                      engines.settings(slicer, used, machine)))
    return Job(part, used, machine, slicer, asked_key(hand, part), key)


def _run(jobs: list[Job], store: files.Slices, say: Progress, workers: int) -> tuple[list[dict], list[str]]:
    """Rows of all jobs that came through, in the jobs' order, and what the others say."""
    rows = {job.gcode: row for job in jobs if (row := store.kept(job.gcode, job.key))}
    if rows:
        say(f"unchanged: {len(rows)} of {len(jobs)}")
    missing = [job for job in jobs if job.gcode not in rows]
    failed: list[str] = []
    with tempfile.TemporaryDirectory(prefix="handgen-") as place, ThreadPoolExecutor(workers) as pool:
        meshed = _write_meshes(missing, Path(place))
        # The longest first: a file's size tells how long it takes.
        missing.sort(key=lambda job: -meshed[job.part.name][0].stat().st_size)
        running = {pool.submit(_slice, job, store, *meshed[job.part.name]): job for job in missing}
        for done in as_completed(running):
            job = running[done]
            try:
                rows[job.gcode] = row = done.result()
            except EngineError as error:
                failed.append(f"{job.part.name}: {error}")
                say(f"{job.part.name}, {job.slicer}: {error}")
                continue
            store.write([row])
            say(f"[{len(rows)}/{len(jobs)}] {job.part.name}, {job.slicer}")
    return [rows[job.gcode] for job in jobs if job.gcode in rows], failed


def _write_meshes(jobs: list[Job], folder: Path) -> dict[str, tuple[Path, float]]:
    """Part -> its STL as it stands on the printer, and its volume, mm3."""
    found: dict[str, tuple[Path, float]] = {}
    for job in jobs:
        if job.part.name not in found:
            mesh = standing(job.part.triangles, job.part.up, job.machine.volume)
            path = folder / f"{job.part.name.replace('/', '_')}.stl"
            path.write_bytes(stl.to_bytes(mesh))
            found[job.part.name] = path, measure_mesh(*mesh).volume_mm3
    return found


def _slice(job: Job, store: files.Slices, mesh: Path, mm3: float) -> dict[str, Any]:
    """Slice, read back, and put the G-code in its place."""
    with store.writing(job.gcode) as beside:
        ran = engines.run(job.slicer, job.profile, job.machine, mesh, beside)
        path = gcode.read(beside)
        rows = table.compare(job.profile, path, mm3)
        sha256 = hashlib.sha256(beside.read_bytes()).hexdigest()
    return {
        "part": job.part.name, "slicer": job.slicer, "version": engines.version(job.slicer),
        "profile": job.profile.name, "printer": job.machine.name, "gcode": job.gcode,
        "print_time_s": ran.print_time, "filament_mm": round(ran.filament, 1),
        "filament_g": round(job.profile.grams(ran.filament), 2), "layers": len(path.heights),
        "warnings": list(ran.warnings), "agrees": all(row.equal is not False for row in rows),
        "table": [row.as_dict() for row in rows], "sha256": sha256, "asked": job.asked,
        "key": job.key,
    }
