"""From a hand to a sheet that leads through printing, casting, sealing and assembling it."""

from handgen.worksheet.sheet import worksheet

__all__ = ["worksheet"]
