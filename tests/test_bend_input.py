"""Bad input to `handgen bend`: exit 2, every error at once with its reason, nothing solved or written."""

import math

import pytest

import handgen
from handgen.bending import solvers, strength
from handgen.bending.request import request
from handgen.errors import InputError
from handgen.geometry.actuator import profile_of
from handgen.materials.law import law
from handgen.parameters.load import load
from tests.bend_case import ADULT_FILE, changed_file, command, model_file
from tests.strategies import PARAMS


@pytest.fixture(autouse=True)
def unsolved(monkeypatch, stub):
    """No solver may be asked."""
    def never(name):
        raise AssertionError("solved")

    monkeypatch.setattr(solvers, "solver", never)


def errors(capsys, tmp_path, *arguments, params=ADULT_FILE):
    """What a refused command says, by path; nothing may have been written."""
    out = tmp_path / "out"
    code, data, _ = command(capsys, params, "--out", str(out), *arguments)
    assert code == 2 and not out.exists()
    return data["errors"]


@pytest.mark.parametrize(("arguments", "path", "words", "suggestion"), [
    (["--finger", "pinky"], "--finger", "none of this name", None),
    (["--finger", "indx"], "--finger", "none of this name", "index"),
    (["--finger", "opposition_1"], "--finger", "none of this name", None),
    (["--part", "assembley"], "--part", "none of this name", "assembly"),
    (["--orientation", "palmdown"], "--orientation", "none of this name", "palm_down"),
    (["--solver", "beam"], "--solver", "none of this name", None),
    (["--solver", "section"], "--solver", "none of this name", None),
    (["--solver", "sold"], "--solver", "none of this name", "solid"),
    (["--model", "litrature"], "--model", "no model of this name", "literature"),
    (["--pressures", "0", "20", "10"], "--pressures", "does not rise: it follows 20", None),
    (["--pressures", "0,20,20"], "--pressures", "does not rise: it follows 20", None),
    (["--pressures", "100:0:10"], "--pressures", "should rise", None),
    (["--pressures", "0:100:-10"], "--pressures", "should rise", None),
    (["--pressures", "0:100:0"], "--pressures", "should rise", None),
    (["--pressures", "0:100:30"], "--pressures", "do not meet 100", None),
    (["--pressures", "0:100"], "--pressures", "is no range", None),
    (["--pressures", "0:nan:10"], "--pressures", "is no range", None),
    (["--pressures", "0:100:0.01"], "--pressures", "10001 points", None),
    (["--pressures=-5,10"], "--pressures", "is negative", None),
    (["--pressures", "0,160"], "--pressures", "above the range", None),
    (["--pressures", "nan"], "--pressures", "is not finite", None),
    (["--pressures", "inf"], "--pressures", "is not finite", None),
    (["--pressures", "0,ten"], "--pressures", "is no number", None),
    (["--pressures", "0:10:5", "20"], "--pressures", "a range stands alone", None),
    (["--pressures", ""], "--pressures", "is no number", None),
    (["--part", "exoskeleton", "--pressures", "0,10"], "--pressures", "holds no pressure", None),
    (["--part", "exoskeleton", "--tip-loads", "0.2,0.1"], "--tip-loads", "does not rise", None),
    (["--part", "exoskeleton", "--tip-loads", "6"], "--tip-loads", "more than a finger holds", None),
    (["--part", "actuator", "--tip-loads", "0.1"], "--tip-loads", "carries no weight", None),
    (["--tip-loads", "0.1,0.2"], "--tip-loads", "one weight at a time", None),
    (["--orientation", "sideways", "--tip-loads", "0.1"], "--tip-loads", "across the plane", None),
    (["--obstacle", "0"], "--obstacle", "no place for a plane", None),
    (["--obstacle", "nan"], "--obstacle", "no place for a plane", None),
    (["--obstacle", "here"], "--obstacle", "is no number", None),
    (["--part", "actuator", "--obstacle", "40"], "--obstacle", "meets no plane", None),
    (["--refine", "4"], "--refine", "is no refinement", None),
    (["--refine", "-1"], "--refine", "is no refinement", None),
    (["--refine", "0.5"], "--refine", "is no refinement", None),
    (["--part", "opposition", "--finger", "index"], "--finger", "none of this name", None),
    (["--part", "opposition", "--solver", "solid"], "--solver", "none of this name", None),
    (["--part", "opposition", "--orientation", "palm_up"], "--orientation", "own weight", None),
    (["--part", "opposition", "--tip-loads", "0.1"], "--tip-loads", "carries no weight", None),
    (["--part", "opposition", "--obstacle", "10"], "--obstacle", "meets no plane", None),
    (["--part", "opposition", "--refine", "1"], "--refine", "no mesh", None),
])
def test_an_argument_that_makes_no_sense(arguments, path, words, suggestion, tmp_path, capsys):
    found = errors(capsys, tmp_path, *arguments)
    assert [e["path"] for e in found] == [path]
    assert words in found[0]["message"] and found[0]["file"] == "command line" and found[0]["allowed"]
    assert found[0]["suggestion"] == suggestion or suggestion is None


