"""Design rules: a rule is a small function, its limits are data, it returns findings."""

from handgen.checks.run import definition, everything

__all__ = ["definition", "everything"]
