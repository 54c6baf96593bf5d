"""The table of a sweep: one row a variant, in the plan's order, as Parquet."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

from handgen import atomic
from handgen.parameters.fault import text
from handgen.sweep import results
from handgen.sweep.load import Prepared
from handgen.sweep.model import Sweep

BLOCK = 500
"""Rows in memory at once."""
META = b"handgen"
"""Key of the sweep's description in the file."""


def columns(prepared: Prepared, pressures: Sequence[float]) -> dict[str, str]:
    """Column -> "text", "number" or "integer"."""
    found = {"variant": "integer", "hash": "text", "status": "text", "reason": "text"}
    for axis in prepared.sweep.vary:
        found[axis] = "number" if numeric(prepared.sweep, axis) else "text"
    found |= dict.fromkeys(results.names(prepared.sweep, pressures), "number")
    return found | {"rules_broken": "text", "rules_warned": "text", "flags": "text", "solver": "text",
                    "unknowns": "integer", "factorisations": "integer", "wall_s": "number"}


def numeric(sweep: Sweep, axis: str) -> bool:
    """Whether all values of an axis are numbers."""
    choices = sweep.vary[axis].choices
    return choices is None or all(isinstance(c, int | float) and not isinstance(c, bool) for c in choices)


def write(path: Path, prepared: Prepared, kinds: dict[str, str], rows: Iterable[dict[str, Any]]) -> None:
    """`rows` into the Parquet file `path`, beside and renamed; memory does not grow with their number."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    types = {"text": pa.string(), "number": pa.float64(), "integer": pa.int64()}
    schema = pa.schema([(name, types[kind]) for name, kind in kinds.items()],
                       {META: json.dumps(_about(prepared)).encode()})
    with atomic.writing(path) as beside, pq.ParquetWriter(str(beside), schema, compression="zstd") as file:
        for block in _blocks(rows):
            file.write_table(pa.Table.from_pydict(
                {column: [_cell(row.get(column), kind) for row in block]
                 for column, kind in kinds.items()}, schema=schema))


def _about(prepared: Prepared) -> dict[str, Any]:
    """What a reader of the table needs to know of the sweep."""
    sweep = prepared.sweep
    return {"schema": "handgen.sweep-results/1", "name": sweep.name, "base": sweep.base,
            "solver": sweep.solver, "method": sweep.method, "axes": list(sweep.vary),
            "objectives": sweep.objectives,
            "constraints": {k: b.model_dump(exclude_none=True) for k, b in sweep.constraints.items()},
            "sets": {axis: [f"{t.scope}: {text(t.path)}" for t in ts]
                     for axis, ts in prepared.targets.items()},
            "vary": {name: axis.model_dump(exclude_none=True) for name, axis in sweep.vary.items()}}


def _blocks(rows: Iterable[dict[str, Any]]) -> Iterator[list[dict[str, Any]]]:
    block: list[dict[str, Any]] = []
    for row in rows:
        block.append(row)
        if len(block) == BLOCK:
            yield block
            block = []
    if block:
        yield block


def _cell(value: Any, kind: str) -> Any:
    if value is None:
        return None
    if kind == "number":
        return float(value)
    return value if kind == "integer" or isinstance(value, str) else json.dumps(value)


def about(path: Path) -> dict[str, Any]:
    """What a table says of its sweep."""
    import pyarrow.parquet as pq

    return json.loads(pq.read_schema(path).metadata[META])
