"""What pydantic found, in the words of a parameter file: value, allowed range, unit, nearest name."""

from __future__ import annotations

import types
import typing

from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo

from handgen.parameters.fault import Fault, Path, nearest

MANY = 200
"""Unknown keys that get a suggestion; a file with more is no parameter file."""


def faults(model: type[BaseModel], error: ValidationError, complete: bool = True) -> list[Fault]:
    """Every error of `error`, raised by validating against `model`, as a Fault.

    Of data that is not `complete` nothing is known to be missing.
    """
    found = []
    for i, detail in enumerate(error.errors(include_url=False)):
        path, kind, value = tuple(detail["loc"]), detail["type"], detail["input"]
        if kind == "missing":
            found.extend([_missing(model, path)] if complete else [])
        elif kind == "extra_forbidden":
            names = keys(field_at(model, path[:-1])[1])
            suggestion = nearest(path[-1], names) if i < MANY else None
            found.append(Fault(path, "unknown key", value, "one of " + ", ".join(names), suggestion))
        else:
            message, allowed = _words(kind, detail, field_at(model, path)[0])
            choices = detail.get("ctx", {}).get("expected", "") if kind == "literal_error" else ""
            suggestion = nearest(value, choices.replace("'", "").replace(" or ", ", ").split(", "))
            found.append(Fault(path, message, value, allowed, suggestion if choices else None))
    return found


def _missing(model: type[BaseModel], path: Path) -> Fault:
    info, _ = field_at(model, path)
    meaning = f" ({info.description})" if info and info.description else ""
    return Fault(path, f"missing{meaning}", allowed=limits(info) if info else None)


def _words(kind: str, detail: dict, info: FieldInfo | None) -> tuple[str, str | None]:
    """(message, allowed) of one pydantic error."""
    context = detail.get("ctx", {})
    allowed = limits(info) if info else None
    match kind:
        case "greater_than_equal":
            return "too small", allowed or f"at least {context['ge']:g}"
        case "less_than_equal":
            return "too large", allowed or f"at most {context['le']:g}"
        case "finite_number":
            return "is not a finite number", allowed
        case "float_type" if isinstance(detail["input"], str):
            return "is a text where a number belongs (no quotes, no unit)", allowed
        case "float_type" | "bool_type" | "string_type":
            wanted = {"float_type": "a number", "bool_type": "true or false", "string_type": "a text"}[kind]
            return f"should be {wanted}", allowed
        case "model_type" | "dict_type":
            return "should be a mapping of keys to values", allowed
        case "list_type":
            return "should be a list", allowed
        case "too_short":
            return f"has {context['actual_length']} entries", f"at least {context['min_length']} entries"
        case "too_long":
            return "has too many entries", f"at most {context['max_length']} entries"
        case "string_too_long":
            return "is too long", f"at most {context['max_length']} characters"
        case "string_pattern_mismatch":
            return _pattern(str(detail["input"])), context["pattern"]
        case "literal_error":
            return "is none of the known choices", context["expected"]
    return detail["msg"], allowed


def _pattern(text: str) -> str:
    if "/" in text or "\\" in text:
        return "has a path separator; it names a folder or part and must stay inside the output folder"
    return "has characters that do not fit a name, starts with one, or has the wrong length"


def limits(info: FieldInfo) -> str | None:
    """`2 to 40 mm`, from a field's bounds and unit; None without bounds."""
    bounds = {
        name: value
        for m in info.metadata
        for name in ("ge", "le")
        if (value := getattr(m, name, None)) is not None
    }
    if len(bounds) < 2:
        return None
    unit = (info.json_schema_extra or {}).get("unit", "")
    return f"{bounds['ge']:g} to {bounds['le']:g} {'' if unit == '1' else unit}".rstrip()


def keys(model: type[BaseModel]) -> list[str]:
    """The keys that a model knows, as files spell them."""
    return [info.alias or name for name, info in model.model_fields.items()]


def field_at(model: type[BaseModel], path: Path) -> tuple[FieldInfo | None, typing.Any]:
    """(the innermost field that holds `path`, the type of what stands there); Nones if unknown."""
    info, here = None, model
    for key in path:
        if isinstance(here, type) and issubclass(here, BaseModel):
            by_key = {f.alias or name: f for name, f in here.model_fields.items()}
            if key not in by_key:
                return None, None
            info = by_key[key]
            here = _unwrapped(info.annotation)
        else:
            entry = _entry(here)
            if typing.get_origin(entry) is typing.Annotated:
                info = typing.get_args(entry)[1]
            here = _unwrapped(entry)
    return info, here


def skeleton(annotation: object, entries: int = 12) -> typing.Any:
    """Every key that data of this type can have, as nested dictionaries and lists of `entries`."""
    here = _unwrapped(annotation)
    if isinstance(here, type) and issubclass(here, BaseModel):
        return {f.alias or name: skeleton(f.annotation) for name, f in here.model_fields.items()}
    if typing.get_origin(here) is list:
        return [skeleton(_entry(here)) for _ in range(entries)]
    return {} if typing.get_origin(here) is dict else True


def _entry(annotation: object) -> object:
    arguments = typing.get_args(annotation)
    return arguments[-1] if arguments else None


def _unwrapped(annotation: object) -> typing.Any:
    """Without `Annotated` and `| None`."""
    while True:
        origin = typing.get_origin(annotation)
        if origin is typing.Annotated:
            annotation = typing.get_args(annotation)[0]
        elif origin in (types.UnionType, typing.Union):
            annotation = next(a for a in typing.get_args(annotation) if a is not type(None))
        else:
            return annotation
