"""What seals an actuator's base (Figure 4.7 g, h): the plug in its channel, the collar behind it.

The plug is glued into the channel and holds the tube; the collar lies on the plug's neck behind the
silicone and guides the base squarely into the exoskeleton's bore. Printed standing on the flange.
"""

from __future__ import annotations

from handgen.geometry import csg
from handgen.geometry.actuator import layers_path
from handgen.geometry.casting import MARGIN, Setup
from handgen.geometry.profile import Curve
from handgen.parameters.model import OPPOSITION

LEAST = 0.4
"""Thinnest wall of plug and collar, mm: one line of a 0.35 mm nozzle; glued, they back one another."""
LEAST_AIR = 0.3
"""Radius of the finest air hole, mm."""
SHOULDER = 1.0
"""How far the neck reaches over the silicone's end face beyond the plug, mm."""
FLANGE = 2.0
"""Thickness of the flange behind the collar, mm."""
LEAD_IN = 0.4
"""Chamfer of the tube's hole and of the plug's tip, mm."""


def plug(setup: Setup) -> csg.Shape:
    """Shank in the channel, neck for the collar, flange, and the tube's hole right through.

    Raises:
        GeometryError: the plug is too long for the chamber, or the tube too wide for it.
    """
    length, squeeze = setup.seal.plug_length, setup.seal.plug_squeeze
    if length > setup.profile.small_core_end - MARGIN:
        raise setup.error("plug", "seal.plug_length",
                          f"{length:g} mm do not fit a chamber of {setup.profile.small_core_end:.2f} mm")
    shank = setup.profile.small_core.affine(1.0, squeeze).between(0.0, length - LEAD_IN)
    neck, back = _neck(setup), _back(setup)
    flange = (neck + _outside(setup)) / 2
    path = csg.Path((back, 0.0), ()).line((back, flange), (back + FLANGE, flange), (back + FLANGE, neck))
    path = shank.append_to(path.line((0.0, neck), (0.0, shank(0.0))))
    path = path.line((length, shank.pieces[-1].y1 - LEAST / 2), (length, 0.0))
    return csg.Difference(csg.Revolve(path), (_bore(setup, shank),))


def _bore(setup: Setup, shank: Curve) -> csg.Shape:
    """The tube's hole with its lead-in; where the shank narrows too much, a finer one carries on."""
    tube, back, out = _tube(setup), _back(setup), setup.seal.plug_length + MARGIN
    path = csg.Path((out, 0.0), ()).line((back - MARGIN, 0.0), (back - MARGIN, tube + LEAD_IN + MARGIN))
    path = path.line((back + LEAD_IN, tube))
    end = shank.crossing(tube + LEAST)
    if end is None:
        return csg.Revolve(path.line((out, tube)))
    air = shank.pieces[-1].y1 - LEAST
    if end <= 0.0 or air < LEAST_AIR:
        raise setup.error("plug", "seal.tube_outer_diameter",
                          f"its hole of {2 * tube:.2f} mm does not fit a plug that narrows from"
                          f" {2 * shank(0.0):.2f} to {2 * (air + LEAST):.2f} mm")
    return csg.Revolve(path.line((max(end - (tube - air), end / 2), tube), (end, air), (out, air)))


def collar(setup: Setup) -> csg.Shape:
    """The ring on the plug's neck, from the silicone's end face backwards."""
    outside, inside = _outside(setup), _neck(setup) + setup.seal.glue_gap
    length, chamfer = setup.seal.collar_length, min(LEAD_IN, (outside - inside) / 2)
    ring = csg.Revolve(csg.Path.polygon([
        (-length, 0.0), (0.0, 0.0), (0.0, outside),
        (chamfer - length, outside), (-length, outside - chamfer)]))
    return csg.Difference(ring, (csg.cylinder(inside, -length - MARGIN, MARGIN),))


def bore_radius(setup: Setup) -> float:
    """Radius of what the actuator's base sits in: the finger's bore, or the palm's socket."""
    if setup.name in OPPOSITION:
        opposition = setup.hand.opposition
        return setup.base + (opposition.clearance if opposition else 0.0)
    finger = getattr(setup.hand.fingers, setup.name)
    return finger.base_bore_diameter / 2 if finger else setup.base


def _outside(setup: Setup) -> float:
    return bore_radius(setup) - setup.seal.collar_fit


def _tube(setup: Setup) -> float:
    return setup.seal.tube_outer_diameter / 2 + setup.seal.tube_fit


def _back(setup: Setup) -> float:
    return -setup.seal.collar_length - FLANGE


def _neck(setup: Setup) -> float:
    """Radius of the plug between collar and silicone.

    Raises:
        GeometryError: tube, plug and collar do not fit into one another inside the bore.
    """
    shank = setup.profile.small_core(0.0) + setup.seal.plug_squeeze
    widest = _outside(setup) - setup.seal.glue_gap - LEAST
    neck = max(min(shank + SHOULDER, widest), _tube(setup) + LEAST)
    if shank > widest:
        raise setup.error("collar", layers_path(setup.hand, setup.name),
                          f"the plug of {2 * shank:.2f} mm does not pass through a collar that fits a bore of"
                          f" {2 * bore_radius(setup):.2f} mm: the actuator's wall is too thin")
    if neck > widest:
        raise setup.error("collar", "seal.tube_outer_diameter",
                          f"around the tube a neck of {2 * neck:.2f} mm is needed, but inside a bore of"
                          f" {2 * bore_radius(setup):.2f} mm the collar leaves {2 * widest:.2f} mm")
    return neck
