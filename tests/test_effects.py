"""The catalogue of effects: what each states, what switches it off, model files, packages of others."""

import json
import math
from importlib.metadata import EntryPoint

import pytest
import yaml

from handgen import cli, effects
from handgen.bending import model, solve
from handgen.bending.comparison import asked, direct, readings
from handgen.bending.model import load_model
from handgen.bending.request import request
from handgen.discrepancy.candidates import candidates
from handgen.effects import Effect, Parameter, Prior, registry
from handgen.errors import EngineError, InputError
from handgen.measurements import load_measurements
from handgen.measurements.model import DIRECT
from tests.bend_case import ADULT_FILE, model_file
from tests.strategies import PARAMS

CATALOGUE = effects.catalogue()
COIMBRA = PARAMS / "measurements" / "coimbra_index.yaml"
CONTRACT = {
    "own_weight", "rest_curl", "print_porosity", "silicone_softening", "wrong_convention",
    "uniaxial_only_law", "bore_clearance", "pressure_offset", "pressure_gain", "bore_friction",
    "base_compliance", "thread_spacing", "asymmetric_winding", "mullins", "creep", "self_contact",
    "scale_error", "contact_angle"}


@pytest.fixture(scope="module")
def coimbra():
    return load_measurements(COIMBRA)


def switched(name: str, base: str = "calibrated", **parameters):
    """The model `base` with one effect on."""
    return load_model(base)[0].model_copy(
        update={"effects": [model.Effect(id=name, parameters=parameters)]})


def test_the_catalogue_is_the_contract_s():
    assert set(CATALOGUE) == CONTRACT


@pytest.mark.parametrize("effect", CATALOGUE.values(), ids=list(CATALOGUE))
def test_an_effect_states_what_a_lab_must_know(effect):
    assert all(len(text) > 15 for text in (effect.sentence, effect.signature, effect.source, effect.settle))
    assert (effect.parameters and effect.said({}) != effect.sentence) or "{" not in effect.sentence
    for one in effect.parameters:
        assert one.low <= one.null <= one.high and one.allowed(one.null)
        assert one.usual is None or (one.allowed(one.usual) and one.usual != one.null)
        grid = one.grid(5)
        assert all(one.allowed(value) for value in grid) and list(grid) == sorted(grid)
        if not one.switch:
            width = (one.high - one.low) / 4000
            total = sum(one.density(one.low + (i + 0.5) * width) * width for i in range(4000))
            assert total == pytest.approx(1.0, abs=1e-3)
            assert one.prior.kind != "uniform"


@pytest.mark.parametrize("name", CATALOGUE)
def test_at_null_nothing_changes(name, coimbra):
    null = {one.name: one.null for one in CATALOGUE[name].parameters}
    assert CATALOGUE[name].null(null)
    for test in coimbra.measurements.tests:
        for base in ("calibrated", "thesis"):
            plain, with_it = (asked(coimbra, test, one) for one in (base, switched(name, base, **null)))
            assert with_it.case == plain.case
            assert with_it.gauge == plain.gauge


SILICONE = {"exoskeleton-weights"}
PRINT = {"actuator-pressure"}
SINGLE = SILICONE | PRINT
ALL = SINGLE | {"assembly-pressure", "fingertip-force"}
UNTOUCHED = {
    "own_weight": SINGLE, "rest_curl": PRINT, "print_porosity": PRINT, "silicone_softening": SILICONE,
    "wrong_convention": SILICONE, "uniaxial_only_law": SILICONE, "bore_clearance": SINGLE,
    "pressure_offset": SILICONE, "pressure_gain": SILICONE, "bore_friction": SINGLE, "base_compliance": PRINT,
    "thread_spacing": SILICONE, "asymmetric_winding": SILICONE, "mullins": SILICONE | {"fingertip-force"},
    "creep": SILICONE, "self_contact": PRINT, "scale_error": ALL, "contact_angle": ALL,
}
"""The fingertip's force was taken once: an actuator's first run knows no Mullins effect."""


@pytest.mark.parametrize("name", CATALOGUE)
def test_cases_change_where_the_signature_says_so(name, coimbra):
    """Seen from the source's own choices, with the effect off its null value."""
    value = {one.name: one.quantile(0.8) for one in CATALOGUE[name].parameters}
    for test in coimbra.measurements.tests:
        plain, with_it = (asked(coimbra, test, wanted)
                          for wanted in ("thesis", switched(name, "thesis", **value)))
        assert (with_it.case == plain.case) == (test.id in UNTOUCHED[name]), test.id


