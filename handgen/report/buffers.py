"""Numbers for the page: every array in one buffer, coordinates in 16 bits, normals in 8."""

from __future__ import annotations

import base64
from typing import Any

import numpy as np

STEPS = 65535
"""Of a coordinate within its box: 4 micrometres in a hand of 250 mm."""
ALIGNED = 4
"""Bytes: a typed array begins at a multiple of its size."""


class Buffer:
    """Arrays one behind the other, little endian; each is found by where it begins and how long it is."""

    def __init__(self):
        self._bytes = bytearray()

    def add(self, array: np.ndarray) -> dict[str, Any]:
        """Where `array` lies: {"at": byte, "length": numbers, "type": "u1", "i1", "u2" or "u4"}."""
        content = np.ascontiguousarray(array)
        content = content.astype(content.dtype.newbyteorder("<"))
        self._bytes += b"\0" * (-len(self._bytes) % ALIGNED)
        place = {"at": len(self._bytes), "length": int(content.size), "type": content.dtype.str[1:]}
        self._bytes += content.tobytes()
        return place

    def add_points(self, points: np.ndarray) -> dict[str, Any]:
        """`points` (..., 3), mm, within their box: place of the numbers, its corner, and mm a step."""
        flat = points.reshape(-1, 3)
        low = flat.min(axis=0)
        step = np.maximum(np.ptp(flat, axis=0), 1e-6) / STEPS
        return {**self.add(np.rint((flat - low) / step).astype(np.uint16)),
                "low": low.tolist(), "step": step.tolist()}

    def text(self) -> str:
        return base64.b64encode(self._bytes).decode("ascii")
