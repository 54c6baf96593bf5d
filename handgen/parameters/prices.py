"""What materials cost, for the bill of materials; whatever is left out is left out of the sum, and said."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from handgen.parameters.quantity import Model, item, quantity

HIGHEST = 100_000


class Prices(Model):
    """Of one's own shop, in one currency."""

    currency: str = item("of all prices", default="EUR", max_length=10)
    filament: dict[str, Annotated[float, Field(ge=0, le=HIGHEST)]] = item(
        "filament -> price of 1 kg", default_factory=dict)
    silicone: float | None = quantity("1/kg", 0, HIGHEST, "parts A and B together", default=None)
    thread: float | None = quantity("1/m", 0, HIGHEST, "thread", default=None)
    tube: float | None = quantity("1/m", 0, HIGHEST, "air tube", default=None)
    adhesive: float | None = quantity("1", 0, HIGHEST, "one bottle, which is enough", default=None)
