"""What an undecided diagnosis says to people: classes that read the same, and what would settle it."""

from types import SimpleNamespace

import pytest

from handgen import tables
from handgen.discrepancy import document, page

CLASSES = [{"ids": ["soft", "creep", "soft+creep", "worn", "wide"], "probability": 0.7},
           {"ids": ["none"], "probability": 0.25}]
NAMES = {"soft": "soft silicone", "none": "nothing missing", "creep": "creep"}
OPEN = {
    "verdict": "ambiguous", "effects": [], "classes": CLASSES, "patch": [], "flags": [], "next_test": None,
    "gap": {"unit": "mm", "tests": []}, "model": "model.yaml",
    "measure_directly": {"effect": "soft", "name": "soft silicone", "how": "pull a strip <of it>"}}


def test_what_reads_the_same_is_said_together_and_not_spelt_out_for_ever():
    said = page._verdict(OPEN, NAMES)
    assert "<b>soft silicone</b> or, which reads the same, creep, soft+creep, worn or 1 more (70 %" in said
    assert "<b>nothing missing</b> (25 %)" in said


def test_the_direct_measurement_is_told_on_page_and_in_the_terminal():
    assert "soft silicone is settled so: pull a strip &lt;of it&gt;." in "".join(page._next(OPEN, NAMES))
    text = tables.diagnosed(OPEN, "out", lambda words, colour: words)
    assert "settle soft silicone without any model: pull a strip <of it>" in text
    assert "soft or creep or soft+creep or worn or 1 more: no reading here tells them apart" in text


def test_the_next_test_is_told_by_names_and_units_as_they_are_written():
    told = {"words": "read the gauge, 60 to 0 kPa", "separates": ["soft", "soft+creep"]}
    names = NAMES | {"soft+creep": "soft and creep"}
    text = "".join(page._next(OPEN | {"next_test": told}, names))
    assert "<p>Read the gauge, 60 to 0 kPa. It tells apart: soft silicone, soft and creep.</p>" in text


@pytest.mark.parametrize(("settled", "told"), [([True, False], "wipe it"), ([True, True], None)])
def test_a_direct_measurement_that_was_made_is_not_asked_for_again(settled, told):
    effects = [{"settle": how, "settled": made}
               for how, made in zip(["read the tube", "wipe it"], settled, strict=True)]
    pair = OPEN | {"verdict": "pair", "effects": effects, "measure_directly": None}
    text = "".join(page._next(pair, NAMES))
    assert "read the tube" not in text
    assert ("To settle it without any model" in text) == (told is not None) and (told or "") in text


def test_a_test_can_be_the_direct_measurement():
    tests = [SimpleNamespace(observable=SimpleNamespace(quantity="chamber_pressure"))]
    scores = SimpleNamespace(present={"pressure_gain": 0.5, "creep": 0.9}.get)
    verdict = SimpleNamespace(word="ambiguous", effects=("pressure_gain", "creep"))
    found = SimpleNamespace(tests=tests, scores=scores, verdict=verdict)
    assert document._directly(found)["effect"] == "creep"
    found.tests = []
    assert document._directly(found)["effect"] == "pressure_gain"


def test_what_is_added_is_named_where_nothing_is_sure():
    gaps = {"before": 4.0, "retuned": 3.0, "patched": 1.0}
    tests = [{"title": "droop", "unit": "mm", "held_out": gaps}]
    open_ = OPEN | {"patch": ["soft"], "gap": {"unit": "mm", "tests": tests}}
    assert "With soft silicone added, “droop” is predicted within <b>1 mm" in page._verdict(open_, NAMES)
    named = open_ | {"verdict": "named", "effects": [{"sentence": "It is soft", "probability": 0.95}]}
    assert "With that added, “droop”" in page._verdict(named, NAMES)
