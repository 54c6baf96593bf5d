"""handgen: from one parameter file to a soft pneumatic hand that can be printed, cast and assembled."""

__version__ = "0.1.0"
