"""A number with unit, range, meaning and origin: the building block of every parameter model."""

from __future__ import annotations

from typing import Any

from pydantic import BaseModel, ConfigDict, Field
from pydantic_core import PydanticUndefined


class Model(BaseModel):
    """Frozen and closed: an unknown key is an error, a value never changes after loading."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, strict=True, defer_build=True)


def quantity(
    unit: str,
    low: float,
    high: float,
    meaning: str,
    *,
    default: Any = PydanticUndefined,
    source: str | None = None,
    assumed: str | None = None,
) -> Any:
    """A number in `unit` within [low, high].

    `source` says where the source gives it; `assumed` why a default that the source does not
    give is what it is. A default that carries `assumed` and is left alone ends up in the
    manifest's list of assumptions.
    """
    return Field(
        default,
        ge=low,
        le=high,
        description=meaning,
        json_schema_extra=_extra(unit, source, assumed),
    )


def item(
    meaning: str,
    *,
    default: Any = PydanticUndefined,
    default_factory: Any = None,
    source: str | None = None,
    assumed: str | None = None,
    **limits: Any,
) -> Any:
    """A parameter that is not a plain number (a name, a list, a switch)."""
    keywords: dict[str, Any] = {"description": meaning, **limits}
    extra = _extra(None, source, assumed)
    if extra:
        keywords["json_schema_extra"] = extra
    if default_factory is not None:
        return Field(default_factory=default_factory, **keywords)
    return Field(default, **keywords)


def _extra(unit: str | None, source: str | None, assumed: str | None) -> dict[str, str]:
    pairs = {"unit": unit, "source": source, "assumed": assumed}
    return {key: value for key, value in pairs.items() if value}
