"""One page on which a whole design can be seen and judged."""

from handgen.report.write import report

__all__ = ["report"]
