"""The hexahedra of actuator and exoskeleton."""

import copy

import numpy as np
import pytest
from scipy.integrate import quad

from handgen.bending import request
from handgen.simulation import shapes
from handgen.simulation.exoskeleton import exoskeleton_mesh
from handgen.simulation.mesh import actuator_mesh
from tests.strategies import ADULT, write


def test_a_closed_tip_that_tapers_below_the_chambers_radius_is_meshed_right_side_out(tmp_path):
    """The chamber of a thin wall is wider than the thread at the tip, where there is none any more."""
    data = copy.deepcopy(ADULT)
    data["fingers"]["index"] |= {"taper": [[0, 0], [0.8, 0.2], [1, 1]], "tip_bore_diameter": 8}
    data["actuators"]["index"]["tip_outer_diameter"] = 7.5
    data["layers"] = {"external": 0.8, "thread": 0.3, "internal": 0.5, "tip": 6}
    case = request(write(data, tmp_path), part="actuator", finger="index").case
    profile = case.actuator
    tip = np.linspace(profile.small_core_end, profile.length, 9)
    assert profile.large_core(tip[-1]) < profile.small_core(profile.small_core_end)
    mesh = actuator_mesh(profile, case.winding, case.held, 0)
    _, volume = shapes.gradients(mesh.grid.nodes, mesh.grid.cells)
    assert volume.min() > 0
    solid = quad(lambda x: profile.outer(x) ** 2, 0, profile.length, limit=200)[0]
    hollow = quad(lambda x: profile.small_core(x) ** 2, 0, profile.small_core_end, limit=200)[0]
    assert volume.sum() == pytest.approx(np.pi / 2 * (solid - hollow), rel=0.01)


@pytest.mark.parametrize("ring", [1.0, 1.01, 1.2, 1.5, 3.0])
def test_a_bone_as_short_as_its_rigid_part_has_no_slivers(ring, tmp_path):
    """A quarter of the ring before the first slot deforms at least, in two elements of three nodes each."""
    data = copy.deepcopy(ADULT)
    joint = data["fingers"]["index"]["joints"][0]
    joint["position"] = ring + joint["slot_length"] / 2
    case = request(write(data, tmp_path), part="exoskeleton", finger="index").case
    mesh = exoskeleton_mesh(case.finger, case.fillet, 0)
    x = np.unique(mesh.straight[:, 0].round(9))
    assert np.diff(x[x <= ring]).min() >= ring / 16 - 1e-9
