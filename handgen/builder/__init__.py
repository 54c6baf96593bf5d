"""From a parameter file to its folder: parts, files, previews, manifest, the rules' report."""

from handgen.builder.build import build
from handgen.builder.check import check

__all__ = ["build", "check"]
