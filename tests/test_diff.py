"""What changes between two parameter files: held against the change that was made."""

import json

import pytest

from handgen import cli
from handgen.bending.result import Bend
from handgen.builder.plan import plan
from handgen.diff import bends, diff, parts, rules, said
from handgen.errors import InputError
from handgen.geometry.catalogue import catalogue
from handgen.parameters.load import load
from handgen.slicing import files
from handgen.slicing.slice import asked_key, printed
from tests import quick_bends
from tests.strategies import PARAMS

BASE = PARAMS / "thesis_finger.yaml"
LONGER = """fingers: {index: {outer_length: 88, inner_length: 78.5}}
actuators: {index: {outer_length: 78.5}}
"""
ROUNDER = "exoskeleton: {joint_fillet: 1}\n"
SLOWER = "printing: {finger: {speed: 15}}\n"


def plain(text, code):
    return text


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    return tmp_path_factory.mktemp("diff")


@pytest.fixture(autouse=True)
def there(place, monkeypatch):
    """Nothing but what these tests made is known."""
    monkeypatch.chdir(place)
    monkeypatch.setenv("HANDGEN_CACHE", str(place / "cache"))


def variant(place, name, text):
    file = place / f"{name}.yaml"
    file.write_text(f"schema: handgen.hand/1\nextends: {BASE}\nname: {name}\n{text}")
    return file


@pytest.fixture(scope="module")
def longer(place):
    return variant(place, "longer", LONGER)


@pytest.fixture
def found(longer):
    return diff(BASE, longer, workers=1)


def listed(hand):
    """Part -> key of its content."""
    return {one.part.name: one.key for one in plan(hand, catalogue(hand).values())}


def row(rows, **wanted):
    [one] = [each for each in rows if wanted.items() <= each.items()]
    return one


def test_parameters_are_those_that_the_variant_states(found):
    assert found["parameters"] == [
        {"path": "fingers.index.outer_length", "a": 86.0, "b": 88.0},
        {"path": "fingers.index.inner_length", "a": 76.5, "b": 78.5},
        {"path": "actuators.index.outer_length", "a": 76.5, "b": 78.5},
    ]
    assert not found["same"]
    assert (found["a"]["name"], found["b"]["name"]) == ("thesis_finger", "longer")


def test_a_fillet_changes_the_finger_and_nothing_that_is_cast(place):
    keys = [listed(load(file).hand) for file in (BASE, variant(place, "rounder", ROUNDER))]
    assert {name for name in keys[0] if parts.change(name, *keys) != "same"} == {"exoskeleton/index"}


def test_parts_that_are_the_same_measure_the_same(found):
    assert {each["name"] for each in found["parts"]} == set(listed(load(BASE).hand))
    same = [each for each in found["parts"] if each["change"] == "same"]
    assert same and all(each["a"] == each["b"] for each in same)


def test_sizes_follow_the_length(found):
    finger = row(found["parts"], name="exoskeleton/index")
    assert finger["b"]["size_mm"][0] - finger["a"]["size_mm"][0] == pytest.approx(2.0, abs=1e-3)


def test_masses_and_least_times_follow_from_the_volumes(found):
    process = load(BASE).hand.printing.finger
    finger = row(found["parts"], name="exoskeleton/index")
    mass, time = row(found["masses"], what="fingers"), row(found["times"], part="exoskeleton/index")
    assert time["how"] == parts.LEAST
    for side in "ab":
        volume = finger[side]["volume_mm3"]
        assert mass[side] == pytest.approx(volume / 1e3 * process.density, rel=1e-4)
        assert time[side] == pytest.approx(
            volume / (process.nozzle_size * process.layer_height * process.speed) / 3600, abs=1e-3)


def test_a_bend_is_not_guessed(found):
    """Nothing is solved, and that is said."""
    assert found["bends"] == [{"finger": "index", "change": "changed", "a": None, "b": None,
                               "why": {"a": bends.UNSOLVED, "b": bends.UNSOLVED}}]
    assert f"index     {bends.UNSOLVED} -> {bends.UNSOLVED}" in said.told(found, plain)


def test_a_slower_print_bends_the_same_and_has_the_same_parts(place):
    both = [load(file) for file in (BASE, variant(place, "slower", SLOWER))]
    assert listed(both[0].hand) == listed(both[1].hand)
    [bend] = bends.bends(*both, False, str)
    assert bend["change"] == "same"


def test_bends_are_solved_when_asked_and_stand_side_by_side(longer, monkeypatch):
    monkeypatch.setattr(bends, "solve", lambda asked: Bend(asked, quick_bends.curve(asked.case), False))
    found = diff(BASE, longer, solving=True, workers=1)
    [bend] = found["bends"]
    truth = quick_bends.curve(bends.request(load(longer), finger="index").case)
    assert [p["tip_drop_mm"] for p in bend["b"]["points"]] == [state.tip_drop for state in truth.states]
    assert bend["why"] == {}


