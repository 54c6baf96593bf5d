"""Design rules: a rule is a small function, its limits are data, it returns findings."""

from handgen.checks.run import judge

__all__ = ["judge"]
