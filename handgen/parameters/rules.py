"""A lab's own word on the design rules: other limits, and findings it accepts, each with its reason."""

from __future__ import annotations

from typing import Annotated

from pydantic import ConfigDict, Field

from handgen.parameters.quantity import Model, item, quantity

Reason = Annotated[str, Field(min_length=3, max_length=400)]


class OwnLimit(Model):
    """A number in the place of the shipped one, in that limit's unit."""

    value: float = quantity("that of the shipped limit", -1e6, 1e6, "the limit")
    reason: Reason = item("why this number; it stands in the findings as their source")


class OwnLimits(Model):
    """A limit for everything, for single materials, print processes or roles of parts, or both."""

    model_config = ConfigDict(populate_by_name=False)

    value: float | None = item("the limit, in the shipped limit's unit", default=None, ge=-1e6, le=1e6)
    reason: Reason | None = item("why this number", default=None)
    for_: dict[str, OwnLimit] = Field(
        default_factory=dict, alias="for", description="material, print process or role -> its own limit")


class Override(Model):
    """Findings of one rule that the maker accepts."""

    rule: str = item("name of the rule, as in checks.json", max_length=100)
    part: str = item("name or glob of the parts it is accepted for", default="*", max_length=200)
    reason: Reason = item("why it is accepted; recorded beside every finding")


class Rules(Model):
    """Own limits beside the shipped ones, and accepted findings."""

    limits: dict[str, dict[str, OwnLimits]] = item("rule -> name of the limit -> own number",
                                                   default_factory=dict)
    overrides: list[Override] = item("findings that are accepted", default_factory=list, max_length=100)
