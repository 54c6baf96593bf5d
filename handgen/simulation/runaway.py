"""When a wall gives way: how far it is stretched, and where.

A chamber that balloons past its limit pressure is held by nothing until it tears. Followed in artificial time
it grows without end, and is given up at STRETCH.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from handgen.simulation import element, shapes

if TYPE_CHECKING:
    from handgen.geometry.profile import FingerProfile
    from handgen.simulation.system import System

STRETCH = 6.0
"""Of a wall that is followed no farther: the laws rest on stretches up to 2, silicone tears at 10."""


@dataclass(frozen=True)
class Wall:
    """The most stretched place of an actuator: its stretch, and its x at rest, mm."""

    stretch: float = 1.0
    x: float = 0.0

    @property
    def runs_away(self) -> bool:
        return self.stretch > STRETCH

    def where(self, finger: FingerProfile | None) -> str:
        """Its place, with the joint in whose slot it lies, where there is one."""
        joints = finger.finger.joints if finger else ()
        slot = [f" in the slot of {j.name}" for j in joints if 2 * abs(self.x - j.position) <= j.slot_length]
        return f"at x = {self.x:.0f} mm{slot[0] if slot else ''}"


def weakest(system: System, q: np.ndarray) -> Wall:
    """The most stretched element of the actuator in the state `q`."""
    if system.actuator is None:
        return Wall()
    cells = system.actuator.grid.cells
    slopes, _ = shapes.gradients(system.unstrained, cells, np.zeros((1, 3)))
    stretch = element.largest_stretch(system.positions(q), cells, slopes)
    worst = int(np.argmax(stretch))
    return Wall(float(stretch[worst]), float(system.actuator.grid.nodes[cells[worst], 0].mean()))
