"""Where simulation and measurement disagree, which missing effect explains it, and what it mends.

Arrays from `library` and `observed` to `verdict`; `run` brings in the simulation.
"""
