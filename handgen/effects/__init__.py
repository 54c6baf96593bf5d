"""Physical effects that a model may lack: real extensions, switched on inside the simulation, one a file."""

from handgen.effects.course import Course
from handgen.effects.effect import Effect
from handgen.effects.parameter import Parameter, Prior
from handgen.effects.registry import Switched, catalogue, faults

__all__ = ["Course", "Effect", "Parameter", "Prior", "Switched", "catalogue", "faults"]
