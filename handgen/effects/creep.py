"""Silicone that yields with time."""

from __future__ import annotations

import math
from types import MappingProxyType

from handgen.effects.effect import Effect
from handgen.effects.parameter import Parameter, Prior


class Creep(Effect):
    """The silicone's moduli fall by the same share in every decade of time since the first load.

    From when on is open: the law holds for as long as the tensile test took that it comes from.
    """

    id = "creep"
    name = "creep"
    sentence = ("The silicone loses a share of {rate:.3f} of its stiffness in every tenfold of time under "
                "load, from {onset:.1g} s on")
    signature = ("under a held pressure the finger moves on, as much from 1 to 10 minutes as before; later "
                 "readings of a row lie further out than earlier ones; not the bare exoskeleton")
    source = ("A. N. Gent (ed.), Engineering with Rubber: rubbers relax by a few percent a decade of time; "
              "the source notes no times, nor how long the tests of its laws took (onset: assumed)")
    settle = "hold the free actuator at 40 kPa and read it after 10 s, 1 min and 10 min"
    parameters = (
        Parameter("rate", "1", 0.0, 0.2, 0.0, Prior("lognormal", (0.06, 0.7)),
                  "share of stiffness lost a decade of time"),
        Parameter("onset", "s", 0.05, 60.0, 10.0, Prior("lognormal", (1.5, 1.5)),
                  "from when on: what the law's test took, tenths of a second to half a minute"))
    told_by = MappingProxyType({"silicone_softening": ("hold",)})

    def on_course(self, course, p):
        return [p["rate"] * math.log10(1.0 + time / p["onset"]) for time in course.elapsed]


EFFECT = Creep()
