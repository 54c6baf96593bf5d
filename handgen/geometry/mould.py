"""The mould: two halves, the base they stand in, the suspender that hangs the cores (Figure 4.7 a-c, f).

The halves part in the plane z = 0. Base and suspender hold them shut at both ends, rubber bands
between. Nothing in a half lies behind the cavity's edge, so that it opens along z.
"""

from __future__ import annotations

from handgen.geometry import csg
from handgen.geometry.casting import ALONG_X, CHAMFER, LAND, MARGIN, PIN, SALIENCE, Setup, joined

PIN_LENGTH = 4.0
"""Half of it a cylinder that guides, half a cone that finds the hole, mm."""
INWARD = 0.5
"""How much nearer to the cavity than to the outside a pin stands, mm: a groove may run beside it."""
GROOVE = (5.0, 1.2)
"""Width and depth of the grooves for rubber bands, mm."""
PRY = (8.0, 2.5, 1.2)
"""Length, depth and height of the notch for a screwdriver in each half's edge, mm."""
LEAD_IN = 0.8
"""Chamfer around the ends of the halves, mm."""
SKIRT_WALL = 2.4
"""Wall of the suspender's skirt and of the base's rim, mm."""
FLOOR = 4.0
"""Thickness of the base's floor, mm."""
FOOT = 6.0
"""How far the base's foot reaches beyond its rim, mm: the mould stands safely while it is poured."""
SPOKES = 3
SPOKE = 3.0
"""Width of a spoke, mm."""


def half(setup: Setup, pins: bool) -> csg.Shape:
    """The half at z <= 0 with pins (`mould_a`), or its counterpart at z >= 0 with holes."""
    block = _block(setup)
    cuts = [cavity(setup), *_grooves(setup), _pry_notch(setup)]
    upright = [_pin(0.0 if pins else setup.casting.mould_fit).turned("y", -90.0).moved(x, y)
               for x, y in _pin_places(setup)]
    if pins:
        body = csg.Union((csg.Difference(block, tuple(cuts)), *upright))
    else:
        # Drawn at z <= 0 too, then turned about x: the holes are turned beforehand.
        cuts += [p.turned("x", 180.0) for p in upright]
        body = csg.Difference(block, tuple(cuts)).turned("x", 180.0)
    return joined(body, _half_label(setup, "a" if pins else "b", -1.0 if pins else 1.0))


def _block(setup: Setup) -> csg.Shape:
    """The half before anything is cut, its ends chamfered to find their way into the caps."""
    ends = ((setup.top, -LEAD_IN), (setup.top + LEAD_IN, 0.0),
            (setup.length - LEAD_IN, 0.0), (setup.length, -LEAD_IN))
    return csg.Loft(tuple(
        csg.Section(setup.outline(grown, half=True), ALONG_X, (x, 0.0, 0.0)) for x, grown in ends))


def cavity(setup: Setup) -> csg.Shape:
    """The actuator's outside, drawn out beyond the floor, and the pouring cup above x = 0."""
    profile, out = setup.profile, setup.length + MARGIN
    slope = (setup.cup - setup.base) / -setup.top
    path = csg.Path((out, 0.0), ()).line((setup.top - MARGIN, 0.0))
    path = path.line((setup.top - MARGIN, setup.cup + slope * MARGIN), (0.0, setup.base))
    return csg.Revolve(profile.outer.append_to(path).line((out, profile.outer(setup.length))))


def _pin(fit: float) -> csg.Shape:
    """Pin (or, with a fit, its hole) along +x from just inside the block."""
    radius, middle = PIN + fit, PIN_LENGTH / 2 + fit
    return csg.Revolve(csg.Path.polygon([
        (-MARGIN, 0.0), (PIN_LENGTH + fit, 0.0), (PIN_LENGTH + fit, radius / 2),
        (middle, radius), (-MARGIN, radius)]))


def _pin_places(setup: Setup) -> list[tuple[float, float]]:
    """(x, y) of the pins: not symmetric along x, so that halves fit one way only."""
    y = setup.half_width - LAND - INWARD - PIN - setup.casting.mould_fit
    return [(x, side * y) for x in (0.12 * setup.length, 0.82 * setup.length) for side in (-1, 1)]


