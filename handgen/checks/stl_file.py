"""Any STL file, binary or text, as triangles; what cannot be one is refused by name."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from handgen.errors import InputError, Problem
from handgen.geometry.measure import HEADER, TRIANGLE, read_stl

SOLID, FACET, END = (re.compile(rf"^\s*{word}\b".encode(), re.IGNORECASE | re.MULTILINE)
                     for word in ("solid", "facet", "endsolid"))
VERTEX = re.compile(rb"^\s*vertex\s+(\S+)\s+(\S+)\s+(\S+)\s*$", re.IGNORECASE | re.MULTILINE)
ALLOWED = "an STL file, binary or text, in mm"
START = 512
"""Bytes at the start of a file that tell text from a binary header that says `solid` too."""


def read(path: Path) -> tuple[str, np.ndarray]:
    """("binary" or "text", corners (n, 3, 3) in float64) of the triangles in the STL at `path`.

    Raises:
        InputError: no such file, no STL, cut off, no triangles, or a coordinate that is no number.
    """
    if not path.is_file():
        raise _refused(path, "is no file" if path.exists() else "there is no such file")
    content = path.read_bytes()
    try:
        kind, corners = _triangles(content)
    except ValueError as error:
        raise _refused(path, str(error)) from None
    if not len(corners):
        raise _refused(path, "holds no triangles")
    # What single precision cannot hold, no binary STL could say.
    odd = ~(np.abs(corners) <= np.finfo(np.float32).max).all(axis=(1, 2))
    if odd.any():
        raise _refused(path, f"{odd.sum()} of {len(odd)} triangles have a coordinate that is no finite"
                             f" number, the first is triangle {odd.argmax() + 1}")
    # A zero with a sign equals one without; written like this they are the same bytes too.
    return kind, corners.astype(float) + 0.0


def _triangles(content: bytes) -> tuple[str, np.ndarray]:
    """(kind, corners).

    Raises:
        ValueError: the content is no STL, in words.
    """
    try:
        return "binary", read_stl(content)
    except ValueError:
        pass
    if not content:
        raise ValueError("is empty")
    if SOLID.match(content.removeprefix(b"\xef\xbb\xbf")) and b"\0" not in content[:START]:
        return "text", _text(content)
    if len(content) < HEADER + 4:
        raise ValueError(f"is no STL: {len(content)} bytes, and no text that begins with `solid`")
    count = int.from_bytes(content[HEADER:HEADER + 4], "little")
    whole = HEADER + 4 + count * TRIANGLE.itemsize
    raise ValueError(f"is no whole STL: its header promises {count} triangles, {whole} bytes, and it has"
                     f" {len(content)}")


def _text(content: bytes) -> np.ndarray:
    vertices, facets = VERTEX.findall(content), len(FACET.findall(content))
    if len(END.findall(content)) < 1 or len(vertices) != 3 * facets:
        raise ValueError(f"is no whole STL: {facets} facets, {len(vertices)} vertices and"
                         f" {'an' if END.search(content) else 'no'} `endsolid`")
    try:
        return np.array(vertices, dtype=bytes).astype(float).reshape(-1, 3, 3)
    except ValueError as error:
        raise ValueError(f"has a vertex that is no number: {error}") from None


def _refused(path: Path, message: str) -> InputError:
    return InputError([Problem(str(path), "", None, message, ALLOWED)])
