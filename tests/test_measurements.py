"""Measurements files: the source's tables as printed, their scatter, every error of a file at once."""

import math
from pathlib import Path

import pytest
import yaml

from handgen.errors import InputError
from handgen.measurements import load_measurements
from handgen.measurements.statistics import means, pooled_deviation

PARAMS = Path(__file__).parent.parent / "params"
COIMBRA = PARAMS / "measurements" / "coimbra_index.yaml"


@pytest.fixture(scope="module")
def coimbra():
    return load_measurements(COIMBRA)


def changed(folder: Path, change) -> list:
    """The problems of the shipped file after `change` of its data."""
    data = yaml.safe_load(COIMBRA.read_text(encoding="utf-8"))
    data["hand"] = str(PARAMS / "thesis_hand.yaml")
    change(data)
    file = folder / "measured.yaml"
    file.write_text(yaml.safe_dump(data), encoding="utf-8")
    with pytest.raises(InputError) as caught:
        load_measurements(file)
    return caught.value.problems


# The averages that the source prints below its repeats

PRINTED = {
    "exoskeleton-weights": {0.0: 45.3, 0.07: 64.5, 0.16: 74.5, 0.27: 79.8, 0.40: 82.0, 0.56: 84.5},
    "actuator-pressure": {20: 5.17, 40: 12.17, 50: 16.00, 60: 23.00},
    "assembly-pressure": {0: 39.50, 20: 60.67, 30: 68.50, 40: 74.67, 50: 79.50, 60: 81.67},
    "fingertip-force": {80: 0.81},
}


@pytest.mark.parametrize("name", PRINTED)
def test_repeats_average_to_what_the_source_prints(coimbra, name):
    test = coimbra.test(name)
    found = {load: mean for load, mean in zip(test.load.values, means(test), strict=True) if mean is not None}
    assert found == pytest.approx(PRINTED[name], abs=0.05)


@pytest.mark.parametrize(("name", "deviation"), [
    ("exoskeleton-weights", 1.42), ("actuator-pressure", 0.41), ("assembly-pressure", 0.54)])
def test_pooled_deviation_of_the_repeats(coimbra, name, deviation):
    assert pooled_deviation(coimbra.test(name)) == pytest.approx(deviation, abs=0.005)


def test_a_single_repeat_says_nothing_of_scatter(coimbra):
    assert pooled_deviation(coimbra.test("fingertip-force")) is None


def test_only_the_two_parts_alone_may_be_fitted_and_the_actuator_up_to_50_kpa(coimbra):
    fitted = {test.id: [load for load, may in zip(test.load.values, test.fitted, strict=True) if may]
              for test in coimbra.measurements.tests}
    assert fitted == {"exoskeleton-weights": [0.0, 0.07, 0.16, 0.27, 0.40, 0.56],
                      "actuator-pressure": [20, 40, 50], "assembly-pressure": [], "fingertip-force": []}


def test_numbers_of_the_source_s_simulation_follow_from_its_text(coimbra):
    """Table 5.4 less 6.5 mm, Table 5.6 less 17.6 %, Table 5.8 less 24.34 %."""
    measured = {t.id: dict(zip(t.load.values, means(t), strict=True)) for t in coimbra.measurements.tests}
    expected = {
        "exoskeleton-weights": [measured["exoskeleton-weights"][0.0] - 6.5],
        "actuator-pressure": [measured["actuator-pressure"][60] * (1 - 0.176)],
        "assembly-pressure": [measured["assembly-pressure"][40] * (1 - 0.2434)],
        "fingertip-force": [0.0, 0.176],
    }
    for test in coimbra.measurements.tests:
        assert [v for s in test.simulated for v in s.values] == pytest.approx(expected[test.id], abs=0.05)


def test_the_weighed_density(coimbra):
    (weighed,) = coimbra.measurements.weighed
    assert weighed.mass / weighed.volume == pytest.approx(0.827, abs=5e-4)


def test_missing_readings_are_left_out_of_means_and_scatter(tmp_path):
    data = yaml.safe_load(COIMBRA.read_text(encoding="utf-8"))
    data["hand"] = str(PARAMS / "thesis_hand.yaml")
    data["tests"][1]["repeats"] = [[1.0, None, 2.0, None], [3.0, 5.0, None, None]]
    file = tmp_path / "measured.yaml"
    file.write_text(yaml.safe_dump(data), encoding="utf-8")
    test = load_measurements(file).test("actuator-pressure")
    assert means(test) == [2.0, 5.0, 2.0, None]
    assert pooled_deviation(test) == pytest.approx(math.sqrt(2.0))


# Bad files


def test_every_error_is_reported_at_once(tmp_path):
    def change(data):
        tests = data["tests"]
        tests[0]["load"]["unit"] = "kPa"
        tests[0]["load"]["values"][2] = 0.05
        tests[1]["observable"] = {"quantity": "tip_force", "unit": "N"}
        tests[1]["obstacle"] = 3.0
        tests[1]["simulated"][0]["values"] = [1.0, 2.0]
        tests[2]["id"] = tests[1]["id"]
        tests[2]["repeats"][1].append(3.0)
        tests[3]["obstacle"] = None
        tests[3]["repeats"] = [[None] * 7]

    problems = changed(tmp_path, change)
    assert {p.path for p in problems} == {
        "tests[0].load.unit", "tests[0].load.values[2]", "tests[1].observable.quantity", "tests[1].obstacle",
        "tests[1].simulated[0].values", "tests[2].id", "tests[2].repeats[1]", "tests[3].obstacle",
        "tests[3].repeats"}
    assert all(p.message.startswith("line ") for p in problems)


@pytest.mark.parametrize(("change", "path"), [
    (lambda d: d.update(schema="handgen.measurements/2"), "schema"),
    (lambda d: d.update(finger="indx"), "finger"),
    (lambda d: d.update(hand="nowhere.yaml"), "hand"),
    (lambda d: d["tests"][0].update(repeat=[]), "tests[0].repeat"),
    (lambda d: d["tests"][0]["observable"].update(quantity="tip_drip"), "tests[0].observable.quantity"),
    (lambda d: d["tests"][0]["repeats"][0].__setitem__(0, "46"), "tests[0].repeats[0][0]"),
    (lambda d: d["tests"][0]["repeats"][0].__setitem__(0, 1e9), "tests[0].repeats[0][0]"),
    (lambda d: d["tests"][0].update(path="unloading"), "tests[0].load.values[1]"),
    (lambda d: d.update(tests=[]), "tests"),
])
def test_a_wrong_entry_is_named(tmp_path, change, path):
    assert path in {p.path for p in changed(tmp_path, change)}


def test_a_name_nearly_right_is_suggested(tmp_path):
    (problem,) = changed(tmp_path, lambda d: d.update(finger="indx"))
    assert problem.suggestion == "index"


def test_no_such_file(tmp_path):
    with pytest.raises(InputError):
        load_measurements(tmp_path / "none.yaml")
