"""Design rules: a rule is a small function, its limits are data, it returns findings."""

from handgen.checks.run import judge, names, outcome, own_limits, registered, report

__all__ = ["judge", "names", "outcome", "own_limits", "registered", "report"]
