"""What a build must make, and what it may keep: parts by content, not by time."""

from __future__ import annotations

import functools
import hashlib
from collections.abc import Iterable
from dataclasses import dataclass, fields, is_dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from handgen.builder.store import Store
from handgen.geometry import csg
from handgen.geometry.actuator import thread_path
from handgen.geometry.part import Part
from handgen.parameters.model import Hand

ENGINES = ("cadquery", "cadquery-ocp", "manifold3d", "matplotlib", "numpy", "pyvista", "scikit-image",
           "shapely", "trimesh", "vtk")
"""Packages whose version shapes the files."""
GLYPH = 20
"""A letter costs OCCT about as much as so many plain solids."""


@dataclass(frozen=True)
class Planned:
    """A part of the build: the key of its content, and files that need no kernel."""

    part: Part
    key: str
    extra: dict[str, bytes]


def plan(hand: Hand, listed: Iterable[Part]) -> list[Planned]:
    """Every part with its key: equal keys have equal files."""
    planned = []
    for part in listed:
        extra = {}
        if part.role == "actuator":
            extra["_thread.csv"] = _thread(hand, part.name.rsplit("/", 1)[-1])
        marks = [f"{ending}:{hashlib.sha256(data).hexdigest()}" for ending, data in extra.items()]
        planned.append(Planned(part, csg.digest((salt(), part.key, *marks)), extra))
    return planned


def kept(planned: Iterable[Planned], store: Store, previous: dict[str, Any] | None) -> dict[str, dict]:
    """Rows of the previous manifest whose key is wanted again and whose files are unchanged."""
    if previous is None:
        return {}
    rows = {row["name"]: row for row in previous["parts"]}
    return {
        p.part.name: row for p in planned
        if (row := rows.get(p.part.name)) and row["key"] == p.key
        and store.intact(digests(previous, row["files"].values()))
    }


def digests(manifest: dict[str, Any], paths: Iterable[str]) -> dict[str, str]:
    """path -> sha256 of some files of a build."""
    return {path: manifest["files"].get(path, "") for path in paths}


def groups(planned: Iterable[Planned]) -> list[list[Planned]]:
    """Parts for one worker each, longest first; the hand stays with the fingers that it holds.

    The B-rep kernel remembers solids per process, so the fingers' are made once.
    """
    planned = list(planned)
    together = sorted((p for p in planned if p.part.role == "exoskeleton"), key=_effort, reverse=True)
    single = sorted((p for p in planned if p.part.role != "exoskeleton"), key=_effort, reverse=True)
    return ([together] if together else []) + [[p] for p in single]


def _effort(planned: Planned) -> int:
    part = planned.part
    return sum(_nodes(body.shape) for body in part.bodies) or _nodes(part.shape)


def _nodes(value: object) -> int:
    if isinstance(value, tuple):
        return sum(map(_nodes, value))
    if isinstance(value, csg.Text):
        return GLYPH * len(value.text)
    if is_dataclass(value):
        return 1 + sum(_nodes(getattr(value, f.name)) for f in fields(value))
    return 0


def _thread(hand: Hand, name: str) -> bytes:
    """The thread's path as CSV: x, y, z in mm, turn."""
    rows = (f"{x:.4f},{y:.4f},{z:.4f},{turn:.4f}\n" for x, y, z, turn in thread_path(hand, name).tolist())
    return ("x,y,z,turn\n" + "".join(rows)).replace("-0.0000", "0.0000").encode()


@functools.cache
def salt(folders: tuple[str, ...] = ("geometry", "export", "builder")) -> str:
    """Hash of the code that makes files of parts, so that an upgrade rebuilds what it may change."""
    package = Path(__file__).parent.parent
    sources = sorted(f for folder in folders for f in (package / folder).iterdir() if f.is_file())
    state = hashlib.sha256()
    for source in sources:
        state.update(f"{source.relative_to(package)}\n".encode() + source.read_bytes())
    for engine in ENGINES:
        try:
            state.update(f"{engine} {version(engine)}\n".encode())
        except PackageNotFoundError:
            state.update(f"{engine} missing\n".encode())
    return state.hexdigest()
