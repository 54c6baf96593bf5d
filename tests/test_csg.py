"""Both kernels against closed forms, and against each other."""

import math

import numpy as np
import pytest

from handgen.geometry import brep_kernel, csg, mesh_kernel

CUBE = csg.box((0, 0, 0), (2, 3, 4))
TORUS_RADIUS, PIPE_RADIUS = 10.0, 2.0


def circle(u, v, r):
    path = csg.Path((u + r, v), ())
    for corner, end in (((u + r, v + r), (u, v + r)), ((u - r, v + r), (u - r, v)),
                        ((u - r, v - r), (u, v - r)), ((u + r, v - r), (u + r, v))):
        path = path.quarter(corner, end)
    return path


SECTION = tuple(
    csg.Section(csg.Path.polygon([(-w, -w), (w, -w), (w, w), (-w, w)]),
                ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)), (0.0, 0.0, z))
    for w, z in ((2.0, 0.0), (1.0, 6.0)))
SHAPES = {
    "box": (CUBE, 24.0),
    "cylinder": (csg.cylinder(5, 1, 9), math.pi * 25 * 8),
    "cone": (csg.cone(4, 1, 0, 6), math.pi * 6 / 3 * (16 + 4 + 1)),
    "torus": (csg.Revolve(circle(0, TORUS_RADIUS, PIPE_RADIUS)),
              2 * math.pi**2 * TORUS_RADIUS * PIPE_RADIUS**2),
    "frustum": (csg.Loft(SECTION), 6 / 3 * (16 + 8 + 4)),
    "hollow": (csg.cylinder(5, 0, 9) - csg.cylinder(4, -1, 10), math.pi * 9 * 9),
    "corner": (CUBE & CUBE.moved(x=1, y=1, z=1), 1 * 2 * 3),
    "both": (CUBE + CUBE.moved(x=1, y=1, z=1), 2 * 24 - 6),
    "turned": (CUBE.turned("z", 30).turned("x", 50).moved(7, 8, 9), 24.0),
    "mirrored": (CUBE.mirrored("y"), 24.0),
}


@pytest.mark.parametrize("name", SHAPES)
def test_volume_is_the_closed_form_in_both_kernels(name):
    shape, exact = SHAPES[name]
    assert mesh_kernel.evaluate(shape).volume() == pytest.approx(exact, rel=4e-3)
    # A quarter circle as one cubic is 0.03 % wide at worst.
    assert brep_kernel.evaluate(shape).Volume() == pytest.approx(exact, rel=6e-4)


@pytest.mark.parametrize("shape, low, high", [
    (csg.cylinder(5, 1, 9), (1, -5, -5), (9, 5, 5)),
    (csg.Extrude(csg.Path.polygon([(1, 2), (4, 2), (4, 3)]), 5), (1, 2, 0), (4, 3, 5)),
    (CUBE.turned("y", -90), (-4, 0, 0), (0, 3, 2)),
    (CUBE.mirrored("z").moved(x=1), (1, 0, -4), (3, 3, 0)),
])
def test_both_kernels_put_a_shape_in_the_same_place(shape, low, high):
    assert mesh_kernel.evaluate(shape).bounding_box() == pytest.approx((*low, *high), abs=1e-5)
    box = brep_kernel.evaluate(shape).BoundingBox()
    assert (box.xmin, box.ymin, box.zmin) == pytest.approx(low, abs=1e-5)
    assert (box.xmax, box.ymax, box.zmax) == pytest.approx(high, abs=1e-5)


def test_chords_stay_within_their_tolerance():
    mesh = mesh_kernel.printable(mesh_kernel.evaluate(csg.cylinder(10, 0, 5)))
    (rim,) = mesh.section(plane_origin=(2.5, 0, 0), plane_normal=(1, 0, 0)).discrete
    middles = (rim[1:] + rim[:-1]) / 2
    assert 10 - np.hypot(middles[:, 1], middles[:, 2]).min() < mesh_kernel.CHORD + 1e-4


def test_lettering_is_the_same_in_both_kernels_and_has_its_counters():
    label = csg.Text("Ia8", 6.0, 0.6)
    volume = mesh_kernel.evaluate(label).volume()
    assert volume == pytest.approx(brep_kernel.evaluate(label).Volume(), rel=1e-6)
    x0, y0, _, x1, y1, height = mesh_kernel.evaluate(label).bounding_box()
    assert y1 - y0 == pytest.approx(6.0, abs=0.3) and height == pytest.approx(0.6)
    assert volume < 0.6 * (x1 - x0) * (y1 - y0) * 0.6


def test_key_names_the_geometry():
    same = csg.box((0, 0, 0), (2, 3, 4))
    assert same.key == CUBE.key
    assert csg.box((0, 0, 0), (2, 3, 4.0001)).key != CUBE.key
    assert csg.Union((CUBE,)).key != csg.Intersection((CUBE,)).key


def test_a_reflection_is_no_placement():
    with pytest.raises(ValueError, match="not a rotation"):
        CUBE.placed(((1, 0, 0), (0, 1, 0), (0, 0, -1)), (0, 0, 0))


def test_what_is_no_single_solid_is_refused():
    apart = CUBE + CUBE.moved(x=10)
    with pytest.raises(ValueError, match="2 bodies"):
        mesh_kernel.printable(mesh_kernel.evaluate(apart))
    with pytest.raises(ValueError, match="empty"):
        mesh_kernel.printable(mesh_kernel.evaluate(CUBE & CUBE.moved(x=10)))
    with pytest.raises(ValueError, match="below 0"):
        mesh_kernel.evaluate(csg.Revolve(csg.Path.polygon([(0, -1), (1, 1), (0, 1)])))
