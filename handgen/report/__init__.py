"""One page on which a whole design can be seen and judged, and the server that keeps it fresh while one edits."""

from handgen.report.write import report

__all__ = ["report"]
