"""Formulas that the design rules rest on: pure functions on numbers and arrays, mm, N, MPa, rad."""