def _free(setup: Setup) -> tuple[float, float]:
    """The stretch of the halves that neither suspender nor base covers."""
    return setup.top + setup.skirt, setup.length - setup.skirt


def _grooves(setup: Setup) -> list[csg.Shape]:
    """Two grooves for rubber bands around the halves, at the ends of what stays uncovered."""
    width, depth = GROOVE
    start, end = _free(setup)
    if end - start < 3 * width:
        return []
    ring = csg.Difference(
        setup.prism(0.0, width, grown=MARGIN), (setup.prism(-MARGIN, width + MARGIN, grown=-depth),))
    inset = 0.5 * width
    return [ring.moved(x=x) for x in (start + inset, end - inset - width)]


def _pry_notch(setup: Setup) -> csg.Shape:
    """A notch in the split's edge, to lever the halves apart; the two halves' lie on opposite sides."""
    length, depth, height = PRY
    middle, y = sum(_free(setup)) / 2, setup.half_width
    return csg.box((middle - length / 2, -y - MARGIN, -height), (middle + length / 2, depth - y, MARGIN))


def _half_label(setup: Setup, letter: str, side: float) -> csg.Shape | None:
    """The actuator's full name along the half where there is room, else its code across it."""
    start, end = _free(setup)
    along, across = end - start - 4 * GROOVE[0], setup.half_depth - CHAMFER - PRY[2]
    size = min(5.0, 0.5 * across)
    at = ((start + end) / 2, setup.half_width, side * (PRY[2] + across / 2))
    name, code = f"{setup.name.replace('_', ' ')} {letter}", setup.code + letter
    if len(name) * size <= along:
        return setup.label(name, size, at)
    return setup.label(code, min(size, across / len(code), 0.8 * along), at, across=True)


def base(setup: Setup) -> csg.Shape:
    """The plate that both halves stand in; its floor forms the actuator's tip end."""
    fit, rim = setup.casting.mould_fit, setup.casting.mould_fit + SKIRT_WALL
    end = setup.length
    plate = csg.Union((
        setup.prism(end - setup.skirt, end + FLOOR, grown=rim),
        setup.prism(end + FLOOR / 2, end + FLOOR, grown=rim + FOOT),
    ))
    cuts = [setup.prism(end - setup.skirt - MARGIN, end, grown=fit)]
    if setup.salience:
        radius = setup.salience + setup.casting.core_fit
        cuts.append(csg.cylinder(radius, end - MARGIN, end + SALIENCE + fit))
    at = (end - setup.skirt / 2, setup.half_width + rim, 0.0)
    label = setup.label(setup.code + "c", setup.text, at, across=True)
    return joined(csg.Difference(plate, tuple(cuts)), label)


def suspender(setup: Setup) -> csg.Shape:
    """The cap on the mould's top: a hub on spokes that hangs the cores centred, gates between."""
    fit, rim = setup.casting.mould_fit, setup.casting.mould_fit + SKIRT_WALL
    cap = setup.prism(setup.seat, setup.top + setup.skirt, grown=rim)
    inside = setup.prism(setup.top, setup.top + setup.skirt + MARGIN, grown=fit)
    low, high = setup.seat - MARGIN, setup.top + MARGIN
    spokes = [
        csg.box((low - MARGIN, 0.0, -SPOKE / 2), (high + MARGIN, setup.cup + MARGIN, SPOKE / 2))
        .turned("x", 90.0 + 360.0 * i / SPOKES)
        for i in range(SPOKES)
    ]
    gates = csg.Difference(
        csg.cylinder(setup.cup, low, high),
        (csg.cylinder(setup.hub, low - MARGIN, high + MARGIN), *spokes))
    hub_bore = csg.cylinder(setup.bore, low, high)
    at = ((setup.seat + setup.top) / 2, setup.half_width + rim, 0.0)
    label = setup.label(setup.code + "f", setup.text, at, across=True)
    return joined(csg.Difference(cap, (inside, gates, hub_bore)), label)