def test_own_weight_comes_back_where_the_model_leaves_it_out(coimbra):
    test = coimbra.test("assembly-pressure")
    gravity = {name: asked(coimbra, test, wanted).case.gravity[2] for name, wanted in {
        "left out": "thesis", "back": switched("own_weight", "thesis", share=1.0),
        "full": "calibrated"}.items()}
    assert gravity["left out"] == 0.0 and gravity["back"] == gravity["full"] < -9000.0
    assert asked(coimbra, coimbra.test("exoskeleton-weights"), "thesis").case.gravity[2] == gravity["full"]
    assert asked(coimbra, test, switched("own_weight", share=0.7)).case.gravity[2] == gravity["full"]


def test_a_law_known_from_uniaxial_tension_keeps_that_and_is_stiffer_in_planar_tension(coimbra):
    import numpy as np

    from handgen.materials.stability import failures
    from handgen.materials.states import PLANAR, UNIAXIAL, nominal_stress

    test = coimbra.test("actuator-pressure")
    for base in ("calibrated", "literature", "thesis"):
        plain, other = (asked(coimbra, test, wanted).case.silicone.law
                        for wanted in (base, switched("uniaxial_only_law", base, share=0.3)))
        kept = float(nominal_stress(plain, UNIAXIAL, 2.0))
        assert nominal_stress(other, UNIAXIAL, 2.0) == pytest.approx(kept)
        stretches = np.linspace(1.2, 2.4, 7)
        ratio = nominal_stress(other, PLANAR, stretches) / nominal_stress(plain, PLANAR, stretches)
        assert (ratio > 1.1).all() and (np.diff(ratio) > -1e-9).all()
        assert not failures(other, 1.5)


def test_the_wrong_convention_is_the_right_one_s_other(coimbra):
    test = coimbra.test("actuator-pressure")
    plain, other = (asked(coimbra, test, wanted) for wanted in (
        "thesis", switched("wrong_convention", "thesis", misread=1.0)))
    mu, alpha = plain.case.silicone.law.constants
    assert other.case.silicone.law.constants[0] == pytest.approx(
        [2 * m / a for m, a in zip(mu, alpha, strict=True)])
    assert "2mu/alpha^2" in other.choices["actuator"].name


# What the chamber sees and what is read, with a solver that answers at once


def read(coimbra, name, wanted):
    test = coimbra.test(name)
    found = asked(coimbra, test, wanted)
    from dataclasses import replace

    return readings(test, solve(replace(found, solver="stub")).curve)


def test_the_chamber_sees_another_pressure_than_the_gauge(coimbra, stub):
    """The stub's finger drops by 1 mm per kPa in its chamber."""
    loads = coimbra.test("assembly-pressure").load.values
    assert read(coimbra, "assembly-pressure", switched("pressure_offset", offset=4.0)) == pytest.approx(
        [load + 4.0 for load in loads])
    assert read(coimbra, "assembly-pressure", switched("pressure_offset", offset=-4.0)) == pytest.approx(
        [max(0.0, load - 4.0) for load in loads])
    assert read(coimbra, "assembly-pressure", switched("pressure_gain", factor=0.9)) == pytest.approx(
        [0.9 * load for load in loads])


def test_lengths_and_forces_are_read_as_scale_and_balance_show_them(coimbra, stub, monkeypatch):
    loads = coimbra.test("assembly-pressure").load.values
    assert read(coimbra, "assembly-pressure", switched("scale_error", factor=1.1)) == pytest.approx(
        [1.1 * load for load in loads])
    assert read(coimbra, "assembly-pressure", switched("contact_angle", angle=60.0)) == pytest.approx(loads)
    angle, force = CATALOGUE["contact_angle"], [0.0, None, 0.8]
    assert angle.on_reading("tip_force", [0, 1, 2], force, {"angle": 60.0}) == [0.0, None, pytest.approx(0.4)]
    assert CATALOGUE["scale_error"].on_reading("bend_angle", [0.0], [30.0], {"factor": 1.1}) == [30.0]


