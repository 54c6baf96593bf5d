"""A parameter file -> a validated hand, or every one of its errors at once.

YAML files of an `extends` chain are merged, validated field by field (pydantic) and against each
other (relations); each error is reported in the file and line of the chain that says it.
"""

from __future__ import annotations

import hashlib
import json
import os
from dataclasses import dataclass
from pathlib import Path as FilePath
from typing import Any

from pydantic import ValidationError

from handgen.errors import InputError, Problem
from handgen.parameters import assumptions, document, explain, relations
from handgen.parameters.document import Document
from handgen.parameters.fault import Fault, Path
from handgen.parameters.model import SCHEMA, Hand

LONGEST_CHAIN = 16
"""Files in a chain of `extends`."""


@dataclass(frozen=True)
class Loaded:
    """A valid hand and where it came from."""

    hand: Hand
    file: FilePath
    sha256: str
    """Of the resolved parameters: the same parameters give the same hash in any file layout."""
    assumptions: list[dict]
    """`[{path, value, reason}]`: what the source does not give."""


def load(path: str | os.PathLike) -> Loaded:
    """Read the parameter file `path` with all that it extends.

    Raises:
        InputError: with every problem of the chain's files.
    """
    chain = _Chain()
    chain.follow(os.fspath(path))
    data = chain.merged()
    hand = chain.validated(data)
    if hand is not None:
        unmatched = assumptions.unmatched(assumptions.resolved(hand), hand.assumed)
        # A pattern that is inherited may speak of what this file removes.
        chain.report(*(f for f in unmatched if chain.home(f.path) is chain.documents[0]))
    if chain.problems:
        raise InputError(chain.ordered())
    return Loaded(hand, FilePath(path), _hash(hand), assumptions.collect(hand))


def merged(path: str | os.PathLike) -> dict:
    """What the parameter file `path` says with all that it extends, as plain data, not yet validated.

    Raises:
        InputError: a file of the chain cannot be read.
    """
    chain = _Chain()
    chain.follow(os.fspath(path))
    if chain.problems:
        raise InputError(chain.ordered())
    return chain.merged()


def loaded(data: dict, file: str | os.PathLike) -> Loaded:
    """A hand from merged `data`; `file` is named in errors.

    Raises:
        InputError: with every problem.
    """
    chain = _Chain()
    chain.documents.append(Document(os.fspath(file), data))
    hand = chain.validated(data)
    if hand is None or chain.problems:
        raise InputError(chain.ordered())
    return Loaded(hand, FilePath(file), _hash(hand), [])


def merge(base: dict, variant: dict) -> dict:
    """`variant` on top of `base`: mappings key by key; lists and values replace; null removes."""
    result = dict(base)
    for key, value in variant.items():
        if value is None and key in result:
            del result[key]
        elif isinstance(value, dict) and isinstance(result.get(key), dict):
            result[key] = merge(result[key], value)
        else:
            result[key] = value
    return result


class _Chain:
    """The files of an `extends` chain, the asked one first, and what is wrong with them."""

    def __init__(self):
        self.documents: list[Document] = []
        self.problems: list[tuple[tuple[int, int], Problem]] = []
        self.complete = True
        """False if a file of the chain could not be used: then nothing is known to be missing."""
        self.refused: set[Path] = set()
        """Paths that a file states in a form that is not allowed; their values say nothing."""

    def follow(self, file: str) -> None:
        """Read `file` and, one after the other, what it extends."""
        seen: list[str] = []
        while file:
            seen.append(os.path.realpath(file))
            here = document.read(file)
            self.documents.append(here)
            for fault in here.faults:
                self.refused.add(fault.path)
                self.add(fault, here)
            base = self.base_of(here)
            file = self.next_file(here, base, seen) if base is not None else ""

    def base_of(self, here: Document) -> object:
        """What `here` extends, None for nothing; checks its schema on the way."""
        if here.data is None:
            self.complete = False
            return None
        schema = here.data.get("schema")
        if isinstance(schema, str) and not schema.startswith(SCHEMA.split("/")[0] + "/"):
            self.add(Fault(("schema",), "this is not a parameter file of a hand", schema, repr(SCHEMA)), here)
            here.data, self.complete = None, False
            return None
        if "schema" in here.data and schema != SCHEMA:
            self.refused.add(("schema",))
            self.add(Fault(("schema",), "unknown version of the format", schema, repr(SCHEMA)), here)
        return here.data.pop("extends", None)

    def next_file(self, here: Document, base: object, seen: list[str]) -> str:
        """The path of the extended file; "" (and a problem) if it cannot be followed."""
        fault = None
        named = isinstance(base, str) and base and "\0" not in base
        file = os.path.normpath(os.path.join(os.path.dirname(here.file), base)) if named else ""
        if not named:
            fault = Fault(("extends",), "should be the name of a YAML file", base)
        elif os.path.realpath(file) in seen:
            names = [os.path.basename(f) for f in (*seen, file)]
            circle = " -> ".join(names)
            fault = Fault(("extends",), f"the files extend each other in a circle: {circle}", base)
        elif len(seen) >= LONGEST_CHAIN:
            allowed = f"at most {LONGEST_CHAIN} files"
            fault = Fault(("extends",), "the chain of files is too long", base, allowed)
        elif not os.path.isfile(file):
            wanted = document.read(file).faults[0]
            fault = Fault(("extends",), wanted.message, base, suggestion=wanted.suggestion)
        if fault is None:
            return file
        self.complete = False
        self.add(fault, here)
        return ""

    def merged(self) -> dict:
        data: dict = {}
        for here in reversed(self.documents):
            data = merge(data, here.data or {})
        return data

    def validated(self, data: dict) -> Hand | None:
        """The hand, or None; reports what fields and relations say."""
        hand, faults = None, []
        try:
            hand = Hand.model_validate(data)
        except ValidationError as error:
            faults = explain.faults(Hand, error, self.complete)
            faults += assumptions.impossible(data)
        if self.complete:
            pieces = relations.Pieces.of(hand) if hand else relations.Pieces.salvage(data)
            faults += relations.check(pieces)
        self.report(*faults)
        return hand

    def report(self, *faults: Fault) -> None:
        """Add faults of the merged data, each with the file that says it."""
        for fault in faults:
            if not any(fault.path[:i] in self.refused for i in range(1, len(fault.path) + 1)):
                self.add(fault, self.home(fault.path))

    def home(self, path: Path) -> Document:
        """The file whose word counts at `path`: the first that says it, or most of it."""
        best, best_depth = self.documents[0], -1
        for here in self.documents:
            depth, final = _reach(here.data, path)
            if depth > best_depth:
                best, best_depth = here, depth
            if final:
                break
        return best

    def add(self, fault: Fault, here: Document) -> None:
        order = self.documents.index(here), here.line(fault) or 0
        self.problems.append((order, here.problem(fault)))

    def ordered(self) -> list[Problem]:
        return [problem for _, problem in sorted(self.problems, key=lambda pair: pair[0])]


def _reach(data: Any, path: Path) -> tuple[int, bool]:
    """How many keys of `path` a file states, and whether it has the final word there.

    It has, once a list or a value stands on the way: those replace what a base says.
    """
    here, final = data, False
    for depth, key in enumerate(path):
        names = here if isinstance(here, dict) else range(len(here)) if isinstance(here, list) else ()
        if key not in names:
            return depth, final
        here = here[key]
        final = final or not isinstance(here, dict)
    return len(path), True


def _hash(hand: Hand) -> str:
    canonical = json.dumps(assumptions.resolved(hand), sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(canonical.encode()).hexdigest()
