"""The library of materials and parameter sets (library.yaml): validated on loading, looked up by name."""

from __future__ import annotations

import difflib
import os
from collections.abc import Iterable, Mapping
from functools import cache
from pathlib import Path

from pydantic import ValidationError

from handgen.errors import InputError, Problem
from handgen.materials import stability
from handgen.materials.sets import Library, Material, ParameterSet

FILE = Path(__file__).with_name("library.yaml")


def load(file: str | os.PathLike = FILE) -> Library:
    """Read and validate a library.

    Raises:
        InputError: every problem of the file at once; relations are checked once the fields are right.
    """
    import yaml

    try:
        data = yaml.safe_load(Path(file).read_text(encoding="utf-8"))
        library = Library.model_validate(data)
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        raise InputError([Problem(str(file), "", None, f"cannot be read: {error}")]) from None
    except ValidationError as error:
        raise InputError(
            [
                Problem(str(file), ".".join(map(str, e["loc"])), _short(e["input"]), e["msg"])
                for e in error.errors(include_url=False)
            ]
        ) from None
    if problems := [*_unrelated(library, str(file)), *_unexplained(library, str(file))]:
        raise InputError(problems)
    return library


@cache
def library() -> Library:
    """The library that comes with handgen."""
    return load()


def material(name: str, *, file: str = "library.yaml", path: str = "materials") -> Material:
    """The substance `name`, as parameter files call it ("Ecoflex 00-50").

    Raises:
        InputError: no such material, with the nearest name; `file` and `path` say where it was asked for.
    """
    return _lookup(library().materials, name, "material", file, path)


def parameter_set(name: str, *, file: str = "library.yaml", path: str = "sets") -> ParameterSet:
    """The parameter set `name`, stable or not.

    Raises:
        InputError: no such set, with the nearest name.
    """
    return _lookup(library().sets, name, "parameter set", file, path)


def usable(name: str, strain: float, *, file: str = "library.yaml", path: str = "sets") -> ParameterSet:
    """The parameter set `name`, after making sure that its law is stable up to nominal strain `strain`.

    Raises:
        InputError: no such set, or an unstable law (see `refuse_unstable`).
    """
    found = parameter_set(name, file=file, path=path)
    refuse_unstable(found, strain, name=name, file=file, path=path)
    return found


def refuse_unstable(found: ParameterSet, strain: float, *, name: str, file: str, path: str) -> None:
    """Refuse a set, of the library or a user's own, whose law is no possible material up to `strain`.

    Raises:
        InputError: with state and strain of the first failures, and the library's stable sets of the
            same material.
    """
    reason = stability.reason(found.build(), strain)
    if reason is None:
        return
    others = [
        key
        for key, other in library().sets.items()
        if other.material == found.material and not stability.failures(other.build(), strain)
    ]
    allowed = f"a law stable up to {100 * strain:.3g} % strain"
    if others:
        allowed += f"; of {found.material}: {', '.join(others)}"
    raise InputError([Problem(file, path, name, reason, allowed)])


def density(found: ParameterSet) -> float:
    """Density to use with a set, tonne/mm3: the weighed one where it has one, else the material's."""
    own = found.density if found.density is not None else material(found.material).density
    return own * 1e-12


def _unrelated(found: Library, file: str) -> Iterable[Problem]:
    """Names that nothing answers to."""
    for name, one in found.sets.items():
        for key, names in (("material", found.materials), ("source", found.sources),
                           ("tuned_from", found.sets)):
            word = getattr(one, key)
            if word is not None and word not in names:
                yield Problem(
                    file, f"sets.{name}.{key}", word, f"names no {key}", suggestion=_nearest(word, names)
                )


def _unexplained(found: Library, file: str) -> Iterable[Problem]:
    """Differences between a table and what is used that no correction explains."""
    for name, one in found.sets.items():
        used = {"unit": one.unit, **one.symbols}
        explained = {(c.what, c.printed, c.used) for c in one.corrections}
        for printed in one.printed:
            for what, value in {"unit": printed.unit, **printed.constants}.items():
                if what not in used:
                    yield Problem(file, f"sets.{name}.printed", what, "is no constant of this law")
                elif value != used[what] and (what, value, used[what]) not in explained:
                    message = f"Table {printed.table} prints another {what} and no correction says why"
                    yield Problem(file, f"sets.{name}.corrections", value, message, f"used is {used[what]!r}")


def _lookup(names: Mapping, name: str, kind: str, file: str, path: str):
    if name in names:
        return names[name]
    message = f"there is no {kind} of this name"
    raise InputError([Problem(file, path, name, message, ", ".join(names), _nearest(name, names))])


def _nearest(word: str, valid: Iterable[str]) -> str | None:
    by_lower = {name.lower(): name for name in valid}
    found = difflib.get_close_matches(str(word)[:64].lower(), by_lower, n=1, cutoff=0.5)
    return by_lower[found[0]] if found else None


def _short(value: object) -> object:
    text = str(value)
    return text[:117] + "..." if isinstance(value, (dict, list, str)) and len(text) > 120 else value
