"""The thumb's opposition through the bend: the rule's angle, the range it is confirmed for, its limits."""

import dataclasses
import math

import numpy as np
import pytest

import handgen
from handgen.bending import opposition
from handgen.bending.compose import Composer
from handgen.bending.model import load_model
from handgen.checks import thumb
from handgen.checks.limits import standard
from handgen.geometry.hand import hand_part
from handgen.materials.law import law
from handgen.mechanics.hinge import Pusher, flexibility, rectangle
from handgen.parameters.load import load
from tests import reference_thumb
from tests.bend_case import ADULT_FILE, command, model_file
from tests.strategies import PARAMS

LENGTH = 24.0


def sheet(thickness, width=26.0, top=-6.5):
    found = flexibility(rectangle(width, top - thickness, top)[None], LENGTH)
    return tuple(tuple(row) for row in found.tolist())


def hinge_case(*kilopascals, thickness=2.0, young=4.41, mu=0.0473, length=24.0):
    pushers = tuple(Pusher(v, length, 2.5, 4.075, 6.0) for v in (-7.5, 7.5))
    return opposition.HingeCase(sheet(thickness), pushers, young, mu, tuple(1e-3 * p for p in kilopascals))


@pytest.fixture(scope="module")
def coarse(tmp_path_factory):
    """The adult hand with a coarser skin, which the hinge does not have; a model with the rule's moduli."""
    folder = tmp_path_factory.mktemp("opposition")
    hand = folder / "hand.yaml"
    hand.write_text(f"schema: handgen.hand/1\nextends: {PARAMS / 'adult.yaml'}\nname: coarse\n"
                    "palm: {resolution: 1.6}\n")
    model = model_file(folder, materials={"Ninjaflex": "ninjaflex-mooney-rivlin-3",
                                          "Ecoflex 00-50": "ecoflex-00-50-neo-hookean"})
    return str(hand), model


def test_at_working_pressure_it_is_the_rules_angle(coarse, stub, tmp_path, capsys):
    """The rule takes modulus and silicone from its limits and the hand, the bend from its model."""
    file, model = coarse
    code, data, _ = command(capsys, file, "--part", "opposition", "--pressures", "0,30,60", "--model", model,
                            "--out", str(tmp_path / "out"))
    assert code == 0 and (data["finger"], data["solver"], data["part"]) == ("thumb", "section", "opposition")
    assert data["orientation"] == "weightless" and any("own weight" in note for note in data["notes"])
    hand = load(file).hand
    outcome = thumb.palm_stiffness(hand, {"exoskeleton/hand": hand_part(hand)}, standard())
    assert [p["converged"] for p in data["points"]] == [True] * 3
    assert data["points"][2]["bend_angle_deg"] == pytest.approx(outcome.measured, rel=0.005)
    assert 0.0 == data["points"][0]["bend_angle_deg"] < data["points"][1]["bend_angle_deg"]
    assert all(p["tip_drop_mm"] is None and p["tip_force_N"] is None for p in data["points"])
    folder = tmp_path / "out" / "bend" / "thumb_opposition"
    assert {p.name for p in folder.iterdir()} == {"bend.json", "curve.csv", "curve.png"}
    again = handgen.bend(file, part="opposition", pressures=[0, 30, 60], model=model)
    assert again.cached and again.document["points"] == data["points"]


def test_the_actuators_are_those_of_the_rule():
    loaded = load(ADULT_FILE)
    composer = Composer(loaded, *load_model("literature"), pressures=(0.06,))
    assert composer.hinge().pushers == tuple(thumb.pushers(loaded.hand))


def test_the_models_own_thread_and_held_length_count(tmp_path):
    own = model_file(tmp_path, held_length=9, thread={"depth": 0.3})
    composer = Composer(load(ADULT_FILE), *load_model(own))
    plain = Composer(load(ADULT_FILE), *load_model("literature"))
    own, usual = composer.hinge().pushers[0], plain.hinge().pushers[0]
    assert own.length - usual.length == pytest.approx(load(ADULT_FILE).hand.seal.plug_length - 9)
    assert own.thread - usual.thread == pytest.approx(0.3 - 0.075)


def test_the_sheet_is_the_models_young():
    composer = Composer(load(ADULT_FILE), *load_model("thesis"), pressures=(0.06,))
    assert composer.hinge().young == pytest.approx(4.41, abs=0.01)


@pytest.mark.parametrize(("constants", "mu"), [({"c10": 0.02}, 0.04), ({"c10": 0.05}, 0.1)])
def test_a_neo_hookean_silicone_keeps_its_modulus(constants, mu):
    assert opposition.secant_modulus(law("neo_hookean", constants)) == pytest.approx(mu)


