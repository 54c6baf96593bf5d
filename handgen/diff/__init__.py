"""What changes between two parameter files: parts, masses, times, rules and bend."""

from handgen.diff.compare import diff

__all__ = ["diff"]
