"""Contact without friction between actuator and bore, found anew in every iteration by NGSolve's own search.

Where the fast solver lets points of the actuator meet a bone's bore in closed form, here points of the
deformed bore look for the nearest place on the deformed actuator; both surfaces bend. The physics is the fast
solver's: the same energy of a gap, bores that open like a rim towards their slots, strips that nothing
touches, a tip whose face meets the bore's flat end.
"""

from __future__ import annotations

from handgen.geometry.profile import FingerProfile
from handgen.simulation.contact import PENALTY, RIM, SOFT
from handgen.simulation.reference import slotted, tube

REACH = 2.0
"""mm; beyond it nothing is looked for."""
ORDER = 4
"""Of the rule that integrates over the bore's triangles."""


class Sliding:
    """The energy of contact in `form`, for displacements `moved` (a trial function on `mesh`).

    `along`: the field of places along the straight finger, mm.
    """

    def __init__(self, form, mesh, moved, along, finger: FingerProfile):
        import ngsolve as ng

        self._form = form
        place = ng.CoefficientFunction((ng.x, ng.y, ng.z))
        apart = place.Other() + moved.Other() - place - moved
        closed, rim = _bones(along, finger)
        side = ng.ContactBoundary(mesh.Boundaries(slotted.BORE), mesh.Boundaries(tube.OUTSIDE))
        side.AddEnergy(closed * _onset(ng.InnerProduct(apart, side.normal) + rim))
        tip = ng.ContactBoundary(mesh.Boundaries(tube.FACE), mesh.Boundaries(slotted.END))
        tip.AddEnergy(_onset(ng.InnerProduct(apart, tip.normal)))
        self._contacts = side, tip

    def find(self, state) -> None:
        """Pair the surfaces as they lie in `state`, a function whose first component is the displacement."""
        for contact in self._contacts:
            contact.Update(state.components[0], bf=self._form, intorder=ORDER, maxdist=REACH)


def _bones(along, finger: FingerProfile):
    """(1 on bones and 0 in slots, mm by which the bore stands back from the actuator near a slot)."""
    import ngsolve as ng

    closed, rim = ng.CoefficientFunction(1.0), ng.CoefficientFunction(0.0)
    for joint in finger.finger.joints:
        away = ng.sqrt((along - joint.position) ** 2) - joint.slot_length / 2
        within = ng.IfPos(away, ng.IfPos(RIM - away, RIM - away, 0.0), 0.0)
        closed, rim = closed * ng.IfPos(away, 1.0, 0.0), rim + within**2 / (2 * RIM)
    return closed, rim


def _onset(gap):
    """Energy per area, N/mm: nothing of a gap, a cubic down to -2 SOFT, a parabola below it."""
    import ngsolve as ng

    closer = gap + SOFT
    cubic = (SOFT - closer) ** 3 / (12 * SOFT)
    parabola = closer**2 / 2 + SOFT**2 / 6
    return PENALTY * ng.IfPos(-gap, ng.IfPos(closer + SOFT, cubic, parabola), 0.0)
