"""`handgen diagnose` from a measurements file to its page, with a solver in closed form."""

import json
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import yaml

from handgen.bending.comparison import asked, observed
from handgen.bending.model import Effect as Switch
from handgen.bending.model import load_model
from handgen.cli import main
from handgen.discrepancy import simulated, worker
from handgen.discrepancy.closely import PAIRS, ROUNDS, SHORT
from handgen.discrepancy.simulated import Simulation
from handgen.effects import Effect, Parameter, Prior, registry
from handgen.measurements.load import load_measurements
from handgen.simulation.case import State
from tests.benchmarks import diagnosis_close
from tests.quick_bends import curve

COIMBRA = Path("params/measurements/coimbra_index.yaml").resolve()
KEYS = {"schema", "verdict", "effects", "candidates", "where", "gap", "next_test", "model", "flags"}


@pytest.fixture(autouse=True)
def quick(monkeypatch, tmp_path):
    monkeypatch.setenv("HANDGEN_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr(worker, "solve", lambda asked: type("Bend", (), {"curve": curve(asked.case)}))


def campaign(folder, share, seed=0, spoil=None, effects=()):
    """The source's tests as read of a finger of which so much own weight acts, and `effects`."""
    measured = load_measurements(COIMBRA)
    model = load_model("calibrated")[0]
    model = model.model_copy(update={
        "own_weight": model.own_weight.model_copy(update={"assembly": share}),
        "effects": [Switch(id=name, parameters=sizes) for name, sizes in effects]})
    rng = np.random.default_rng(seed)
    data = yaml.safe_load(COIMBRA.read_text())
    data["hand"] = str(COIMBRA.parent / data["hand"])
    data["tests"] = data["tests"][:3]
    for test in data["tests"]:
        mine = measured.test(test["id"])
        true = np.array(observed(mine, curve(asked(measured, mine, model).case)))
        rows = np.round(2 * (true + 0.4 * rng.standard_normal((3, len(true))))) / 2
        test |= {"repeats": rows.tolist(), "held_out": False}
        test.pop("fit_up_to", None)
    if spoil:
        spoil(data)
    (folder / "lab.yaml").write_text(yaml.safe_dump(data))
    weightless = yaml.safe_load(Path("params/models/calibrated.yaml").read_text())
    weightless |= {"name": "weightless", "own_weight": {"assembly": 0}}
    (folder / "weightless.yaml").write_text(yaml.safe_dump(weightless))
    return folder / "lab.yaml", folder / "weightless.yaml"


def diagnose(capsys, measurements, model, out):
    code = main(["diagnose", str(measurements), "--model", str(model), "--out", str(out), "--workers", "1",
                 "--json"])
    return code, json.loads(capsys.readouterr().out)


def test_own_weight_that_a_model_lacks_is_named_added_and_closes_the_gap(tmp_path, capsys):
    code, found = diagnose(capsys, *campaign(tmp_path, 1.0), tmp_path / "out")
    assert code == 1 and set(found) >= KEYS
    assert found["verdict"] == "named"
    (effect,) = found["effects"]
    assert effect["id"] == "own_weight" and effect["probability"] >= 0.9
    assert "own weight" in effect["sentence"]
    (share,) = effect["parameters"]
    assert share["low"] <= 1.0 <= share["high"] and share["unit"] == "1"
    assert sum(c["probability"] for c in found["candidates"]) == pytest.approx(1.0)
    assert {"none", "outside", "own_weight"} <= {c["id"] for c in found["candidates"]}
    gap = found["gap"]
    assert gap["unit"] == "mm" and gap["held_out"]["patched"] < 0.3 * gap["held_out"]["before"]
    assert gap["held_out"]["patched"] < gap["held_out"]["retuned"]
    assert found["next_test"] is None
    assert any("own_weight" in flag for flag in found["flags"])


def test_the_folder_holds_a_model_that_bends_and_a_page_that_stands_alone(tmp_path, capsys):
    _, found = diagnose(capsys, *campaign(tmp_path, 1.0), tmp_path / "out")
    model = load_model(found["model"])[0]
    assert [one.id for one in model.effects] == ["own_weight"]
    assert "own_weight.share" in " ".join(model.assumed)
    assert json.loads((tmp_path / "out" / "diagnosis.json").read_text()) == found
    page = (tmp_path / "out" / "diagnosis.html").read_text()
    assert found["effects"][0]["sentence"] in page and page.count("<svg") == len(found["curves"]) == 3
    for heading in ("loads that it was fitted to", "loads that were left out"):
        assert heading in page
    assert page.count("re-tuned only</span>") == 6 and "own weight and something unknown" in page
    assert "prefers-color-scheme: dark" in page and "http" not in page.replace("http://www.w3.org/", "")
    assert "<script" not in page and "src=" not in page
    measured = load_measurements(tmp_path / "lab.yaml")
    test = measured.test("assembly-pressure")
    again = observed(test, curve(asked(measured, test, model).case))
    shown = next(c for c in found["curves"] if c["test"] == test.id)["patched"]
    zero, gauge = found["patched"]["zero assembly tip_drop"], found["patched"]["gauge"]
    assert np.abs(np.array(again) + zero - shown).max() < 0.3 + 1.2 * abs(gauge)


def test_beside_own_weight_the_readings_name_what_else_is_missing(tmp_path, capsys):
    files = campaign(tmp_path, 1.0, effects=[("rest_curl", {"angle": 25.0})])
    code, found = diagnose(capsys, *files, tmp_path / "out")
    assert code == 1 and found["verdict"] == "pair"
    weight, curl = found["effects"]
    assert (weight["id"], curl["id"]) == ("own_weight", "rest_curl") and curl["probability"] >= 0.9
    for effect, size in ((weight, 1.0), (curl, 25.0)):
        (number,) = effect["parameters"]
        assert number["low"] <= size <= number["high"]
    assert sum(c["probability"] for c in found["candidates"]) == pytest.approx(1.0)
    assert [one.id for one in load_model(found["model"])[0].effects] == ["own_weight", "rest_curl"]
    assert found["gap"]["held_out"]["patched"] < 0.2 * found["gap"]["held_out"]["before"]
    assert "More than one effect is missing" in (tmp_path / "out" / "diagnosis.html").read_text()


def test_a_pair_that_is_likelier_than_what_is_named_gets_the_test_that_tells(tmp_path, capsys):
    """The curl alone would do; with a gauge that is off as well the readings are foreseen better."""
    measurements, _ = campaign(tmp_path, 1.0,
                               effects=[("rest_curl", {"angle": 14.0}), ("pressure_offset", {"offset": 6.5})])
    code, found = diagnose(capsys, measurements, "calibrated", tmp_path / "out")
    assert code == 1 and found["verdict"] == "named"
    assert [one["id"] for one in found["effects"]] == ["rest_curl"]
    told = found["next_test"]
    assert set(told["separates"]) == {"rest_curl", "rest_curl+pressure_offset"}
    assert told["observable"]["quantity"] == "chamber_pressure"
    page = (tmp_path / "out" / "diagnosis.html").read_text()
    assert told["words"][0].upper() + told["words"][1:] in page and found["effects"][0]["settle"] in page
    main(["diagnose", str(measurements), "--model", "calibrated", "--out", str(tmp_path / "again"),
          "--workers", "1"])
    assert f"measure next: {told['words']}" in " ".join(capsys.readouterr().err.split())


def test_a_camera_that_draws_out_long_drops_is_something_unknown_in_the_reading(tmp_path, capsys):
    def slanting(data):
        for test in data["tests"]:
            if test["observable"]["quantity"] == "tip_drop":
                away = (np.array(test["repeats"]) - 45) / 40
                test["repeats"] = np.round(2 * (45 + 40 * away + 14 * away * np.abs(away))) / 2
                test["repeats"] = test["repeats"].tolist()

    code, found = diagnose(capsys, campaign(tmp_path, 1.0, spoil=slanting)[0], "calibrated", tmp_path / "out")
    assert (code, found["verdict"], found["effects"]) == (1, "outside", [])
    (flag,) = [one for one in found["flags"] if one.startswith("unknown: rather in the reading")]
    page = (tmp_path / "out" / "diagnosis.html").read_text()
    assert flag in page and "rather the reading than the finger: photograph a ruler" in page


@pytest.mark.parametrize("weightless", [False, True])
def test_which_way_an_effect_goes_is_left_open_where_no_reading_tells(
        tmp_path, capsys, monkeypatch, weightless):
    """A core off the middle shortens the free actuator by as much towards either side."""
    def arched(case, straight=curve):
        found = straight(case)
        if case.part != "actuator":
            return found
        by = case.offset / 0.6
        return replace(found, states=tuple(
            replace(s, elongation=s.elongation * (1 - 0.4 * by**2 * s.pressure / 0.06),
                    bend_angle=by * s.pressure / 0.06) for s in found.states))

    monkeypatch.setattr("tests.test_diagnose.curve", arched)
    monkeypatch.setattr(worker, "solve", lambda asked: SimpleNamespace(curve=arched(asked.case)))
    measurements, light = campaign(tmp_path, 1.0, effects=[("asymmetric_winding", {"offset": -0.45})])
    code, found = diagnose(capsys, measurements, light if weightless else "calibrated", tmp_path / "out")
    assert code == 1 and found["verdict"] == ("pair" if weightless else "named")
    *known, effect = found["effects"]
    assert [one["id"] for one in known] == ["own_weight"] * weightless
    (offset,) = effect["parameters"]
    assert effect["id"] == "asymmetric_winding" and offset["low"] < -0.3 and offset["high"] > 0.3
    assert effect["sentence"].endswith("; or it is the other way round, which these readings do not rule out")
    told = found["next_test"]
    assert told["separates"] == ["asymmetric_winding"]
    assert (told["part"], told["observable"]["quantity"]) == ("actuator", "bend_angle")
    page = (tmp_path / "out" / "diagnosis.html").read_text()
    assert "It tells which way it is: asymmetric winding." in page and effect["sentence"] in page
    assert "Which way asymmetric_winding goes is open" in Path(found["model"]).read_text()


def test_a_size_that_the_model_can_just_follow_is_told_and_not_named(tmp_path, capsys, monkeypatch):
    """A curl by more than 22 degrees finds no balance at 60 kPa; the true one is 25."""
    measurements, _ = campaign(tmp_path, 1.0, effects=[("rest_curl", {"angle": 25.0})])
    _, whole = diagnose(capsys, measurements, "calibrated", tmp_path / "whole")
    assert (whole["verdict"], [one["id"] for one in whole["effects"]]) == ("named", ["rest_curl"])
    drawn = None

    def ends(asked):
        nonlocal drawn
        found, finger = curve(asked.case), asked.case.finger
        if finger is not None:
            curl = sum(joint.rest_angle for joint in finger.finger.joints)
            drawn = curl if drawn is None else drawn
            if curl - drawn > 22:
                found = replace(found, states=tuple(
                    State(s.pressure, s.tip_load, False) if s.pressure > 0.055 else s for s in found.states))
        return SimpleNamespace(curve=found)

    monkeypatch.setenv("HANDGEN_CACHE", str(tmp_path / "other"))
    monkeypatch.setattr(worker, "solve", ends)
    _, found = diagnose(capsys, measurements, "calibrated", tmp_path / "out")
    assert found["verdict"] == "ambiguous" and found["candidates"][0]["id"] == "rest_curl"
    assert found["effects"][0]["id"] == "rest_curl" and found["effects"][0]["probability"] > 0.9
    assert any(flag.startswith("beyond the model: rest_curl") for flag in found["flags"])


def test_the_likeliest_pairs_are_simulated_together(tmp_path, capsys, monkeypatch):
    asked, own = [], Simulation.together

    def watched(simulation, library, pairs):
        asked.append(pairs)
        return own(simulation, library, pairs)

    monkeypatch.setattr(Simulation, "together", watched)
    measurements, _ = campaign(tmp_path, 1.0, effects=[("rest_curl", {"angle": 25.0})])
    _, found = diagnose(capsys, measurements, "calibrated", tmp_path / "out")
    assert [len(pairs) for pairs in asked] == [PAIRS] * ROUNDS and len({*asked[0], *asked[1]}) == 2 * PAIRS
    likely = [c["id"] for c in found["candidates"] if c["id"].count("+") == 1][:2]
    assert set(likely) <= {"+".join(two) for pairs in asked for two in pairs}


def test_what_is_open_is_simulated_anew_with_what_has_no_size_and_beside_a_known_effect_with_the_likeliest(
        tmp_path, capsys, monkeypatch):
    asked, own = [], Simulation.localised

    def watched(simulation, library, values):
        asked.append(set(values))
        return own(simulation, library, values)

    monkeypatch.setattr(Simulation, "localised", watched)
    files = campaign(tmp_path, 1.0, effects=[("rest_curl", {"angle": 25.0})])
    diagnose(capsys, files[0], "calibrated", tmp_path / "plain")
    diagnose(capsys, *files, tmp_path / "known")
    plain, known = asked
    assert plain == {"wrong_convention"}
    assert "rest_curl" in known and 1 <= len(known) <= SHORT and "own_weight" not in known


def test_what_two_effects_do_together_is_what_is_left_of_their_sum(tmp_path):
    """A curl under soft silicone: turns add up here, and the tip's drop goes with exp(-turn)."""
    measured = load_measurements(COIMBRA)
    tests = [measured.test(name) for name in ("exoskeleton-weights", "assembly-pressure")]
    simulation = Simulation(measured, tests, load_model("calibrated")[0], worker.Bends(1, lambda line: None))
    library = simulated.library(simulation, only=(), members=2)
    sizes = {"rest_curl": {"angle": 20.0}, "silicone_softening": {"softening": 0.3}}
    wide = simulation.together(library, {tuple(sizes): tuple(sizes.values())})
    (found,) = wide.interplays.values()
    models = [simulation.with_effects({name: one}) for name, one in sizes.items()]
    alone = [np.concatenate([observed(test, curve(asked(measured, test, model).case)) for test in tests])
             - library.baseline for model in models]
    assert found.shifts == pytest.approx(np.array(alone))
    left = 85.0 - library.baseline
    assert found.excess == pytest.approx(-alone[0] * alone[1] / left, abs=1e-6)


def test_what_the_study_keeps_is_what_a_diagnosis_would_simulate():
    measured = load_measurements(COIMBRA)
    tests = [measured.test(name) for name in ("exoskeleton-weights", "assembly-pressure")]
    simulation = Simulation(measured, tests, load_model("calibrated")[0], worker.Bends(1, lambda line: None))
    known = ("rest_curl", "silicone_softening", "wrong_convention")
    library = simulated.library(simulation, only=known, members=2)
    kept = diagnosis_close.simulated(simulation, library)
    assert set(kept.opens) == {"wrong_convention"} and len(kept.twos) == 3
    values = {"wrong_convention": {"misread": 1.0}}
    own, stood_in = (one.localised(library, values).responses["wrong_convention"]
                     for one in (simulation, kept))
    assert stood_in.jacobian == pytest.approx(own.jacobian)
    assert stood_in.structural == pytest.approx(own.structural)
    for near in kept.twos["rest_curl", "silicone_softening"]:
        sizes = {"angle": near.sizes[0]}, {"softening": near.sizes[1]}
        pairs = {("rest_curl", "silicone_softening"): sizes}
        own, stood_in = (next(iter(one.together(library, pairs).interplays.values()))
                         for one in (simulation, kept))
        assert stood_in.excess == pytest.approx(own.excess) and np.abs(own.excess).max() > 0.1


@pytest.mark.parametrize("seed", range(20))
def test_what_is_open_stays_a_covariance_where_an_effect_finds_no_balance(seed):
    rng = np.random.default_rng(seed)
    new, old = ((lambda a: a @ a.T)(rng.standard_normal((12, 3)) * [1.0, 3.0, 9.0]) for _ in range(2))
    there = rng.random(12) < 0.8
    found = simulated.where_known(there, new, old)
    assert np.linalg.eigvalsh(found).min() > -1e-9
    assert (found[np.ix_(there, there)] == new[np.ix_(there, there)]).all()
    assert (found[np.ix_(~there, ~there)] == old[np.ix_(~there, ~there)]).all()


def test_own_weight_that_the_readings_deny_is_not_named(tmp_path, capsys):
    """The check says that it is missing; a finger that was carried after all reads otherwise."""
    code, found = diagnose(capsys, *campaign(tmp_path, 0.0), tmp_path / "out")
    assert (code, found["verdict"], found["effects"]) == (0, "none", [])
    assert any("own_weight" in flag for flag in found["flags"])


def test_nothing_missing_is_exit_0_and_names_nothing(tmp_path, capsys):
    measurements, _ = campaign(tmp_path, 1.0)
    code, found = diagnose(capsys, measurements, "calibrated", tmp_path / "out")
    assert (code, found["verdict"], found["effects"]) == (0, "none", [])
    assert load_model(found["model"])[0].effects == []


def test_a_spoilt_repeat_is_flagged_and_the_name_stays(tmp_path, capsys):
    def spoil(data):
        data["tests"][2]["repeats"][1] = [r + 5.0 for r in data["tests"][2]["repeats"][1]]

    _, found = diagnose(capsys, *campaign(tmp_path, 1.0, spoil=spoil), tmp_path / "out")
    assert any("outlying repeat: assembly-pressure, repeat 2" in flag for flag in found["flags"])
    assert [one["id"] for one in found["effects"]] == ["own_weight"]


def test_what_was_solved_is_not_solved_again(tmp_path, capsys, monkeypatch):
    from handgen.bending import cache, solvers

    def kept(asked):
        found = curve(asked.case)
        cache.write(cache.key(asked.case, solvers.solver(asked.solver)), found)
        return type("Bend", (), {"curve": found})

    monkeypatch.setattr(worker, "solve", kept)
    files = campaign(tmp_path, 1.0)
    _, first = diagnose(capsys, *files, tmp_path / "out")
    _, second = diagnose(capsys, *files, tmp_path / "out")
    assert first["bends_solved"] > 100 and second["bends_solved"] == 0
    assert {**first, "bends_solved": 0} == second


class Fog(Effect):
    """A reading aid of another package that shows the finger lower."""

    id = "fog"
    name = "fog on the glass"
    sentence = "Fog shows the finger {lower:.1f} mm lower"
    signature, source, settle = "finger with its actuator alone", "made up", "wipe the glass"
    parameters = (Parameter("lower", "mm", 0.0, 30.0, 0.0, Prior("normal", (15.0, 5.0)), "of the tip"),)

    def on_case(self, case, p):
        return case

    def on_reading(self, quantity, loads, values, p):
        drop = quantity == "tip_drop" and max(loads) > 1.0
        return [None if v is None else v + p["lower"] * (1 - load / 80) if drop else v
                for v, load in zip(values, loads, strict=True)]


def test_an_effect_of_another_package_takes_part_in_everything(tmp_path, capsys, monkeypatch):
    point = type("Point", (), {"name": "fog", "value": "lab:FOG", "load": lambda self: Fog()})()
    monkeypatch.setattr(registry, "entry_points", lambda group: [point])

    def fog(data):
        test = data["tests"][2]
        loads = test["load"]["values"]
        test["repeats"] = [[r + 14 * (1 - p / 80) for r, p in zip(row, loads, strict=True)]
                           for row in test["repeats"]]

    measurements, _ = campaign(tmp_path, 1.0, spoil=fog)
    code, found = diagnose(capsys, measurements, "calibrated", tmp_path / "out")
    assert code == 1 and any("fog" in c["id"] for c in found["candidates"][:2])
    assert "fog on the glass" in (tmp_path / "out" / "diagnosis.html").read_text()


def test_all_held_out_and_unknown_models_are_bad_input(tmp_path, capsys):
    def hold(data):
        data["tests"] = [{**data["tests"][2], "held_out": True, "repeats": [[1.0] + [None] * 5]}]

    measurements, model = campaign(tmp_path, 1.0, spoil=hold)
    assert main(["diagnose", str(measurements), "--model", str(model), "--out", str(tmp_path / "out")]) == 2
    assert main(["diagnose", str(measurements), "--model", "thesys", "--out", str(tmp_path / "out")]) == 2
    assert "thesis" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_a_folder_that_cannot_be_written_is_refused_before_anything_is_solved(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(worker, "solve", lambda asked: pytest.fail("solved"))
    files = campaign(tmp_path, 1.0)
    (tmp_path / "out").write_text("a file")
    code, found = diagnose(capsys, *files, tmp_path / "out" / "mine")
    (error,) = found["errors"]
    assert code == 2 and error["path"] == "--out" and "is no folder" in error["message"]
