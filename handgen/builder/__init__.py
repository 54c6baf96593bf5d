"""From a parameter file to its folder: parts, files, previews, manifest."""

from handgen.builder.build import build

__all__ = ["build"]
