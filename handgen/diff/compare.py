"""`handgen diff A B`: load both, survey both, put them side by side."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

from handgen import __version__, atomic
from handgen.builder.survey import Survey, survey
from handgen.diff import bends, parameters, parts, rules
from handgen.errors import InputError
from handgen.parameters.load import Loaded, load

SCHEMA, FILE = "handgen.diff/1", "diff.json"
Progress = Callable[[str], None]


def diff(a: str | os.PathLike, b: str | os.PathLike, out: str | os.PathLike | None = None, *,
         quick: bool = False, solving: bool = False, progress: Progress | None = None,
         workers: int | None = None) -> dict[str, Any]:
    """What changes from the parameter file `a` to `b`; with `out` also written to `out`/diff.json.

    Meshes, reports and bends come from builds in `outputs/<name>` and from the cache where they have them;
    parts that both have are made once. Bends are solved only if `solving`. If `quick` nothing is made or
    judged either: volumes, masses, rules and findings that are not known yet are null.

    Returns {"schema", "a", "b", "same", "parameters", "adaptations", "parts", "masses", "times", "rules",
    "findings", "bends", "handgen_version"}; of `a` and `b` {"name", "file", "parameters_sha256", "passed"}.

    Raises:
        InputError: bad parameters, the problems of both files at once; or a folder that is not handgen's.
        GeometryError: a part cannot be made.
        EngineError: a kernel, a worker, a rule or the solver gave up.
    """
    both, say = _loaded(a, b), progress or (lambda line: None)
    sides = [_side(loaded, quick, say, workers) for loaded in both]
    before, after = sides
    listed = before["parts"], after["parts"], before["keys"], after["keys"]
    document = {
        "schema": SCHEMA, "a": before["head"], "b": after["head"],
        "same": both[0].sha256 == both[1].sha256,
        "parameters": parameters.parameters(both[0].hand, both[1].hand),
        "adaptations": parameters.adapted(both[0].hand, both[1].hand),
        "parts": parts.parts(*listed),
        "masses": parts.masses(*listed),
        "times": parts.timed(before["times"], after["times"]),
        **rules.judged(before["report"], after["report"]),
        "bends": bends.bends(*both, solving, say),
        "handgen_version": __version__,
    }
    if out is not None:
        atomic.write(Path(out) / FILE, json.dumps(document, indent=1, allow_nan=False) + "\n")
    return document


def _loaded(*files: str | os.PathLike) -> list[Loaded]:
    found, problems = [], []
    for file in files:
        try:
            found.append(load(file))
        except InputError as error:
            problems += [problem for problem in error.problems if problem not in problems]
    if problems:
        raise InputError(problems)
    return found


def _side(loaded: Loaded, quick: bool, say: Progress, workers: int | None) -> dict[str, Any]:
    """What of a survey outlives its meshes."""
    with survey(loaded, None, say, workers, known=quick) as surveyed:
        return {"head": _head(surveyed), "parts": parts.described(surveyed), "keys": surveyed.keys,
                "report": surveyed.report,
                "times": parts.times(surveyed, Path("outputs") / loaded.hand.name)}


def _head(surveyed: Survey) -> dict[str, Any]:
    loaded = surveyed.loaded
    return {"name": loaded.hand.name, "file": str(loaded.file), "parameters_sha256": loaded.sha256,
            "passed": surveyed.report and surveyed.report["passed"]}
