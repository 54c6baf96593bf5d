"""`handgen bend` with the solid solver, on short bends: shapes measured by other means than its own."""

import json
import math

import numpy as np
import pytest
import pyvista

from handgen import cli
from handgen.checks.mesh_report import measure_stl
from handgen.geometry import finger, mesh_kernel
from handgen.geometry.actuator import profile_of
from tests.bend_case import ADULT_FILE


@pytest.fixture(scope="module")
def bent(tmp_path_factory):
    """Folders and JSON of bends with the real solver, each made once."""
    out, made = tmp_path_factory.mktemp("bends"), {}

    def make(*arguments):
        if arguments not in made:
            folder = out / str(len(made))
            assert cli.main(["bend", ADULT_FILE, *arguments, "--out", str(folder), "--quiet"]) == 0
            [folder] = (folder / "bend").iterdir()
            made[arguments] = folder, json.loads((folder / "bend.json").read_text())
        return made[arguments]

    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("HANDGEN_CACHE", str(out / "cache"))
        yield make


EXOSKELETON = ("--finger", "thumb", "--part", "exoskeleton", "--tip-loads", "0,0.1")
ACTUATOR = ("--part", "actuator", "--pressures", "0,30", "--orientation", "weightless")


def states(folder):
    """The shapes as ParaView shows them, by load."""
    series = pyvista.get_reader(str(folder / "states.pvd"))
    for value in series.time_values:
        series.set_active_time_value(value)
        yield value, series.read()[0]


def test_a_weight_bends_the_exoskeleton_down(bent):
    _, data = bent(*EXOSKELETON)
    light, heavy = data["points"]
    assert heavy["tip_drop_mm"] > light["tip_drop_mm"] + 5
    assert 0 < light["bend_angle_deg"] < heavy["bend_angle_deg"] < 90
    assert light["elongation_mm"] is light["tip_force_N"] is None
    assert all(point["residual"] < 1e-4 and point["max_stretch"] > 1 for point in data["points"])


def test_drop_is_read_from_the_shape(bent, adult):
    """The lowest node of the tip below the palm's plane, half a base_outer_diameter under the axis."""
    folder, data = bent(*EXOSKELETON)
    bore_end = adult.fingers.thumb.inner_length
    for (_, grid), point in zip(states(folder), data["points"], strict=True):
        tip = grid.warp_by_vector("displacement").points[grid.points[:, 0] > bore_end - 5]
        assert -tip[:, 2].min() - 10 == pytest.approx(point["tip_drop_mm"], abs=0.01)


@pytest.mark.parametrize("arguments", [EXOSKELETON, ACTUATOR])
def test_the_deformed_stl_is_sound(bent, arguments):
    report = measure_stl(str(bent(*arguments)[0] / "finger.stl"))
    assert report["passed"] and report["watertight"] and report["bodies"] == 1


def test_the_deformed_exoskeleton_holds_what_the_printed_one_does(bent, adult):
    """Against the CAD mesh: bending keeps the volume of a rubber."""
    report = measure_stl(str(bent(*EXOSKELETON)[0] / "finger.stl"))
    printed = mesh_kernel.evaluate(finger.shape(adult.fingers.thumb, adult.exoskeleton.joint_fillet))
    assert report["volume_mm3"] == pytest.approx(printed.volume(), rel=0.03)


def test_a_free_actuator_grows_along_its_axis(bent, adult):
    folder, data = bent(*ACTUATOR)
    start, end = data["points"]
    assert start["elongation_mm"] == pytest.approx(0, abs=1e-3) and end["elongation_mm"] > 3
    assert end["bend_angle_deg"] == pytest.approx(0, abs=0.1)
    length = profile_of(adult, "index").length
    (low, high), = [np.reshape(grid.warp_by_vector("displacement").bounds, (3, 2))[0]
                    for load, grid in states(folder) if load == 30]
    assert low == pytest.approx(0, abs=0.01) and high == pytest.approx(length + end["elongation_mm"], abs=0.2)


def test_the_silicone_keeps_its_volume(bent, adult):
    """As cast by the profile's revolution, and under pressure."""
    profile = profile_of(adult, "index")
    x = np.linspace(0, profile.length, 4001)
    wall = profile.outer(x) ** 2 - np.where(x < profile.small_core_end, profile.small_core(x), 0.0) ** 2
    cast = math.pi * float(np.trapezoid(wall, x))
    report = measure_stl(str(bent(*ACTUATOR)[0] / "finger.stl"))
    assert report["volume_mm3"] == pytest.approx(cast, rel=0.002)


def test_the_picture_and_the_plot_are_there(bent):
    for arguments in (EXOSKELETON, ACTUATOR):
        folder, _ = bent(*arguments)
        assert {"bend.json", "curve.csv", "curve.png", "curl.png", "finger.stl", "states.pvd", "states"} == {
            p.name for p in folder.iterdir()}
