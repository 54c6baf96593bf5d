"""One YAML file -> plain data and the line of every key; hostile files are refused, not parsed.

The file is read event by event without recursion and without building objects: no tags, no
anchors, no duplicate keys, bounded size and depth. Scalars follow YAML 1.2's core schema (`on`
and `no` are texts, `010` is ten, `1e-3` is a number).
"""

from __future__ import annotations

import json
import math
import os
import re
from dataclasses import dataclass, field
from pathlib import Path as FilePath

import yaml

from handgen.errors import Problem
from handgen.parameters.fault import Fault, Path, nearest, text

MAXIMUM_SIZE = 1_000_000
"""Bytes; adult.yaml has 6 thousand."""
MAXIMUM_DEPTH = 20
"""Levels of nesting; a hand has 6."""

LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
WORDS = {
    "": None,
    "~": None,
    "null": None,
    "Null": None,
    "NULL": None,
    "true": True,
    "True": True,
    "TRUE": True,
    "false": False,
    "False": False,
    "FALSE": False,
}
INTEGER = re.compile(r"[-+]?[0-9]{1,15}")
NUMBER = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?")
SPECIAL = re.compile(r"([-+]?)\.(inf|Inf|INF)|\.(nan|NaN|NAN)")
PLAIN_TAGS = {None, "!", "tag:yaml.org,2002:str", "tag:yaml.org,2002:map", "tag:yaml.org,2002:seq"}


@dataclass
class Document:
    """A file's data, the line of every key path in it, and what is wrong with its form.

    `data` is None when the file could not be read as a mapping at all.
    """

    file: str
    data: dict | None = None
    lines: dict[Path, int] = field(default_factory=dict)
    faults: list[Fault] = field(default_factory=list)

    def line(self, fault: Fault) -> int | None:
        """Line of `fault`, or of the longest part of its path that the file has; None: the whole file."""
        path = fault.path
        known = (self.lines[path[:i]] for i in range(len(path), 0, -1) if path[:i] in self.lines)
        return fault.line or next(known, None)

    def problem(self, fault: Fault) -> Problem:
        """`fault` as it is reported, with its file and line."""
        line = self.line(fault)
        message = f"line {line}: {fault.message}" if line else fault.message
        return Problem(
            self.file, text(fault.path), _short(fault.value), message, fault.allowed, fault.suggestion
        )


def read(file: str) -> Document:
    """Read one file; never raises for what the file contains or for a file that is not there."""
    document = Document(file)
    try:
        content = _bytes(file)
        if not content.strip():
            raise _RefusedError("the file is empty", allowed="a mapping that begins with `schema:`")
        _Builder(document).build(content.decode("utf-8-sig"))
        if not isinstance(document.data, dict):
            document.data = None
            raise _RefusedError("the top level is no mapping", allowed="`key: value` lines")
    except _RefusedError as refused:
        document.data = None
        document.faults.append(refused.fault)
    except UnicodeDecodeError as error:
        document.faults.append(Fault((), f"is not UTF-8 text: byte {error.start} cannot be read"))
    except yaml.YAMLError as error:
        document.data = None
        document.faults.append(_syntax(error))
    return document


class _RefusedError(Exception):
    def __init__(self, message: str, **more):
        self.fault = Fault((), message, **more)


def _bytes(file: str) -> bytes:
    """The file's content, after everything that can be wrong with it as a file."""
    path = FilePath(file)
    try:
        if path.is_dir():
            raise _RefusedError("is a directory", suggestion=_neighbour(path, path / "x.yaml"))
        if not path.exists():
            raise _RefusedError("there is no such file", suggestion=_neighbour(path.parent, path))
        if not path.is_file():
            raise _RefusedError("is no regular file")
        with path.open("rb") as stream:
            content = stream.read(MAXIMUM_SIZE + 1)
    except (OSError, ValueError) as error:
        raise _RefusedError(f"cannot be read: {getattr(error, 'strerror', None) or error}") from None
    if len(content) > MAXIMUM_SIZE:
        raise _RefusedError(
            f"is larger than {MAXIMUM_SIZE // 1000} kB",
            value=os.path.getsize(file),
            allowed=f"at most {MAXIMUM_SIZE} bytes",
        )
    return content


def _short(value: object) -> object:
    """A value as it can stand in a message and in strict JSON."""
    if isinstance(value, float) and not math.isfinite(value):
        return str(value)
    if isinstance(value, (dict, list)):
        value = json.dumps(value, default=str)
    if isinstance(value, str) and len(value) > 120:
        return value[:117] + "..."
    return value


