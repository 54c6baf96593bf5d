"""Curves that were solved before, by the hash of everything that determines them.

One file a curve, written beside and renamed: a killed run leaves a stray temporary file at worst. A file that
cannot be read is as good as none. The folder may be deleted at any time.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import sys
import tempfile
from collections.abc import Mapping
from dataclasses import asdict, fields, is_dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import BaseModel

from handgen.bending.solvers import Solver
from handgen.simulation.case import Case, Curve, Grid, State

FORMAT = 1
"""Of the files; another one is another key."""
LARGEST = 1_000_000_000
"""Bytes; beyond, curves that were not used for longest go."""
ARRAYS = ("positions", "stretch")
"""Fields of a State that hold one array a body."""


def folder() -> Path:
    """`HANDGEN_CACHE`, or the user's cache folder by the system's convention."""
    if given := os.environ.get("HANDGEN_CACHE"):
        return Path(given)
    if sys.platform == "darwin":
        base = Path.home() / "Library" / "Caches"
    elif os.name == "nt":
        base = Path(os.environ.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local")
    else:
        base = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    return base / "handgen"


def key(case: Case, solver: Solver) -> str:
    """sha256 of the case with every number of it, and of the solver with its version."""
    content = json.dumps([FORMAT, solver.name, solver.version, canonical(case)], sort_keys=True)
    return hashlib.sha256(content.encode()).hexdigest()


def canonical(value: Any) -> Any:
    """`value` as plain JSON data that differs wherever two values differ."""
    if is_dataclass(value):
        content = {f.name: canonical(getattr(value, f.name)) for f in fields(value)}
        return {"": type(value).__name__, **content}
    if isinstance(value, BaseModel):
        return {"": type(value).__name__, **value.model_dump(mode="json")}
    if isinstance(value, Mapping):
        return {str(k): canonical(v) for k, v in value.items()}
    if isinstance(value, (list, tuple)):
        return [canonical(v) for v in value]
    if value is None or isinstance(value, (bool, int, float, str)):
        return value
    raise TypeError(f"a case holds plain data, no {type(value).__name__}")


def read(which: str) -> Curve | None:
    """The curve of this key; None where there is none that is whole."""
    path = _path(which)
    try:
        with np.load(path, allow_pickle=False) as stored:
            arrays = {name: stored[name] for name in stored.files}
        curve = _unpacked(arrays, which)
        os.utime(path)
    except Exception:
        # A damaged archive raises whatever its damage happens to hit; it is solved anew.
        return None
    return curve


def write(which: str, curve: Curve) -> None:
    """Keep `curve`; a disk that is full or not writable costs only the time to solve it again."""
    with contextlib.suppress(OSError):
        home = _path(which).parent
        home.mkdir(parents=True, exist_ok=True)
        make_room(home, LARGEST)
        handle, name = tempfile.mkstemp(prefix=f"{which}.", suffix=".writing", dir=home)
        try:
            with os.fdopen(handle, "wb") as file:
                np.savez_compressed(file, **_packed(which, curve))
                file.flush()
                os.fsync(file.fileno())
            os.replace(name, _path(which))
        finally:
            with contextlib.suppress(FileNotFoundError):
                os.unlink(name)


def _path(which: str) -> Path:
    return folder() / "bend" / f"{which}.npz"


def make_room(home: Path, largest: int) -> None:
    """Delete what was used longest ago until the folder has no more than `largest` bytes; killed runs' files
    among it."""
    found = []
    for entry in home.iterdir():
        with contextlib.suppress(FileNotFoundError):
            status = entry.stat()
            found.append((status.st_mtime, status.st_size, entry))
    total = sum(size for _, size, _ in found)
    for _, size, entry in sorted(found, key=lambda one: one[0]):
        if total <= largest:
            return
        with contextlib.suppress(FileNotFoundError):
            entry.unlink()
        total -= size


def _packed(which: str, curve: Curve) -> dict[str, np.ndarray]:
    arrays: dict[str, np.ndarray] = {}
    for body, grid in curve.grids.items():
        arrays[f"grids/{body}/nodes"], arrays[f"grids/{body}/cells"] = grid.nodes, grid.cells
    for i, state in enumerate(curve.states):
        for name in ARRAYS:
            arrays |= {f"states/{i}/{name}/{body}": array for body, array in getattr(state, name).items()}
    plain = asdict(replace(curve, grids={}, states=tuple(
        replace(state, positions={}, stretch={}) for state in curve.states)))
    text = json.dumps({"key": which, "curve": plain})
    return arrays | {"json": np.frombuffer(text.encode(), np.uint8)}


def _unpacked(arrays: dict[str, np.ndarray], which: str) -> Curve:
    """The curve in `arrays`.

    Raises:
        ValueError, KeyError, TypeError: they hold another one, or none.
    """
    data = json.loads(arrays.pop("json").tobytes())
    if data["key"] != which:
        raise ValueError("stands under another key")
    grids: dict[str, dict] = {}
    held: list[dict[str, dict]] = [{name: {} for name in ARRAYS} for _ in data["curve"]["states"]]
    for name, array in arrays.items():
        parts = name.split("/")
        if parts[0] == "grids":
            grids.setdefault(parts[1], {})[parts[2]] = array
        else:
            held[int(parts[1])][parts[2]][parts[3]] = array
    plain = data["curve"]
    states = tuple(State(**{**state, **mine}) for state, mine in zip(plain["states"], held, strict=True))
    return Curve(**{**plain, "states": states, "folds": tuple(plain["folds"]),
                    "grids": {body: Grid(**parts) for body, parts in grids.items()}})
