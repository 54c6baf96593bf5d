"""Fits find what was planted, never look at what is held out, and the shipped files are what they give."""

import re
from pathlib import Path

import numpy as np
import pytest
import yaml

from handgen.bending import calibration, solve
from handgen.bending.comparison import asked, gap, readings
from handgen.bending.fitting import Assumption, Fit, Unknown, fit, spread
from handgen.bending.model import load_model
from handgen.errors import EngineError
from handgen.materials.states import UNIAXIAL, nominal_stress
from handgen.measurements import load_measurements
from handgen.parameters.load import load

PARAMS = Path(__file__).parent.parent / "params"
COIMBRA = PARAMS / "measurements" / "coimbra_index.yaml"
UNKNOWNS = (Unknown("height", "mm", 20.0, 0.0, 100.0, 4), Unknown("rate", "1/kPa", 0.03, 0.001, 1.0, 5))


def measurements(folder: Path, change=lambda tests: None):
    data = yaml.safe_load(COIMBRA.read_text(encoding="utf-8"))
    data["hand"] = str(PARAMS / "thesis_hand.yaml")
    change({test["id"]: test for test in data["tests"]})
    file = folder / "measured.yaml"
    file.write_text(yaml.safe_dump(data), encoding="utf-8")
    return file


def saturating(loads):
    """A stand-in for a solver: height (1 - exp(-rate load)), all of it `higher`."""
    def simulate(values, higher=0.0):
        return [float(values["height"] * -np.expm1(-values["rate"] * load) + higher) for load in loads]
    return simulate


# Fits


TRUTH = {"height": 30.0, "rate": 0.02}


@pytest.fixture
def planted(tmp_path):
    """The actuator's test with readings of TRUTH +- 0.3 mm, and nonsense where nothing may be fitted."""
    readings = [*saturating([20, 40, 50])(TRUTH), 99.0]

    def change(tests):
        tests["actuator-pressure"]["repeats"] = [[v + d for v in readings] for d in (-0.3, 0.0, 0.3)]

    return load_measurements(measurements(tmp_path, change)).test("actuator-pressure")


def test_a_fit_finds_what_was_planted_and_leaves_out_what_may_not_be_fitted(planted):
    simulate = saturating(planted.load.values)
    found = fit(planted, UNKNOWNS, simulate)
    assert found.values == pytest.approx(TRUTH, rel=2e-3)
    assert found.gap.count == 3
    assert found.gap.rms < 5e-3

    # Linear regression about the truth: variance of a mean of three with deviation 0.3
    step = 1e-6
    slopes = np.array([(np.array(simulate({**TRUTH, name: value + step})) - simulate(TRUTH))[:3] / step
                       for name, value in TRUTH.items()]).T
    expected = 0.3 / np.sqrt(3) * np.sqrt(np.diag(np.linalg.inv(slopes.T @ slopes)))
    assert list(found.deviations.values()) == pytest.approx(expected, rel=0.05)


def test_an_assumption_shifts_the_fit_and_widens_the_range(planted):
    simulate = saturating(planted.load.values)
    found = fit(planted, UNKNOWNS, simulate)
    other = fit(planted, UNKNOWNS, simulate, found.values, higher=3.0)
    assert other.values["height"] != pytest.approx(found.values["height"], rel=0.05)
    low, high = spread("height", found, [Assumption("higher", other)])
    assert low <= min(found.values["height"] - 2 * found.deviations["height"], other.values["height"])
    assert high >= max(found.values["height"] + 2 * found.deviations["height"], other.values["height"])


def test_a_solver_that_gives_up_ends_the_fit(planted):
    with pytest.raises(EngineError, match="no balance"):
        fit(planted, UNKNOWNS, lambda values: [1.0, None, 1.0, 1.0])


def test_a_fit_that_runs_to_a_limit_is_none(planted):
    low = (Unknown("height", "mm", 15.0, 0.0, 20.0, 4), UNKNOWNS[1])
    with pytest.raises(EngineError, match="runs to the limit of height"):
        fit(planted, low, saturating(planted.load.values))


def test_held_out_readings_change_nothing(tmp_path, monkeypatch):
    """Table 5.8, the force and the actuator at 60 kPa may read anything."""
    def simulator(measured, test, change):
        if change is calibration.with_silicone:
            return lambda values, **other: [0.45 * load / values["alpha"] for load in test.load.values]
        return lambda values, **other: [
            values["rest_angle"] - 0.5 * values["palmar_arc"] * np.expm1(-100 * load / values["position"])
            for load in test.load.values]

    monkeypatch.setattr(calibration, "simulator", simulator)

    def spoil(tests):
        tests["assembly-pressure"]["repeats"] = [[0.0, 1.0, 2.0, 3.0, 4.0, 5.0]]
        tests["fingertip-force"]["repeats"] = [[9.0] * 7]
        for row in tests["actuator-pressure"]["repeats"]:
            row[-1] = 1.0

    honest = calibration.calibrate(measurements(tmp_path))
    spoilt = calibration.calibrate(measurements(tmp_path, spoil))
    assert calibration.model_text(spoilt) == calibration.model_text(honest)
    assert calibration.joints_text(spoilt) == calibration.joints_text(honest)


# What is shipped


@pytest.mark.parametrize("alpha", [1.05, 1.42, 2.0])
def test_the_silicone_meets_the_bulletin_whatever_its_exponent(alpha):
    """12 psi at 100 % strain."""
    law = calibration.silicone_law(alpha)
    assert float(nominal_stress(law, UNIAXIAL, np.array(2.0))) == pytest.approx(12 * 6894.757e-6, rel=2e-3)


@pytest.mark.parametrize(("name", "unit", "bar"), [
    ("exoskeleton-weights", "mm on Table 5.4", 1.5), ("actuator-pressure", "% on Table 5.6", 8.0)])
def test_the_calibrated_model_is_as_close_as_its_file_says(name, unit, bar):
    measured = load_measurements(COIMBRA)
    test = measured.test(name)
    curve = solve(asked(measured, test, "calibrated")).curve
    found = gap(test, readings(test, curve), fitted=True)
    value = found.rms if unit.startswith("mm") else 100 * found.rms_relative
    stated = float(re.search(rf"RMS ([\d.]+) {unit}", calibration.FILE.read_text(encoding="utf-8")).group(1))
    assert value == pytest.approx(stated, abs=0.1)
    assert value <= bar


def test_the_calibrated_model_says_what_it_was_fitted_on():
    measured = load_measurements(COIMBRA)
    model, _ = load_model("calibrated")
    assert set(model.fitted) == {t.id for t in measured.measurements.tests if not t.held_out}


def test_other_materials_and_friction_are_the_literature_s():
    calibrated, literature = load_model("calibrated")[0], load_model("literature")[0]
    for name in ("Filaflex 82A", "Ecoflex 00-30", "Dragon Skin 30"):
        assert calibrated.materials[name] == literature.materials[name]
    assert calibrated.friction == literature.friction
    assert calibrated.held_length == literature.held_length


@pytest.mark.slow
def test_the_script_gives_the_shipped_files_again():
    found = calibration.calibrate()
    assert calibration.model_text(found) == calibration.FILE.read_text(encoding="utf-8")
    base, *others = load(PARAMS / "thesis_hand.yaml").hand.fingers.index.joints
    values = found.joints.values
    assert (base.position, base.rest_angle) == (values["position"], values["rest_angle"])
    assert {joint.palmar_arc for joint in (base, *others)} == {values["palmar_arc"]}
    assert {joint.rest_angle for joint in others} == {0.0}
    assert isinstance(found.silicone, Fit)
