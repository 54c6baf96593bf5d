"""What was sliced before and still holds for a hand."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from handgen.parameters.model import Hand
from handgen.slicing import files
from handgen.slicing.slice import asked_key, printed


def rows(hand: Hand, folder: Path) -> list[dict[str, Any]]:
    """Rows of `folder`'s slices.json that are of these very parts and settings; needs no slicer."""
    listed = files.read(folder)
    if not listed:
        return []
    keys = {name: asked_key(hand, part) for name, part in printed(hand).items()}
    return [row for row in listed if row.get("asked", "") == keys.get(row["part"])]