def test_the_way_back_is_the_same_with_sides_exchanged(found, longer):
    back = diff(longer, BASE, workers=1)
    exchanged = {"a": "b", "b": "a"}
    for key in ("parameters", "rules", "times", "masses", "parts"):
        turned = [{exchanged.get(name, name): value for name, value in each.items()} for each in back[key]]
        assert sorted(map(str, map(sorted, map(dict.items, turned)))) == sorted(
            map(str, map(sorted, map(dict.items, found[key]))))
    assert back["findings"] == {"gone": found["findings"]["new"], "new": found["findings"]["gone"]}


def test_a_file_and_itself_have_no_difference():
    found = diff(BASE, BASE, workers=1)
    assert found["same"] and not found["parameters"] and not found["rules"]
    assert found["adaptations"] == found["findings"] == {"gone": [], "new": []}
    assert {each["change"] for each in found["parts"]} == {"same"}
    assert "have the same parameters" in said.told(found, plain)


def sliced(folder, hand, seconds):
    part = printed(hand)["exoskeleton/index"]
    files.Slices(folder).write([{"part": part.name, "slicer": "cura", "gcode": "x.gcode", "key": "k",
                                 "sha256": "s", "asked": asked_key(hand, part), "print_time_s": seconds}])


def test_sliced_times_count_only_for_the_parts_that_were_sliced(longer, place):
    before, after = load(BASE).hand, load(longer).hand
    sliced(place / "outputs/thesis_finger", before, 3600)
    sliced(place / "outputs/longer", before, 7200)  # of other parameters: left from before the change
    try:
        time = row(diff(BASE, longer, workers=1)["times"], how="cura")
        assert (time["a"], time["b"]) == (1.0, None)
        sliced(place / "outputs/longer", after, 7200)
        found = diff(BASE, longer, workers=1)
        time = row(found["times"], how="cura")
        assert (time["a"], time["b"]) == (1.0, 2.0)
        assert "exoskeleton/index, cura" in said.told(found, plain)
        assert "at least" not in said.told(found, plain)
    finally:
        for name in ("thesis_finger", "longer"):
            (place / "outputs" / name / files.INDEX).unlink()


def test_quick_makes_nothing_and_says_what_is_not_known(longer, tmp_path, monkeypatch):
    monkeypatch.setenv("HANDGEN_CACHE", str(tmp_path))
    found = diff(BASE, longer, quick=True)
    assert not list(tmp_path.iterdir())
    assert found["rules"] is found["findings"] is found["a"]["passed"] is None
    assert row(found["parts"], name="exoskeleton/index") == {
        "name": "exoskeleton/index", "change": "changed", "a": None, "b": None}
    assert row(found["masses"], what="fingers")["a"] is None
    assert "thesis_finger is not judged yet -> longer is not judged yet" in said.told(found, plain)


def test_quick_knows_what_was_found_before(found, longer):
    assert diff(BASE, longer, quick=True, workers=1) == found


def report(*rows, findings=()):
    return {"rules": [{"rule": name, "status": status, "measured": measured, "limit": 1.0, "unit": "mm",
                       "reason": ""} for name, status, measured in rows], "findings": list(findings)}


def finding(part, severity="error", measured=1.0):
    return {"rule": "wall.minimum", "severity": severity, "part": part, "measured": measured,
            "message": "thin"}


def test_rules_differ_by_status_or_number():
    before = report(("one", "pass", 2.0), ("two", "pass", 2.0), ("three", "skipped", None),
                    ("gone", "pass", 1.0))
    after = report(("one", "pass", 2.0 + 1e-9), ("two", "fail", 0.5), ("three", "skipped", None),
                   ("new", "pass", 1.0))
    found = {each["rule"]: (each["a"], each["b"]) for each in rules.rules(before, after)}
    assert set(found) == {"two", "gone", "new"}
    assert found["two"][1]["status"] == "fail" and found["gone"][1] is None and found["new"][0] is None


def test_findings_are_matched_by_rule_severity_and_part_one_by_one():
    before = report(findings=[finding("a"), finding("a", measured=2.0), finding("b")])
    after = report(findings=[finding("a", measured=1.5), finding("b", "warning")])
    found = rules.findings(before, after)
    assert found["gone"] == [finding("a", measured=2.0), finding("b")]
    assert found["new"] == [finding("b", "warning")]


def test_both_files_errors_at_once(place):
    wrong = [variant(place, f"wrong_{key}", f"{key}: 1\n") for key in ("finger", "actuator")]
    with pytest.raises(InputError) as caught:
        diff(*wrong)
    assert [(p.file, p.path) for p in caught.value.problems] == [
        (str(wrong[0]), "finger"), (str(wrong[1]), "actuator")]


def test_command(longer, place, capsys):
    code = cli.main(["diff", str(BASE), str(longer), "--json", "--out", "compared", "--workers", "1"])
    document = json.loads(capsys.readouterr().out)
    assert document["schema"] == "handgen.diff/1"
    assert code == (0 if document["b"]["passed"] else 1)
    assert json.loads((place / "compared/diff.json").read_text()) == document
