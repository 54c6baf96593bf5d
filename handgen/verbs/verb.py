"""What a verb is, where it writes, and the exit codes of the contract."""

from __future__ import annotations

import argparse
import json
import os
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TextIO

PASSED, FAILED, BAD_INPUT, ENGINE = 0, 1, 2, 3


@dataclass(frozen=True)
class Output:
    """Where a verb writes: results, and what only people read."""

    results: TextIO
    people: TextIO
    as_json: bool = False
    quiet: bool = False

    def result(self, data: Any, table: str = "") -> None:
        """The verb's result: JSON for programs, or a table for people."""
        if self.as_json:
            print(json.dumps(data, indent=2, allow_nan=False), file=self.results)
        elif table and not self.quiet:
            print(table, file=self.people)

    def note(self, text: str) -> None:
        """Progress and remarks."""
        if not self.quiet:
            print(text, file=self.people, flush=True)

    def style(self, text: str, code: str) -> str:
        """`text` in an ANSI style, on a terminal that wants colours."""
        coloured = self.people.isatty() and "NO_COLOR" not in os.environ
        return f"\033[{code}m{text}\033[0m" if coloured else text


@dataclass(frozen=True)
class Verb:
    """One command: its help, its own arguments, and what it runs; returns the exit code."""

    help: str
    arguments: Callable[[argparse.ArgumentParser], None]
    run: Callable[[argparse.Namespace, Output], int]