def test_instruments_show_what_an_effect_does_without_a_bend(coimbra):
    """A manometer at the inlet, and the direction of the fingertip's force on a photograph."""
    found = {test.observable.quantity: test for test in candidates(coimbra.measurements.tests) if test.direct}
    assert set(found) == set(DIRECT)
    manometer, photograph = found["chamber_pressure"], found["force_angle"]
    loads = manometer.load.values

    def shown(test, name, **parameters):
        return direct(test, asked(coimbra, test, switched(name, **parameters)))

    assert shown(manometer, "contact_angle", angle=30.0) == pytest.approx(loads)
    assert shown(manometer, "pressure_offset", offset=-4.0) == pytest.approx([p - 4 for p in loads])
    assert shown(manometer, "pressure_gain", factor=0.9) == pytest.approx([0.9 * p for p in loads])
    assert shown(photograph, "pressure_offset", offset=-4.0) == [0.0] * len(photograph.load.values)
    assert shown(photograph, "contact_angle", angle=35.0) == [35.0] * len(photograph.load.values)


def test_a_stop_and_a_fold_are_told_by_the_gauge(stub, monkeypatch):
    monkeypatch.setenv("STUB_STOPS_AT", "45")
    found = solve(request(ADULT_FILE, model=switched("pressure_gain", factor=0.8), solver="stub"))
    assert found.reached.startswith("reached 50 kPa")
    assert [p["pressure_kPa"] for p in found.document["points"]] == list(range(0, 101, 10))
    assert found.document["notes"] == ["The chamber sees 0.800 times the pressure that the gauge says"]


# Paths


def test_tests_are_asked_along_their_path(coimbra, stub):
    test = coimbra.test("assembly-pressure")
    for path, values in (("unloading", [60, 40, 0]), ("cycle", [0, 40, 60, 40, 0]), ("hold", [40, 40, 40])):
        one = test.model_copy(update={"path": path, "load": test.load.model_copy(update={"values": values})})
        case = asked(coimbra, one, "calibrated").case
        assert case.pressures == pytest.approx([1e-3 * v for v in values])
    with pytest.raises(InputError, match="does not fall"):
        asked(coimbra, test.model_copy(update={"path": "unloading"}), "calibrated")


# Model files


def test_a_model_file_says_its_effects_and_comes_back_the_same(tmp_path):
    stated = [{"id": "pressure_gain", "parameters": {"factor": 0.9}}, {"id": "bore_clearance"}]
    found = load_model(model_file(tmp_path, effects=stated))[0]
    assert [(one.effect.id, one.parameters) for one in found.switched] == [
        ("pressure_gain", {"factor": 0.9}), ("bore_clearance", {"gap": pytest.approx(0.28, abs=0.02)})]
    again = yaml.safe_load(yaml.safe_dump(found.model_dump(mode="json")["effects"]))
    assert load_model(model_file(tmp_path, effects=again))[0].effects == found.effects
    known = [{**stated[0], "intervals": {"factor": [0.86, 0.93]}}, stated[1]]
    assert load_model(model_file(tmp_path, effects=known))[0].effects[0].intervals == {"factor": [0.86, 0.93]}


def test_everything_wrong_with_effects_is_said_at_once(tmp_path):
    wrong = [{"id": "own_wieght"}, {"id": "pressure_gain", "parameters": {"factr": 1.0, "factor": 3.0}},
             {"id": "wrong_convention", "parameters": {"misread": 0.5}}, {"id": "creeep"},
             {"id": "scale_error", "parameters": {"factor": 1.1}},
             {"id": "scale_error", "intervals": {"factor": [0.9, 1.1]}}]
    with pytest.raises(InputError) as caught:
        load_model(model_file(tmp_path, effects=wrong))
    found = {p.path: p for p in caught.value.problems}
    assert found["effects[0].id"].suggestion == "own_weight"
    assert found["effects[1].parameters.factr"].suggestion == "factor"
    assert found["effects[1].parameters.factor"].allowed == "0.75 to 1.25"
    assert found["effects[2].parameters.misread"].allowed == "0 or 1"
    assert "twice" in found["effects[5].id"].message
    assert set(found) >= {"effects[3].id", "effects[5].intervals.factor", "effects[5].parameters.factor"}
    assert "no usual one" in found["effects[5].parameters.factor"].message


def test_a_curl_that_no_strip_can_be_printed_with_is_refused(tmp_path):
    hand = load_measurements(COIMBRA).hand
    model_with = switched("rest_curl", angle=45.0)
    first = request(hand, model=model_with).case.finger.finger.joints[0]
    assert first.rest_angle == pytest.approx(26.7 + 15.0)
    with pytest.raises(InputError, match="bends the strip of MCP into itself"):
        request(hand, finger="thumb", model=model_with)


