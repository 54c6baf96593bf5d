"""What Table B.1 leaves open and both slicers are told alike, so that they print the same thing."""

RAFT_LAYERS = 4
"""Cura's own: a base, an interface, two surfaces."""
RAFT_MARGIN = 3.0
"""How far a raft reaches out beyond its part, mm."""
AIR_GAP = 0.15
"""Between raft and part, mm: Cura's own 0.3 less the 0.15 by which it then presses the part down."""
SUPPORT_XY = 0.7
"""Between support and part, sideways, mm: Cura's own."""
RETRACTION_SPEED = 25.0
"""mm/s: Cura's own."""
SLOWEST = 10.0
"""mm/s: short layers are printed no more slowly; Cura's own."""
COMBING = 5.0
"""mm: longer ways inside a part are travelled with the filament drawn back, as PrusaSlicer does."""
