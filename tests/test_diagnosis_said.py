"""What an undecided diagnosis says to people: classes that read the same, and what would settle it."""

from handgen import tables
from handgen.discrepancy import page

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
    assert "soft silicone is settled so: pull a strip &lt;of it&gt;." in "".join(page._next(OPEN))
    text = tables.diagnosed(OPEN, "out", lambda words, colour: words)
    assert "settle soft silicone without any model: pull a strip <of it>" in text
    assert "soft or creep or soft+creep or worn or 1 more: no reading here tells them apart" in text
