"""A YAML file that stands alone (no `extends`) -> one validated model, or every one of its errors at once."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import TypeVar

from pydantic import ValidationError

from handgen.errors import InputError
from handgen.parameters import document, explain
from handgen.parameters.fault import Fault
from handgen.parameters.quantity import Model

M = TypeVar("M", bound=Model)


def load_single(
    file: str | os.PathLike,
    model: type[M],
    schema: str,
    prepare: Callable[[dict], list[Fault]] = lambda data: [],
    relate: Callable[[M], list[Fault]] = lambda loaded: [],
) -> M:
    """Read `file` as a `model` of version `schema`.

    `prepare` may replace values of the file's data before they are validated, and says what is wrong with
    those it cannot replace; `relate` says what is wrong between fields that are right by themselves.

    Raises:
        InputError: no such file, another format or version, or every wrong field, each with its line.
    """
    return validated(document.read(os.fspath(file)), model, schema, prepare, relate)


def validated(
    here: document.Document,
    model: type[M],
    schema: str,
    prepare: Callable[[dict], list[Fault]] = lambda data: [],
    relate: Callable[[M], list[Fault]] = lambda loaded: [],
) -> M:
    """As `load_single`, from data that is read already; `prepare` changes it.

    Raises:
        InputError: every wrong field.
    """
    if here.data is not None and here.data.get("schema") != schema:
        known = "schema" in here.data
        message = "unknown format, or unknown version of it" if known else "missing (version of the format)"
        here.faults.append(Fault(("schema",), message, here.data.get("schema"), repr(schema)))
        here.data = None
    if here.data is None:
        raise InputError([here.problem(fault) for fault in here.faults])
    faults, loaded = [*here.faults, *prepare(here.data)], None
    refused = {fault.path for fault in faults}
    try:
        loaded = model.model_validate(here.data)
    except ValidationError as error:
        faults += [fault for fault in explain.faults(model, error)
                   if not any(fault.path[:i] in refused for i in range(1, len(fault.path) + 1))]
    if loaded is not None and not faults:
        faults = relate(loaded)
    if faults:
        raise InputError([here.problem(fault) for fault in sorted(faults, key=lambda f: here.line(f) or 0)])
    return loaded
