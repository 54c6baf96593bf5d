"""How a finger bends: finite elements on arrays. Knows neither CAD nor files; `solid.simulate` is its door."""
