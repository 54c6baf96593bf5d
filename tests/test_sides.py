"""An effect of either sign of which the readings tell only the size: it is said, and the test that tells is
asked for."""

from dataclasses import replace

import numpy as np
import pytest

from handgen.discrepancy.hypothesis import estimates
from handgen.discrepancy.library import Response
from handgen.discrepancy.score import score
from handgen.discrepancy.sides import either_way, parted, signed, which_way
from handgen.discrepancy.verdict import verdict
from tests.small_library import MORE, TESTS, library, readings

WINDING = "asymmetric_winding"
GIVEN = ("weights", "free", "finger")
SCATTER = {"weights": 1.0, "free": 0.4, "finger": 0.5, "angle": 1.0, "up": 0.5}


def wound(towards=0.0):
    """The small library with a winding off the middle: the free actuator reads its square, an angle its sign,
    the finger a little of the sign (`towards`, mm)."""
    lib = library((*TESTS, *MORE))
    free, angle = lib.points("free"), lib.points("angle")
    size = np.linspace(-0.6, 0.6, 7)
    rows = np.tile(lib.baseline, (7, 1))
    rows[:, free] -= np.outer((size / 0.4) ** 2, 8.0 * (lib.loads[free] / 50) ** 2)
    rows[:, angle] += np.outer(size / 0.4, 9.0 * lib.loads[angle] / 60)
    rows[:, lib.points("finger")] += np.outer(size / 0.4, towards * lib.loads[lib.points("finger")] / 60)
    response = Response(WINDING, ("offset",), (size,), (np.exp(-(size / 0.25) ** 2 / 2),), rows)
    return replace(lib, responses={"curl": lib.responses["curl"], WINDING: response})


def seen(lib, ids, size=-0.4):
    at = int(np.abs(lib.responses[WINDING].axes[0] - size).argmin())
    return readings(lib, lib.responses[WINDING].predictions[at], scatter=SCATTER, ids=ids)


def test_a_name_of_which_the_side_is_open_asks_for_the_test_that_tells_it():
    lib = wound()
    scores = score(lib, seen(lib, GIVEN))
    said = verdict(scores)
    assert (said.word, said.effects) == ("named", (WINDING,))
    assert either_way(said) == {WINDING: 0.0}
    asked = which_way(scores.problem, either_way(said), ["up", "angle"])
    assert asked.test == "angle" and asked.separates == (WINDING,) and asked.gain > 0.4
    assert which_way(scores.problem, either_way(said), ["up"]) is None
    told = verdict(score(lib, seen(lib, (*GIVEN, "angle"))))
    assert told.effects == (WINDING,) and either_way(told) == {}
    assert told.best.parameters[WINDING][0].value == pytest.approx(-0.4, abs=0.1)


def test_a_side_that_the_readings_tell_is_not_asked_about():
    lib = wound(towards=12.0)
    said = verdict(score(lib, seen(lib, GIVEN)))
    assert said.effects == (WINDING,) and either_way(said) == {}
    assert said.best.parameters[WINDING][0].value < 0


def test_a_side_is_open_until_it_is_surer_than_a_size():
    lib = wound(towards=6.0)
    said = verdict(score(lib, seen(lib, GIVEN)))
    (offset,) = said.best.parameters[WINDING]
    assert offset.high < 0 < offset.wide[1] and either_way(said) == {WINDING: 0.0}


def test_intervals_are_those_of_what_is_believed():
    line = np.linspace(-8, 8, 1601)
    (size,) = estimates(("size",), line[:, None], -((line - 1) / 0.5) ** 2 / 2)
    assert (size.low, size.high) == pytest.approx((1 - 0.98, 1 + 0.98), abs=0.01)
    assert size.wide == pytest.approx((1 - 1.288, 1 + 1.288), abs=0.01)


def test_only_what_is_named_and_has_either_sign_has_a_side():
    lib = wound()
    said = verdict(score(lib, seen(lib, GIVEN)))
    for other in ({"word": "ambiguous"}, {"or_both": ("a", "b")}, {"effects": ("creep", "own_weight")}):
        assert either_way(replace(said, **other)) == {}
    sided = (WINDING, "pressure_offset", "scale_error")
    assert tuple(filter(signed, (*sided, "own_weight", "bore_friction", "sag"))) == sided


def test_the_two_sides_are_the_effect_and_overlap_in_nothing_but_none():
    lib = wound()
    whole = lib.responses[WINDING]
    halves, (below, above) = parted(replace(lib, on={"sag": {"size": 1.0}}), WINDING, 0.0)
    assert (below, above) == (f"sag+{WINDING} below", f"sag+{WINDING} above")
    first, second = halves.responses.values()
    assert list(first.axes[0]) + list(second.axes[0])[1:] == pytest.approx(list(whole.axes[0]))
    assert first.axes[0][-1] == second.axes[0][0] == 0.0
    assert len(first.densities[0]) == len(first.axes[0]) == len(first.predictions)
    table = replace(whole, densities=(np.array([whole.axes[0], whole.densities[0]]),))
    halves, _ = parted(replace(lib, responses={WINDING: table}), WINDING, 0.0)
    assert all(one.densities[0].shape == (2, 7) for one in halves.responses.values())
