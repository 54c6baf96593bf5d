"""How a finger bends: finite elements on arrays. Knows no CAD, no files; `solid.simulate` is its door."""
