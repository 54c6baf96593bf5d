"""Worlds of another structure than the model: planar chains that give measurements with a hidden effect."""
