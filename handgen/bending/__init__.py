"""From a hand and what acts on it to a bend, and from a bend to files: all around the solvers."""

from handgen.bending.files import target, write
from handgen.bending.request import Request, request
from handgen.bending.result import Bend
from handgen.bending.run import bend, solve

__all__ = ["Bend", "Request", "bend", "request", "solve", "target", "write"]
