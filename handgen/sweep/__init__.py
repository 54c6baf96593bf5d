"""Hundreds of hands compared: plan, run (Dask), store, resume, optimise (Optuna), show."""

from collections.abc import Sequence

from handgen.errors import InputError, Problem
from handgen.sweep.plan import plan
from handgen.sweep.run import run
from handgen.sweep.show import show

__all__ = ["action", "plan", "run", "show"]
ACTIONS = ("plan", "run", "show")


def action(words: Sequence[str]) -> tuple[str, str]:
    """(what to do, file or folder) of a command line's words; one word alone is a sweep file to run.

    Raises:
        InputError: other words.
    """
    what, *rest = words if len(words) > 1 else ("run", *words)
    if what not in ACTIONS or len(rest) != 1:
        raise InputError([Problem("command line", "SWEEP", " ".join(words),
                                  "is no sweep to run, plan or show",
                                  "SWEEP.yaml, plan SWEEP.yaml, or show FOLDER")])
    return what, rest[0]