def test_the_section_model_knows_no_effects():
    with pytest.raises(InputError, match="knows no effects"):
        request(ADULT_FILE, part="opposition", model=switched("own_weight"))


def test_the_reference_solver_does_not_know_what_only_the_solid_model_has():
    for name in ("creep", "self_contact", "base_compliance", "bore_clearance", "thread_spacing"):
        with pytest.raises(InputError, match="does not know"):
            request(ADULT_FILE, solver="reference", model=switched(name))
    assert request(ADULT_FILE, solver="reference", model=switched("silicone_softening")).case.silicone


def test_a_hand_that_an_effect_makes_impossible_is_refused(monkeypatch):
    curl = CATALOGUE["rest_curl"]
    monkeypatch.setattr(type(curl), "on_hand", lambda self, hand, p: hand.model_copy(update={
        "thread": hand.thread.model_copy(update={"pitch": -1.0})}))
    with pytest.raises(InputError, match=r"thread\.pitch"):
        request(ADULT_FILE, model=switched("rest_curl"))


# The command, and effects of other packages


def test_the_command_lists_them(capsys):
    assert cli.main(["effects", "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["schema"] == "handgen.effects/1"
    assert [one["id"] for one in document["effects"]] == list(CATALOGUE)
    assert cli.main(["effects"]) == 0
    table = capsys.readouterr().err
    assert all(name in table for name in CATALOGUE)


class Sticky(Effect):
    """A lab's own: the plane on which the hand lies is lower by so much."""

    id, name = "sagging_table", "sagging table"
    sentence = "The table sags by {sag:.1f} mm under the hand"
    signature = source = settle = "all drops by the same amount"
    parameters = (Parameter("sag", "mm", 0.0, 5.0, 0.0, Prior("normal", (1.0, 1.0)), "of the table"),)

    def on_reading(self, quantity, loads, values, p):
        return [None if v is None else v + p["sag"] for v in values] if quantity == "tip_drop" else values


STICKY = Sticky()


def hang_in(monkeypatch, value: str, name: str = "sagging_table"):
    monkeypatch.setattr(registry, "entry_points", lambda group: [EntryPoint(name, value, group)])


def test_an_effect_of_another_package_takes_part(coimbra, stub, monkeypatch, tmp_path, capsys):
    hang_in(monkeypatch, f"{__name__}:STICKY")
    assert list(effects.catalogue())[-1] == "sagging_table"
    file = model_file(tmp_path, effects=[{"id": "sagging_table", "parameters": {"sag": 2.5}}])
    loads = coimbra.test("assembly-pressure").load.values
    assert read(coimbra, "assembly-pressure", file) == pytest.approx([load + 2.5 for load in loads])
    assert cli.main(["effects", "--json"]) == 0
    assert "sagging_table" in capsys.readouterr().out


@pytest.mark.parametrize(("value", "name", "words"), [
    ("nowhere.at_all:X", "sagging_table", "cannot be loaded"),
    (f"{__name__}:CONTRACT", "sagging_table", "no Effect"),
    (f"{__name__}:STICKY", "other_name", "no Effect of this id")])
def test_a_broken_effect_of_another_package_is_named(value, name, words, monkeypatch):
    hang_in(monkeypatch, value, name)
    with pytest.raises(EngineError, match=words):
        effects.catalogue()


def test_a_name_is_taken_once(monkeypatch):
    class Again(Sticky):
        id = "own_weight"

    monkeypatch.setitem(globals(), "AGAIN", Again())
    hang_in(monkeypatch, f"{__name__}:AGAIN", "own_weight")
    with pytest.raises(EngineError, match="registered twice"):
        effects.catalogue()


def test_priors_are_what_they_say():
    assert Prior("normal", (2.0, 1.0)).cumulative(3.0) == pytest.approx(0.8413, abs=1e-4)
    assert Prior("lognormal", (2.0, 0.5)).inverse(0.5) == pytest.approx(2.0)
    one = Parameter("x", "1", 0.0, 1.0, 0.0, Prior("lognormal", (0.5, 1.0)), "")
    assert one.density(1.5) == 0.0 and one.quantile(0.0) >= 0.0 and one.quantile(1.0) == pytest.approx(1.0)
    assert math.isclose(one.quantile(0.25), one.grid(2)[0])