def test_the_valid_solvers_are_listed(tmp_path, capsys):
    [found] = errors(capsys, tmp_path, "--solver", "beam")
    assert found["allowed"] == "one of solid, reference, rod, stub"


@pytest.mark.parametrize("given", [[], (), ""])
def test_an_empty_list_in_a_notebook(given):
    with pytest.raises(InputError) as caught:
        handgen.bend(ADULT_FILE, pressures=given)
    [problem] = caught.value.problems
    assert problem.path == "--pressures" and problem.allowed


@pytest.mark.parametrize("arguments", [
    {"finger": 3}, {"part": None}, {"solver": ["solid"]}, {"orientation": 0}, {"refine": None},
    {"refine": 0.5}, {"pressures": [None]}, {"pressures": math.nan}, {"tip_loads": "much"}, {"obstacle": []}])
def test_a_wrong_type_in_a_notebook(arguments):
    with pytest.raises(InputError) as caught:
        handgen.bend(ADULT_FILE, **arguments)
    assert {p.path for p in caught.value.problems} == {"--" + key.replace("_", "-") for key in arguments}


def test_everything_wrong_is_said_at_once(tmp_path, capsys):
    hand = changed_file(tmp_path, casting__silicone__name="Ecoflex 00-20")
    model = model_file(tmp_path, materials={"Ninjaflex": "ninjaflex-ogden-yap", "Ecoflex 00-50": {
        "law": "yeoh", "unit": "MPa", "constants": {"c10": 0.02, "c20": -0.02, "c30": 0.0}, "strain": [0, 3],
        "source": "alves2020"}})
    found = errors(capsys, tmp_path, "--pressures", "20,10", "--solver", "x", "--model", model, params=hand)
    assert {(e["file"], e["path"]) for e in found} >= {
        ("command line", "--pressures"), ("command line", "--solver"), (hand, "casting.silicone.name")}


def test_a_wrong_hand_a_wrong_model_and_wrong_arguments_together(tmp_path, capsys):
    hand = changed_file(tmp_path, fingers__index__outer_length=-1)
    model = model_file(tmp_path, friction=7, materials={"Ninjaflex": "no-such-set"})
    found = errors(capsys, tmp_path, "--pressures=-1", "--model", model, params=hand)
    assert {e["file"] for e in found} == {"command line", hand, model}
    assert {"fingers.index.outer_length", "friction", "materials.Ninjaflex", "--pressures"} <= {
        e["path"] for e in found}


# Materials


@pytest.mark.parametrize(("body", "name", "given", "words"), [
    ("actuator", "Ecoflex 00-50", "ecoflex-00-50-ogden-elsayed", "equibiaxial"),
    ("actuator", "Ecoflex 00-50", {"law": "yeoh", "unit": "MPa", "strain": [0, 3], "source": "alves2020",
                                   "constants": {"c10": 0.02, "c20": -0.02, "c30": 0.0}}, "uniaxial"),
])
def test_an_unstable_law(body, name, given, words, tmp_path, capsys):
    model = model_file(tmp_path, materials={"Ninjaflex": "ninjaflex-mooney-rivlin-1", name: given})
    found = errors(capsys, tmp_path, "--part", body, "--model", model)
    assert [e["file"] for e in found] == [model]
    assert found[0]["path"].startswith(f"materials.{name}") and words in found[0]["message"]


def test_a_law_counts_only_where_its_material_is_used(tmp_path):
    model = model_file(tmp_path, materials={"Ninjaflex": "ninjaflex-mooney-rivlin-1",
                                            "Ecoflex 00-50": "ecoflex-00-50-ogden-elsayed"})
    assert request(ADULT_FILE, part="exoskeleton", model=model).case.silicone is None


