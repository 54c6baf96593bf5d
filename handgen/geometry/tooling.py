"""Everything one actuator is cast and sealed with: eight parts (Figure 4.7 a-h).

All stand in the actuator's frame as assembled, x from base to tip, so that what they leave open
can be compared with the actuator directly. How to use them: stand both halves in the base, fill
the wound large core's mould through the suspender's gates, let it cure, open, pull the core; put
the first layer back, repeat with the small core; glue plug and collar into the base.
"""

from __future__ import annotations

from handgen.geometry import cores, csg, mould, seals
from handgen.geometry.casting import Setup
from handgen.geometry.part import Body, Part
from handgen.parameters.model import Hand

ROLES = ("mould_a", "mould_b", "mould_base", "core_large", "core_small", "suspender", "plug", "collar")
COLOURS = {
    "mould_a": (0.45, 0.60, 0.75), "mould_b": (0.55, 0.70, 0.83), "mould_base": (0.35, 0.45, 0.58),
    "core_large": (0.90, 0.60, 0.25), "core_small": (0.93, 0.75, 0.35), "suspender": (0.50, 0.68, 0.50),
    "plug": (0.35, 0.35, 0.38), "collar": (0.55, 0.55, 0.58),
}
UP = {
    "mould_a": (0.0, 0.0, 1.0), "mould_b": (0.0, 0.0, -1.0), "mould_base": (-1.0, 0.0, 0.0),
    "core_large": (1.0, 0.0, 0.0), "core_small": (1.0, 0.0, 0.0), "suspender": (1.0, 0.0, 0.0),
    "plug": (1.0, 0.0, 0.0), "collar": (1.0, 0.0, 0.0),
}
"""What faces up on the print bed: open halves, caps opening upwards, cores on their knobs."""


def tooling(hand: Hand, name: str) -> list[Part]:
    """The eight tooling parts of actuator `name`, in the order of Figure 4.7.

    Raises:
        GeometryError: the parameters leave no room for one of them; names the part and parameter.
    """
    setup = Setup(hand, name)
    shapes = {
        "mould_a": mould.half(setup, pins=True),
        "mould_b": mould.half(setup, pins=False),
        "mould_base": mould.base(setup),
        "core_large": cores.large_core(setup),
        "core_small": cores.small_core(setup),
        "suspender": mould.suspender(setup),
        "plug": seals.plug(setup),
        "collar": seals.collar(setup),
    }
    return [_part(setup, role, shape) for role, shape in shapes.items()]


def _part(setup: Setup, role: str, shape: csg.Shape) -> Part:
    bodies = ()
    if role == "core_large" and setup.thread.groove:
        bodies = (Body(role, cores.large_core(setup, rings=True), COLOURS[role]),)
    return Part(
        name=f"tooling/{setup.name}/{role}",
        role=role,
        material=setup.hand.printing.tooling.material,
        shape=shape,
        colour=COLOURS[role],
        path=setup.path,
        up=UP[role],
        bodies=bodies,
    )