def test_another_law_is_met_at_a_usual_stretch():
    """Planar stress of Yeoh's law, 2 (c10 + 2 c20 (I1 - 3)) (l - l^-3), I1 = l^2 + l^-2 + 1."""
    s = opposition.USUAL_STRETCH
    expected = 2 * (0.02 + 2 * 0.004 * (s**2 + s**-2 - 2))
    assert opposition.secant_modulus(law("yeoh", {"c10": 0.02, "c20": 0.004, "c30": 0.0})) == pytest.approx(
        expected)


@pytest.mark.slow
@pytest.mark.parametrize(("thickness", "kilopascals", "rel"), [
    (2.0, 80.0, 0.02), (2.0, 100.0, 0.04), (2.0, 115.0, 0.07), (4.0, 100.0, 0.03)])
def test_tetrahedra_confirm_the_range(thickness, kilopascals, rel, monkeypatch):
    """Far beyond the pressure of the rule's own comparison, up to MOST_STRETCH."""
    monkeypatch.setattr(reference_thumb, "STEPS", (0.2, 0.45, 0.7, 0.85, 1.0))
    model = reference_thumb.Thumb(thickness, pressure=1e-3 * kilopascals)
    stations = (np.arange(48) + 0.5) / 48 * model.length
    beside = np.minimum(stations, model.length - stations)
    rise = model.fillet - np.sqrt(model.fillet**2 - np.maximum(model.fillet - beside, 0.0) ** 2)
    sections = [rectangle(model.width, model.top - model.thickness, model.top + r) for r in rise]
    flexible = flexibility(np.array(sections), model.length)
    case = dataclasses.replace(hinge_case(kilopascals, young=model.young, mu=model.mu),
                               sheet=tuple(tuple(row) for row in flexible.tolist()))
    [state] = opposition.simulate(case).states
    stretch = 1.0 + state.elongation / case.pushers[0].free_length
    assert state.converged or stretch < opposition.MOST_STRETCH + 0.05
    angle = state.bend_angle if state.converged else opposition.balance(
        flexible, case.pushers, case.pressures[0], case.young, case.mu)[1]
    assert math.degrees(angle) == pytest.approx(reference_thumb.angle(model, 4.0), rel=rel)


def test_beyond_the_confirmed_stretch_nothing_is_given():
    """A stiff sheet lets the soft actuators grow only by turning; a soft silicone runs away from it."""
    curve = opposition.simulate(hinge_case(20, 60, 100, 140, 150, mu=0.03))
    converged = [state.converged for state in curve.states]
    assert converged == sorted(converged, reverse=True) and converged[0] and not converged[-1]
    last = [s for s in curve.states if s.converged][-1]
    assert curve.reached == last.pressure and "confirmed" in curve.stopped
    assert last.bend_angle <= opposition.MOST_ANGLE
    for state in curve.states[converged.index(False):]:
        assert state.bend_angle is None and state.max_stretch is None and state.note == curve.stopped


def test_both_limits_are_limits():
    turned = opposition.simulate(hinge_case(*range(150), thickness=1.0, young=20.0, length=40.0))
    stretched = opposition.simulate(hinge_case(*range(150), young=1.0))
    assert "turns beyond the 75 degrees" in turned.stopped
    assert "stretch beyond the 1.45" in stretched.stopped


def test_an_incomplete_opposition_exits_3(coarse, stub, tmp_path, capsys):
    file, _ = coarse
    model = model_file(tmp_path, materials={
        "Ninjaflex": {"law": "neo_hookean", "unit": "MPa", "constants": {"c10": 0.5}, "strain": [0, 1],
                      "source": "alves2020"},
        "Ecoflex 00-50": "ecoflex-00-50-neo-hookean"})
    code, data, err = command(capsys, file, "--part", "opposition", "--pressures", "0:150:25", "--model",
                              model, "--out", str(tmp_path / "out"))
    assert code == 3 and 0 < data["reached"] < 150 and "confirmed" in err
    assert data["points"][-1]["bend_angle_deg"] is None


def test_stretch_is_that_of_the_wall_farthest_from_the_sheet():
    """An actuator that only lengthens stretches evenly; one that also bends more on its outside."""
    case = hinge_case(40)
    [state] = opposition.simulate(case).states
    p = case.pushers[0]
    even = 1.0 + state.elongation / p.free_length
    assert state.max_stretch == pytest.approx(even + state.bend_angle * p.outside / p.free_length)
