"""Everything in its place: nothing in the assembled hand overlaps, and everything is inside."""

import itertools

import numpy as np
import pytest
from manifold3d import Manifold, Mesh

from handgen.geometry.assembly import assembly
from handgen.parameters.load import load
from tests.conftest import PARAMS

OVERLAP = 1.0
"""Largest volume, mm3, that two parts may share."""
SHIPPED = ("adult", "thesis_hand")


def solid(vertices, faces) -> Manifold:
    return Manifold(Mesh(np.array(vertices, np.float32), np.array(faces, np.uint32)))


@pytest.fixture(scope="module", params=SHIPPED)
def seated(request):
    return {s.name: s for s in assembly(load(PARAMS / f"{request.param}.yaml").hand)}


@pytest.fixture(scope="module")
def bodies(seated):
    return {name: solid(s.mesh.vertices, s.mesh.faces) for name, s in seated.items()}


def test_all_parts_are_there(seated):
    actuators = [n for n in seated if n.startswith("actuators/")]
    assert len(actuators) == 7 and len(seated) == 1 + 3 * 7
    assert next(iter(seated)) == "exoskeleton/hand"


def test_nothing_overlaps(bodies):
    for a, b in itertools.combinations(bodies, 2):
        assert (bodies[a] ^ bodies[b]).volume() < OVERLAP, (a, b)


def test_silicone_yields_to_its_own_plug_only(seated):
    """As made, the plug is larger than its channel, or it would not seal; nothing else takes silicone."""
    for name, s in seated.items():
        if name.startswith("actuators/"):
            plug = seated[f"tooling/{name.split('/')[1]}/plug"].part
            made, tight = (solid(p.mesh.vertices, p.mesh.faces) for p in (s.part, plug))
            left = solid(s.installed.mesh.vertices, s.installed.mesh.faces)
            assert (made ^ tight).volume() > 5.0
            assert made.volume() - left.volume() == pytest.approx((made ^ tight).volume(), rel=1e-2)
            assert (left - made).volume() < 0.1 * OVERLAP
        else:
            assert s.installed is s.part


def test_seals_lie_in_the_palm_and_tips_in_their_ends(seated, bodies):
    """Each actuator is enclosed: the hand's convex hull, filled, leaves none of it outside."""
    hull = bodies["exoskeleton/hand"].hull()
    for name, body in bodies.items():
        assert (body - hull).volume() < OVERLAP, name


def test_opposition_actuators_are_held_at_their_ends_and_free_between(seated, bodies):
    """No roof and no wall within 4 mm of their backs; beneath them the sheet, at the sockets' clearance."""
    hand = bodies["exoskeleton/hand"]
    for name in ("actuators/opposition_1", "actuators/opposition_2"):
        frame = np.c_[np.array(seated[name].rotation), seated[name].origin]
        length = seated[name].part.mesh.bounds[1, 0]

        def stretch(start, end, low, frame=frame):
            return Manifold.cube((end - start, 20, 10)).translate((start, -10, low)).transform(frame)

        near = hand ^ Manifold.cube((length + 16, 32, 32)).translate((-8, -16, -16)).transform(frame)
        middle = length / 2
        back = bodies[name] ^ stretch(middle - 6, middle + 6, 0.5)
        belly = bodies[name] ^ stretch(middle - 6, middle + 6, -9.5)
        assert back.min_gap(near, 20.0) >= 4.0
        assert 0.1 <= belly.min_gap(near, 20.0) <= 1.0
        for end in (bodies[name] ^ stretch(0, 5, -5), bodies[name] ^ stretch(length - 5, length, -5)):
            assert end.min_gap(near, 20.0) <= 0.3


def test_left_hand_is_assembled_in_the_mirror():
    hand = load(PARAMS / "adult.yaml").hand
    right = assembly(hand)
    left = assembly(hand.model_copy(update={"side": "left"}))
    for r, m in zip(right[1:4], left[1:4], strict=True):
        assert r.name == m.name
        assert np.allclose(m.mesh.bounds[:, 0], r.mesh.bounds[:, 0])
        assert np.allclose(m.mesh.bounds[::-1, 1], -r.mesh.bounds[:, 1])
        assert m.mesh.volume == pytest.approx(r.mesh.volume) and m.mesh.volume > 0


def test_bent_actuator_keeps_its_volume(seated):
    for name, s in seated.items():
        if s.axis and name.startswith("actuators/"):
            assert s.mesh.volume == pytest.approx(s.installed.mesh.volume, rel=2e-3)
            assert s.mesh.is_watertight
