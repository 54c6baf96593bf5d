"""What a sweep file says (`schema: handgen.sweep/1`)."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field

from handgen.parameters.quantity import Model, item, quantity

SCHEMA = "handgen.sweep/1"
Name = Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9_-]{0,63}$")]
Method = Literal["grid", "sobol", "optimise"]
Direction = Literal["maximise", "minimise"]
MOST = 1_000_000
"""Variants of one sweep at most."""


class Axis(Model):
    """One thing that varies. A list stands for `choices`, `low:high:step` for a range with a step."""

    choices: list[Any] | None = item("values to try", default=None, min_length=1, max_length=10_000)
    low: float | None = item("least value", default=None)
    high: float | None = item("largest value", default=None)
    step: float | None = item("of a range on a grid", default=None, gt=0)
    steps: int | None = item("values of a range or distribution on a grid", default=None, ge=1, le=10_000)
    distribution: Literal["uniform", "loguniform", "normal", "triangular"] | None = item(
        "within low and high (uniform); normal has `mean` and `sigma` and may be cut off at low and high; "
        "triangular has its `mode`", default=None)
    mean: float | None = item("of a normal distribution", default=None)
    sigma: float | None = item("its standard deviation", default=None, gt=0)
    mode: float | None = item("likeliest value of a triangular distribution", default=None)
    adds: dict[str, float] | None = item(
        "key path -> factor: each is the base's value plus factor times this, several axes added up; the "
        "axis then has any name", default=None, min_length=1)
    scales: list[str] | None = item(
        "key paths: each is the base's value times this; the axis then has any name", default=None,
        min_length=1)


class Bending(Model):
    """The bend that every variant is judged by."""

    finger: str = item("which", default="index")
    part: Literal["assembly", "actuator"] = item("what is bent", default="assembly")
    pressures: list[float] | str = item("kPa, rising: a list, or start:end:step", default="0,30,60")
    pressure: float | None = quantity(
        "kPa", 0, 150, "the only pressure, where that is what varies", default=None)
    orientation: str = item("of the hand", default="palm_down")
    refine: int = item("0 to 3: each halves the elements", default=0, ge=0, le=3)


class Force(Model):
    """The fingertip's force on a plane."""

    pressure: float = quantity("kPa", 1, 150, "at which it is asked for", default=80.0)
    obstacle: float = quantity("mm", 0.1, 200, "how far the plane lies below the palm side", default=40.0)


class Bound(Model):
    """What a result must keep to."""

    min: float | None = item("at least", default=None)
    max: float | None = item("at most", default=None)


class Confirm(Model):
    """The best variants once more, by a better model."""

    best: int = item("how many", default=3, ge=1, le=1000)
    solver: str = item("by which solver", default="solid")
    refine: int = item("0 to 3", default=0, ge=0, le=3)
    rules: Literal["definition", "all"] = item("which rules", default="all")


class Sweep(Model):
    """A sweep as its file says it."""

    schema_: Literal["handgen.sweep/1"] = Field(alias="schema", description="version of this format")
    name: Name = item("names the output folder")
    description: str = item("one line for people", default="", max_length=400)
    base: str = item("a parameter file, relative to this one", min_length=1)
    model: str | None = item("materials and friction: a name of params/models or a file", default=None)
    vary: dict[str, Axis] = item("key path -> list, range or distribution", min_length=1, max_length=64)
    method: Method = item("how variants are drawn", default="grid")
    budget: int | None = item("variants (at most, for a grid)", default=None, ge=1, le=MOST)
    solver: str = item("what bends a variant", default="solid")
    bend: Bending = item("the bend", default_factory=Bending)
    force: Force | None = item("left out: no fingertip force", default=None)
    rules: Literal["none", "definition", "all"] = item(
        "which design rules judge a variant: those that need no mesh, or all of them", default="definition")
    objectives: dict[str, Direction] = item("result -> maximise or minimise", default_factory=dict)
    constraints: dict[str, Bound] = item("result -> {min, max}", default_factory=dict)
    keep: str | int | None = item("`best N`: write their parameter files, and their finger", default=None)
    confirm: Confirm | None = item("left out: nothing is confirmed", default=None)
    seed: int = item("of everything random", default=0, ge=0, le=2**31 - 1)
    time_limit: float = quantity("s", 1, 86_400, "for one variant", default=300.0)
