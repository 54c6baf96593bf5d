"""Any valid parameter file builds every part as a closed solid, or is refused by name."""

import random

import pytest
from hypothesis import Phase, given, settings

from handgen.errors import GeometryError
from handgen.export import stl
from handgen.geometry import measure
from handgen.geometry.catalogue import catalogue
from handgen.parameters.load import load
from tests import strategies

IN_STEP = 3
"""Parts of a file whose B-rep is made too: it takes a hundred times as long as the mesh."""


def build_parts(data, folder):
    """Make every part but the hand itself; their number, or why the hand is refused by name."""
    hand = load(strategies.write(data, folder)).hand
    try:
        parts = [p for n, p in catalogue(hand).items() if n != "exoskeleton/hand"]
        facts = [measure.measure(measure.read_stl(stl.to_bytes(part.mesh))) for part in parts]
    except GeometryError as error:
        assert error.path.split(".")[0] in type(hand).model_fields, error
        return f"{error.path}: {error.message}"
    for part, fact in zip(parts, facts, strict=True):
        assert fact.faults() == [], part.name
    for i in random.Random(repr(data)).sample(range(len(parts)), IN_STEP):
        assert facts[i].volume_mm3 == pytest.approx(parts[i].solid.Volume(), rel=5e-3), parts[i].name
    return len(parts)


def study(folder, count):
    """Share of `count` random files that could be built."""
    built = []

    @settings(max_examples=count, phases=[Phase.generate])  # shrinking a hand takes minutes
    @given(strategies.files(fingers_only=True))
    def every_file(data):
        built.append(build_parts(data, folder))

    every_file()
    assert len(built) == count
    refused = [why for why in built if isinstance(why, str)]
    made = sum(n for n in built if isinstance(n, int))
    print(f"{count - len(refused)} of {count} files built, {made} parts; refused: {len(refused)}", *refused,
          sep="\n  ")
    return 1 - len(refused) / count


def test_ten_random_hands(tmp_path):
    assert study(tmp_path, 10) >= 0.5


@pytest.mark.slow
def test_two_hundred_random_hands(tmp_path):
    assert study(tmp_path, 200) >= 0.8
