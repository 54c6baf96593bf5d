"""What was measured on a finger, as files that can be checked, and the scatter of their repeats."""

from handgen.measurements.load import Measured, load_measurements
from handgen.measurements.model import Measurements, Test

__all__ = ["Measured", "Measurements", "Test", "load_measurements"]
