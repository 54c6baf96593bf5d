"""Constitutive laws, and named parameter sets with their source, unit, convention and limits."""
