"""From a parameter file to its folder: parts, files, previews, manifest."""

from handgen.build.build import build

__all__ = ["build"]
