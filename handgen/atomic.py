"""Files that are there whole or not at all: written beside their place, then renamed into it."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def writing(path: Path) -> Iterator[Path]:
    """A name beside `path`, in a folder that is made if need be; what is written to it takes the place of
    `path` in the end, unless an error is raised. It has the same ending."""
    path.parent.mkdir(parents=True, exist_ok=True)
    beside = path.with_name(f".{path.stem}.writing-{os.getpid()}{path.suffix}")
    try:
        yield beside
        os.replace(beside, path)
    finally:
        beside.unlink(missing_ok=True)


def write(path: Path, content: str | bytes) -> None:
    """`content` as the file `path`; text in UTF-8."""
    with writing(path) as beside:
        beside.write_bytes(content.encode() if isinstance(content, str) else content)
