"""Where model and readings part: shape of the residual, last point, drift, and the way back."""

from __future__ import annotations

import numpy as np
import pytest

from handgen.discrepancy.locate import compared, locate
from handgen.discrepancy.observed import Observed, Readings
from tests.small_library import TESTS, library, readings, truth


def test_location_finds_the_shape_of_a_residual():
    lib = library()
    x = np.array(TESTS[2].loads) / 60
    for shape, added in (
        ("offset", np.full(6, 4.0)),
        ("slope", 8 * (x - 0.5)),
        ("curvature", 12 * (x - x.mean()) ** 2),
    ):
        world = lib.baseline.copy()
        world[lib.points("finger")] -= added
        found = {one.test: one for one in locate(lib, readings(lib, world))}["finger"]
        sizes = {name: abs(sigmas) for name, _, sigmas in found.shapes}
        assert found.beyond and max(sizes, key=sizes.get) == shape


def test_location_finds_a_last_point_that_leaves_the_line():
    lib = library()
    world = lib.baseline.copy()
    world[lib.points("free")[-1]] += 3.0
    found = {one.test: one for one in locate(lib, readings(lib, world))}
    size, sigmas = found["free"].last
    assert size == pytest.approx(-3.0, abs=1.0) and sigmas < -3
    assert any(words.startswith("at 50 -3") for words in found["free"].words)
    assert not found["weights"].beyond


def test_a_single_repeat_that_is_far_off_is_beyond_chance():
    lib = library()
    found = {one.test: one for one in locate(lib, readings(lib, truth(lib, sag=1.0), repeats=1))}
    assert found["finger"].beyond and found["finger"].assumed > 0.5 and not found["weights"].beyond
    found = locate(lib, readings(lib, truth(lib, sag=1.0)))
    assert all(one.assumed is None for one in found)


def test_a_residual_that_bends_all_along_is_no_event_at_the_last_load():
    lib = library()
    points = lib.points("finger")
    world = lib.baseline.copy()
    world[points] -= 8 * (lib.loads[points] / 60) ** 2
    found = {one.test: one for one in locate(lib, readings(lib, world))}["finger"]
    assert found.beyond and abs(found.last[1]) < 3


def test_location_finds_drift_and_hysteresis():
    down = library(
        (*TESTS, TESTS[2].__class__("back", "assembly", "tip_drop", TESTS[2].loads[::-1], path="unloading"))
    )
    world = down.baseline.copy()
    world[down.points("back")] = world[down.points("finger")][::-1] + 3.0
    seen = readings(down, world, scatter={"finger": 0.5, "back": 0.5}, ids=("finger", "back"))
    ((up, back, size, sigmas),) = compared(seen, down)
    assert (up, back) == ("finger", "back") and size == pytest.approx(3.0, abs=0.5) and sigmas > 3
    rows = seen.tests[0].repeats + 4.0 * np.arange(3)[:, None]
    drifting = Observed((Readings("finger", rows, 0.5),))
    assert locate(down, drifting)[0].drift[0] == pytest.approx(4.0, abs=0.5)