def _neighbour(folder: FilePath, wanted: FilePath) -> str | None:
    """The YAML file near `folder` whose name is most like the wanted one's."""
    if not folder.is_dir():
        return None
    files = {p.name: p for p in sorted(folder.iterdir()) if p.suffix in (".yaml", ".yml")}
    name = nearest(wanted.name, files) or nearest(wanted.name + ".yaml", files)
    return str(files[name]) if name else None


def _syntax(error: Exception) -> Fault:
    mark = getattr(error, "problem_mark", None)
    what = getattr(error, "problem", None) or getattr(error, "reason", None) or str(error).split("\n")[0]
    return Fault((), f"is not valid YAML: {what}", line=mark.line + 1 if mark else None)


class _Builder:
    """Builds plain data from events with an explicit stack: depth costs no recursion."""

    def __init__(self, document: Document):
        self.document = document
        self.stack: list[tuple[Path, dict | list]] = []
        self.key: str | None = None
        """Key of the innermost mapping that still waits for its value."""
        self.keys: list[str | None] = []

    def build(self, text: str) -> None:
        documents = 0
        for event in yaml.parse(text, Loader=LOADER):
            if isinstance(event, yaml.DocumentStartEvent):
                documents += 1
                if documents > 1:
                    raise _RefusedError("holds more than one YAML document (`---`)", allowed="one document")
            elif isinstance(event, yaml.AliasEvent):
                self.refuse_as_key(event)
                path = self.place(event, None)
                self.fault(path, f"alias *{event.anchor}: anchors and aliases are not allowed", event)
            elif isinstance(event, yaml.ScalarEvent):
                self.scalar(event)
            elif isinstance(event, yaml.CollectionStartEvent):
                self.open(event)
            elif isinstance(event, yaml.CollectionEndEvent):
                self.stack.pop()
                self.key = self.keys.pop()

    def at_key(self) -> bool:
        return bool(self.stack) and isinstance(self.stack[-1][1], dict) and self.key is None

    def refuse_as_key(self, event: yaml.Event) -> None:
        if self.at_key():
            raise _RefusedError("a key must be a plain word", line=event.start_mark.line + 1)

    def fault(self, path: Path, message: str, event: yaml.Event, **more) -> None:
        self.document.faults.append(Fault(path, message, line=event.start_mark.line + 1, **more))

    def scalar(self, event: yaml.ScalarEvent) -> None:
        if self.at_key():
            self.key = event.value
            path = self.path()
            self.decorations(path, event)
            if self.key in self.stack[-1][1]:
                self.fault(path, "this key stands here twice", event)
            self.document.lines[path] = event.start_mark.line + 1
            return
        path = self.place(event, value := resolve(event))
        self.decorations(path, event, value)

    def open(self, event: yaml.CollectionStartEvent) -> None:
        if len(self.stack) >= MAXIMUM_DEPTH:
            raise _RefusedError(
                "is nested too deeply",
                allowed=f"at most {MAXIMUM_DEPTH} levels",
                line=event.start_mark.line + 1,
            )
        self.refuse_as_key(event)
        collection: dict | list = {} if isinstance(event, yaml.MappingStartEvent) else []
        path = self.place(event, collection)
        self.decorations(path, event)
        self.keys.append(self.key)
        self.stack.append((path, collection))
        self.key = None

    def decorations(self, path: Path, event: yaml.NodeEvent, value: object = None) -> None:
        if event.anchor:
            self.fault(
                path, f"anchor &{event.anchor}: anchors and aliases are not allowed", event, value=value
            )
        if event.tag not in PLAIN_TAGS:
            self.fault(path, f"tag {event.tag}: YAML tags are not allowed", event, value=value)

    def path(self) -> Path:
        return (*self.stack[-1][0], self.key)

    def place(self, event: yaml.Event, value: object) -> Path:
        """Put `value` where the next node belongs; returns its path."""
        if not self.stack:
            path: Path = ()
            self.document.data = value
        else:
            parent, holder = self.stack[-1]
            if isinstance(holder, list):
                path = (*parent, len(holder))
                holder.append(value)
            else:
                path = self.path()
                holder[self.key] = value
                self.key = None
        self.document.lines.setdefault(path, event.start_mark.line + 1)
        return path


def resolve(event: yaml.ScalarEvent) -> object:
    """A scalar's value by the core schema: null, boolean, number or text."""
    text = event.value
    if not event.implicit[0]:
        return text
    if text in WORDS:
        return WORDS[text]
    if INTEGER.fullmatch(text):
        return int(text)
    if NUMBER.fullmatch(text):
        return float(text)
    if special := SPECIAL.fullmatch(text):
        return float("nan") if special[3] else float(f"{special[1]}inf")
    return text
