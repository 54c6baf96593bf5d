"""A wide table (CSV) -> a measurements file: one row a repeat, one column a load, the rest says what was
tested.

Columns are named as the keys of `handgen.measurements/1`, nested ones with a dot or an underscore: id, part,
orientation, path, load.quantity, observable.quantity, resolution, sensor.pressure_sigma, obstacle, held_out,
fit_up_to, title, note. A column whose name is a number is a load. Rows with the same id are repeats of one
test, in the order taken; an empty field was not read; a load that no repeat of a test has is none of that
test's.
"""

from __future__ import annotations

import csv
import os
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, get_args

from handgen import atomic
from handgen.errors import InputError, Problem
from handgen.measurements.load import Measured, load_measurements
from handgen.measurements.model import SCHEMA, UNITS, Load, Observable, Test
from handgen.parameters.fault import nearest

TEXT = (
    "id",
    "part",
    "orientation",
    "path",
    "load.quantity",
    "load.unit",
    "observable.quantity",
    "observable.unit",
    "title",
    "note",
)
NUMBERS = ("resolution", "sensor.pressure_sigma", "obstacle", "fit_up_to")
CHOICES = {
    key: get_args(model.model_fields[key.split(".")[-1]].annotation)
    for model, keys in (
        (Test, ("part", "orientation", "path")),
        (Load, ("load.quantity", "load.unit")),
        (Observable, ("observable.quantity", "observable.unit")),
    )
    for key in keys
}
"""What a column with a choice may say."""
FLAGS = {"true": True, "yes": True, "1": True, "false": False, "no": False, "0": False}
COLUMNS = (*TEXT, *NUMBERS, "held_out")
NEEDED = ("id", "part", "load.quantity", "observable.quantity")
USUAL = {"orientation": "palm_down", "path": "loading"}
SEPARATORS = (",", ";", "\t")


def import_table(
    table: str | os.PathLike,
    out: str | os.PathLike,
    *,
    hand: str | os.PathLike,
    finger: str,
    name: str | None = None,
    source: str | None = None,
) -> Measured:
    """Write the tests of the CSV file `table` to the measurements file `out`, beside and renamed.

    `hand`: parameter file of the hand that was measured.

    Raises:
        InputError: everything wrong with the table, by line and column, or with the hand; nothing was
        written.
    """
    import yaml

    target = Path(out)
    tests = _tests(Path(table))
    data = {
        "schema": SCHEMA,
        "name": name or Path(table).stem,
        "hand": "",
        "finger": finger,
        "source": source or f"imported from {Path(table).name}",
        "tests": tests,
    }

    def text(hand: str) -> str:
        return yaml.safe_dump(data | {"hand": hand}, sort_keys=False, allow_unicode=True,
                              default_flow_style=None, width=110)

    with TemporaryDirectory() as folder:
        # Elsewhere: what is refused leaves nothing where it would go, not even a folder
        trial, there = Path(folder) / target.name, os.path.abspath(hand)
        trial.write_text(text(there), encoding="utf-8")
        try:
            load_measurements(trial)
        except InputError as error:
            # The table names no hand: what is wrong with it is wrong with the file that was given.
            names = {str(trial): str(table), there: str(hand)}
            raise InputError([replace(p, file=names.get(p.file, p.file)) for p in error.problems
                              if (p.file, p.path) != (str(trial), "hand")]) from None
    atomic.write(target, text(os.path.relpath(hand, target.parent or ".")))
    return load_measurements(target)


def _tests(table: Path) -> list[dict[str, Any]]:
    """The tests of a table.

    Raises:
        InputError: it cannot be read, or everything wrong with its columns and fields.
    """
    try:
        text = table.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise InputError([Problem(str(table), "", None, f"cannot be read: {error}")]) from None
    lines = [line for line in text.splitlines() if line.strip() and not line.lstrip().startswith("#")]
    if len(lines) < 2:
        raise InputError(
            [Problem(str(table), "", None, "holds no readings", "a line of names, then a line a repeat")]
        )
    separator = max(SEPARATORS, key=lines[0].count)
    rows = [[field.strip() for field in row] for row in csv.reader(lines, delimiter=separator)]
    head = [_column(name, separator) for name in rows[0]]
    problems = list(_wrong_head(str(table), rows[0], head))
    tests: dict[str, dict[str, Any]] = {}
    for number, row in enumerate(rows[1:], start=2):
        problems += _add(tests, str(table), number, head, row, separator)
    if problems:
        raise InputError(problems)
    return [_shaped(test) for test in tests.values()]


