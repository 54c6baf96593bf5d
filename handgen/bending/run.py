"""A request solved: by its solver, or from what an earlier run kept."""

from __future__ import annotations

import os
from collections.abc import Callable

from handgen.bending import cache, solvers
from handgen.bending.applied import read
from handgen.bending.files import target, write
from handgen.bending.request import Request, request
from handgen.bending.result import Bend, judged
from handgen.errors import EngineError, HandgenError
from handgen.parameters.load import Loaded

Progress = Callable[[str], None]


def bend(params: str | os.PathLike | Loaded, *, out: str | os.PathLike | None = None, keep: bool = True,
         progress: Progress | None = None, **arguments) -> Bend:
    """Bend a finger of the parameter file `params`; `arguments` are those of `request`.

    With `out`, results are written to `<out>/bend/<finger>_<part>/` (see `files.write`); else nothing is.
    `keep=False` neither reads nor writes the cache. `progress` is told one line per point.

    Returns a `Bend`: `.document` is the contract's JSON, `.curve` has the arrays. It may be incomplete
    (`.complete`, `.reached`): a solver that could go no further is no error here.

    Raises:
        InputError: everything wrong with hand, model and arguments at once; nothing was solved.
        EngineError: the solver cannot be loaded or failed.
    """
    asked = request(params, **arguments)
    if out is not None:
        target(asked, out)
    found = solve(asked, keep=keep, progress=progress)
    if out is not None:
        write(found, out, progress)
    return found


def solve(asked: Request, *, keep: bool = True, progress: Progress | None = None) -> Bend:
    """The bend that `asked` describes.

    Raises:
        EngineError: the solver cannot be loaded or failed.
    """
    say = progress or (lambda line: None)
    solver = solvers.solver(asked.solver)
    key = cache.key(asked.case, solver)
    if keep and (curve := cache.read(key)) is not None:
        say("as solved before")
        return Bend(asked, read(curve, asked.case, asked.effects, asked.gauge), True)
    try:
        curve = solver.simulate(asked.case, progress)
    except (HandgenError, KeyboardInterrupt, MemoryError):
        raise
    except Exception as error:
        raise EngineError(f"the solver {asked.solver!r} failed: {type(error).__name__}: {error}") from error
    curve = judged(asked, curve)
    if keep:
        cache.write(key, curve)
    return Bend(asked, read(curve, asked.case, asked.effects, asked.gauge), False)