@pytest.mark.parametrize(("values", "path", "words"), [
    ({"materials": {"Ninjaflex": "ninjaflex-mooney-rivlin-1"}}, "casting.silicone.name", "no parameter set"),
    ({"effects": [{"id": "creeep"}]}, "effects[0].id", "no effect"),
    ({"held_length": 40}, "held_length", None),
    ({"friction": -1}, "friction", "too small"),
    ({"schema": "handgen.model/2"}, "schema", "unknown version"),
    ({"fricton": 0.1}, "fricton", "unknown key"),
])
def test_a_model_that_does_not_do(values, path, words, tmp_path, capsys):
    if values == {"held_length": 40}:
        params = changed_file(tmp_path, actuators__thumb__outer_length=40)
        found = errors(capsys, tmp_path, "--finger", "thumb", "--model", model_file(tmp_path, **values),
                       params=params)
        words = "holds all of the chamber"
    else:
        found = errors(capsys, tmp_path, "--model", model_file(tmp_path, **values))
    assert [e["path"] for e in found] == [path]
    assert words in found[0]["message"] + str(found[0]["allowed"])


def test_no_such_file(tmp_path, capsys):
    found = errors(capsys, tmp_path, "--model", "gone.yaml", params="gone_too.yaml")
    assert sorted(e["file"] for e in found) == ["gone.yaml", "gone_too.yaml"]


# An actuator that does not fit


@pytest.mark.parametrize(("actuator", "path"), [
    ({"outer_length": 94.5, "base_outer_diameter": 16.5, "tip_outer_diameter": 11.5},
     "actuators.index.base_outer_diameter"),
    ({"outer_length": 94.5, "base_outer_diameter": 16, "tip_outer_diameter": 12},
     "actuators.index.tip_outer_diameter"),
    ({"outer_length": 96, "base_outer_diameter": 16, "tip_outer_diameter": 11.5},
     "actuators.index.outer_length"),
])
def test_an_actuator_that_does_not_fit_its_bore(actuator, path, tmp_path, capsys):
    found = errors(capsys, tmp_path, params=changed_file(tmp_path, actuators__index=actuator))
    assert path in [e["path"] for e in found]


def test_an_actuator_without_a_chamber(tmp_path, capsys):
    params = changed_file(tmp_path, adapt=False)
    found = errors(capsys, tmp_path, "--finger", "thumb", params=params)
    assert found and all(e["file"] == params for e in found)


# Pressures


def test_a_pressure_at_which_the_silicone_would_tear(tmp_path, capsys):
    """The free wall at its weakest section, P(l) A = p pi r^2, thread as wound, below and above."""
    hand = load(PARAMS / "adult.yaml").hand
    profile, mu = profile_of(hand, "index"), 2 * 0.023639
    x = hand.seal.plug_length
    area = profile.outer(x) ** 2 - profile.small_core(x) ** 2
    by_hand = 1e3 * mu * (1.9 - 1.9**-3) * area / (profile.large_core(x) + 0.075) ** 2
    params = changed_file(tmp_path, casting__silicone__elongation=90)
    assert request(params, pressures=[0, 0.99 * by_hand], model="literature").case
    [found] = errors(capsys, tmp_path, "--pressures", f"0,{1.01 * by_hand:.3f}", "--model", "literature",
                     params=params)
    assert found["path"] == "--pressures" and "90 % at break" in found["message"]
    assert float(found["allowed"].split()[2]) == pytest.approx(by_hand, rel=0.02)


def test_a_law_that_softens_bears_no_more_than_its_peak():
    hand = load(PARAMS / "adult.yaml").hand
    profile = profile_of(hand, "index")
    softening = law("yeoh", {"c10": 0.02, "c20": -0.001, "c30": 0.0})
    some, more = (strength.tearing_pressure(profile, 0.075, 15.0, softening, e) for e in (3.0, 9.0))
    assert some == pytest.approx(more)


def test_a_hand_whose_thumb_has_no_hinge(tmp_path, capsys):
    [found] = errors(capsys, tmp_path, "--part", "opposition", params=str(PARAMS / "thesis_finger.yaml"))
    assert found["path"] == "--part" and "no hinge" in found["message"]


# Where results go


def test_a_folder_that_handgen_did_not_write_is_left_alone(tmp_path, capsys):
    there = tmp_path / "out" / "bend" / "index_exoskeleton"
    there.mkdir(parents=True)
    (there / "thesis.txt").write_text("mine")
    code, data, _ = command(capsys, ADULT_FILE, "--part", "exoskeleton", "--out", str(tmp_path / "out"))
    assert code == 2 and data["errors"][0]["path"] == "" and "not touched" in data["errors"][0]["message"]
    assert [p.name for p in there.iterdir()] == ["thesis.txt"]


def test_a_folder_that_cannot_be_is_refused_before_anything_is_solved(tmp_path, capsys):
    (tmp_path / "file").touch()
    code, data, _ = command(capsys, ADULT_FILE, "--out", str(tmp_path / "file" / "below"))
    assert code == 2 and "written" in data["errors"][0]["message"]