def _column(name: str, separator: str) -> str | float | None:
    """The key of a column, a load, or None for neither."""
    key = name.strip().lower().replace(" ", "_")
    for known in COLUMNS:
        if key in (known, known.replace(".", "_")):
            return known
    return _number(key, separator)


def _number(text: str, separator: str) -> float | None:
    """A number; with another separator than the comma also one with a decimal comma."""
    try:
        return float(text if separator == "," else text.replace(",", "."))
    except ValueError:
        return None


def _wrong_head(file: str, names: list[str], head: list[str | float | None]) -> Iterator[Problem]:
    for name, key in zip(names, head, strict=True):
        if key is None:
            yield Problem(
                file,
                "line 1",
                name,
                "is no column of a measurements table",
                "a load, or one of " + ", ".join(COLUMNS),
                nearest(name, COLUMNS),
            )
    for key in NEEDED:
        if key not in head:
            yield Problem(file, "line 1", None, f"has no column {key}", ", ".join(NEEDED) + " are needed")
    if not any(isinstance(key, float) for key in head):
        yield Problem(file, "line 1", None, "has no load", "a column a load, named by its number")


def _add(
    tests: dict[str, dict[str, Any]],
    file: str,
    number: int,
    head: list[str | float | None],
    row: list[str],
    separator: str,
) -> Iterator[Problem]:
    """Add one repeat to its test."""
    if len(row) != len(head):
        yield Problem(
            file, f"line {number}", len(row), "has another number of fields than the head", str(len(head))
        )
        return
    about: dict[str, Any] = {}
    readings: list[tuple[float, float | None]] = []
    for key, field in zip(head, row, strict=True):
        where = f"line {number}, column {key}"
        if key is None or (field == "" and not isinstance(key, float)):
            continue
        if key in TEXT:
            about[key] = field
            if key in CHOICES and field not in CHOICES[key]:
                yield Problem(
                    file,
                    where,
                    field,
                    "is none of the known choices",
                    ", ".join(CHOICES[key]),
                    nearest(field, CHOICES[key]),
                )
        elif key == "held_out":
            if field.lower() not in FLAGS:
                yield Problem(file, where, field, "is neither true nor false", "true or false")
            about[key] = FLAGS.get(field.lower(), False)
        elif (value := _number(field, separator)) is None and field:
            yield Problem(file, where, field, "is no number", "a number, or nothing where none was read")
        elif isinstance(key, float):
            readings.append((key, value))
        else:
            about[key] = value
    test = tests.setdefault(about.get("id", ""), {**about, "rows": []})
    for key, value in about.items():
        if test.setdefault(key, value) != value:
            yield Problem(
                file,
                f"line {number}, column {key}",
                value,
                "differs from an earlier repeat of this test",
                repr(test[key]),
            )
    test["rows"].append(readings)


def _shaped(test: dict[str, Any]) -> dict[str, Any]:
    """A test as the measurements file has it."""
    rows = test["rows"]
    kept = [i for i in range(len(rows[0])) if any(row[i][1] is not None for row in rows)]
    path = test.get("path", USUAL["path"])
    if path in ("loading", "unloading"):
        kept.sort(key=lambda i: rows[0][i][0], reverse=path == "unloading")
    quantities = {part: test.get(f"{part}.quantity", "") for part in ("load", "observable")}
    found: dict[str, Any] = {
        "id": test.get("id", ""),
        "part": test.get("part", ""),
        **{key: test.get(key, usual) for key, usual in USUAL.items()},
        **{
            part: {"quantity": quantity, "unit": test.get(f"{part}.unit", UNITS.get(quantity, ""))}
            for part, quantity in quantities.items()
        },
        "repeats": [[row[i][1] for i in kept] for row in rows],
    }
    found["load"]["values"] = [rows[0][i][0] for i in kept]
    found |= {
        key: test[key]
        for key in ("resolution", "obstacle", "fit_up_to", "held_out", "title", "note")
        if key in test
    }
    if "sensor.pressure_sigma" in test:
        found["sensor"] = {"pressure_sigma": test["sensor.pressure_sigma"]}
    return found
