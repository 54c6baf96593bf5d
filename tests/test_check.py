"""All rules together: the report, own limits, accepted findings, rules of other packages, the verb."""

import json
from importlib.metadata import EntryPoint

import pytest

from handgen import checks, cli
from handgen.builder import build, check
from handgen.checks import run
from handgen.checks.rule import RULES, Finding, Outcome, judged, skipped
from handgen.errors import EngineError, InputError
from handgen.geometry.catalogue import parts
from handgen.parameters.load import load
from handgen.parameters.rules import Override, Rules
from tests.strategies import PARAMS

SMALL = PARAMS / "thesis_finger.yaml"


def finding(severity="error", part="exoskeleton/index"):
    return Finding("wall.minimum", severity, part, 0.5, 0.7, "mm", "thin", "thicken", "a test", (1, 2, 3))


def accepting(hand, *overrides):
    return hand.model_copy(update={"rules": Rules(overrides=[Override(**o) for o in overrides])})


def variant(tmp_path, text, base=SMALL):
    path = tmp_path / "variant.yaml"
    path.write_text(f"schema: handgen.hand/1\nextends: {base}\n{text}")
    return path


def test_every_rule_of_the_contract_is_shipped():
    assert list(run.SHIPPED) == list(RULES) and len(RULES) == 19


def test_nothing_judged_is_no_pass(adult):
    report = checks.judge(adult, {})
    assert [row["rule"] for row in report["rules"]] == list(RULES)
    assert {row["status"] for row in report["rules"]} == {"skipped"} and report["passed"] is False
    assert all(row["reason"] for row in report["rules"])


@pytest.mark.parametrize(("outcomes", "passed"), [
    ([], False),
    ([skipped("wall.minimum", "no part")], False),
    ([judged("wall.minimum", 1.0, 0.7, "", [])], True),
    ([judged("wall.minimum", 1.0, 0.7, "", []), skipped("seal.fit", "no part")], True),
    ([judged("wall.minimum", 0.5, 0.7, "", [finding("warning")])], True),
    ([judged("wall.minimum", 0.5, 0.7, "", [finding()])], False),
    ([judged("seal.fit", 1.0, 0.1, "", []), judged("wall.minimum", 0.5, 0.7, "", [finding()])], False),
])
def test_passed(adult, outcomes, passed):
    assert checks.report(adult, outcomes)["passed"] is passed


def test_an_accepted_finding_is_overridden_never_a_pass(adult):
    broken = judged("wall.minimum", 0.5, 0.7, "thinnest", [finding()])
    hand = accepting(adult, {"rule": "wall.minimum", "part": "exoskeleton/*", "reason": "printed before"})
    report = checks.report(hand, [broken])
    (row,), (found,) = report["rules"], report["findings"]
    assert report["passed"] and row["status"] == "overridden" and "printed before" in row["reason"]
    assert found["severity"] == "info" and found["message"].startswith("overridden (printed before): thin")


def test_an_override_reaches_its_rule_and_parts_only(adult):
    both = [finding(), finding(part="tooling/index/plug")]
    hand = accepting(adult, {"rule": "wall.minimum", "part": "exoskeleton/*", "reason": "as printed"},
                     {"rule": "seal.fit", "reason": "another rule"})
    report = checks.report(hand, [judged("wall.minimum", 0.5, 0.7, "", both)])
    assert not report["passed"] and report["rules"][0]["status"] == "fail"
    assert [f["severity"] for f in report["findings"]] == ["info", "error"]


def test_an_override_of_nothing_is_said(adult):
    hand = accepting(adult, {"rule": "wall.minimum", "reason": "no longer needed"})
    report = checks.report(hand, [judged("wall.minimum", 1.0, 0.7, "", [])])
    assert report["rules"][0]["status"] == "pass"
    assert "nothing to override" in report["findings"][0]["message"]


def test_own_limits_stand_beside_the_shipped(tmp_path):
    text = "rules: {limits: {actuator.length: {most_empty: {value: 2, reason: shortened on purpose}}}}\n"
    limits = checks.own_limits(load(variant(tmp_path, text)).hand, "f.yaml")
    assert limits.get("actuator.length", "most_empty").value == 2.0
    assert limits.get("actuator.length", "most_empty").source == "own limit: shortened on purpose"
    kinds = "rules: {limits: {core.demould: {undercut: {for: {core_large: {value: 0.3, reason: tried}}}}}}\n"
    limits = checks.own_limits(load(variant(tmp_path, kinds)).hand, "f.yaml")
    assert limits.get("core.demould", "undercut", "core_large").value == 0.3
    assert limits.get("core.demould", "undercut", "core_small").value == 0.5


def test_every_wrong_name_at_once_and_nothing_written(tmp_path, capsys):
    path = variant(tmp_path, """rules:
  limits: {wall.minimun: {lines: {value: 1, reason: why}}, seal.fit: {squeze: {value: 1, reason: why}},
           core.demould: {draft: {value: 1}}}
  overrides: [{rule: print.overhangs, reason: always}]
""")
    for verb in ("check", "build"):
        assert cli.main([verb, str(path), "--out", str(tmp_path / "out"), "--json"]) == 2
        errors = {e["path"]: e for e in json.loads(capsys.readouterr().out)["errors"]}
        assert set(errors) == {"rules.limits.wall.minimun", "rules.limits.seal.fit.squeze",
                               "rules.limits.core.demould.draft", "rules.overrides[0].rule"}
        assert errors["rules.limits.wall.minimun"]["suggestion"] == "wall.minimum"
        assert errors["rules.overrides[0].rule"]["suggestion"] == "print.overhang"
        assert {e["file"] for e in errors.values()} == {str(path)}
        assert not (tmp_path / "out").exists()


def test_an_override_needs_a_reason(tmp_path):
    with pytest.raises(InputError, match="reason"):
        load(variant(tmp_path, "rules: {overrides: [{rule: print.overhang}]}\n"))


@pytest.fixture
def package(monkeypatch):
    """Another package's rule, as its entry point would bring it."""

    def install(function):
        monkeypatch.setattr(EntryPoint, "load", lambda self: function)
        monkeypatch.setattr(run, "registered", lambda: {
            "lab.colour": EntryPoint("lab.colour", "lab.rules:colour", run.GROUP)})

    return install


def test_a_rule_of_another_package_takes_part(adult, package):
    def colour(hand, parts, limits):
        found = Finding("lab.colour", "error", "hand", 1.0, 0.0, "1", "grey", "paint it", "us")
        return Outcome("lab.colour", "fail", 1.0, 0.0, "1", "seen", (found,))

    package(colour)
    report = checks.judge(adult, {})
    assert report["rules"][-1]["rule"] == "lab.colour" and report["findings"][-1]["fix"] == "paint it"
    accepted = accepting(adult, {"rule": "lab.colour", "reason": "we like grey"})
    assert checks.judge(accepted, {})["rules"][-1]["status"] == "overridden"


@pytest.mark.parametrize("function", [
    lambda hand, parts, limits: 1 / 0,
    lambda hand, parts, limits: None,
    lambda hand, parts, limits: skipped("wall.minimum", "not mine"),
])
def test_a_rule_of_another_package_that_fails_is_no_pass(adult, package, function):
    package(function)
    with pytest.raises(EngineError, match=r"lab\.colour"):
        checks.judge(adult, {})


def test_a_package_may_not_replace_a_rule(monkeypatch):
    point = EntryPoint("wall.minimum", "lab.rules:walls", run.GROUP)
    monkeypatch.setattr(run, "entry_points", lambda group: [point])
    run.registered.cache_clear()
    with pytest.raises(EngineError, match=r"lab\.rules:walls"):
        run.registered()
    run.registered.cache_clear()


def test_check_writes_its_report_and_touches_nothing_else(tmp_path):
    (tmp_path / "notes.txt").write_text("mine")
    with pytest.raises(InputError, match="--out"):
        check(SMALL, out=tmp_path)
    out = tmp_path / "finger"
    result = check(SMALL, out=out)
    assert json.loads((out / "checks/checks.json").read_text()) == result["checks"]
    assert {p.name for p in out.iterdir() if not p.name.startswith(".")} == {"checks"}
    assert not list(out.rglob("*.stl")) and not list(out.rglob("*building*"))
    assert set(result["checks"]) >= {"schema", "passed", "findings", "rules"}
    again = check(SMALL, out=out, workers=1)
    assert again == result


def test_check_on_the_terminal(tmp_path, capsys):
    path = variant(tmp_path, "name: tiny\nprinting: {build_volume: [60, 60, 60]}\n")
    assert cli.main(["check", str(path), "--out", str(tmp_path / "out")]) == 1
    shown = capsys.readouterr()
    assert shown.out == "" and all(name in shown.err for name in RULES)
    assert "error print.build-volume exoskeleton/index at (" in shown.err and "mend: " in shown.err
    assert "tiny fails" in shown.err
    assert cli.main(["check", str(path), "--out", str(tmp_path / "out"), "--json", "--quiet"]) == 1
    shown = capsys.readouterr()
    assert json.loads(shown.out)["schema"] == "handgen.checks/1" and shown.err == ""


def test_findings_are_the_contracts(tmp_path):
    path = variant(tmp_path, "name: tiny\nprinting: {build_volume: [60, 60, 60]}\n")
    report = check(path, out=tmp_path / "out")["checks"]
    keys = {"rule", "severity", "part", "measured", "limit", "unit", "where", "message", "fix", "source"}
    for found in report["findings"]:
        assert keys <= set(found) and found["message"] and found["fix"] and found["source"]
        assert found["severity"] in ("error", "warning", "info")
        assert found["where"] is None or len(found["where"]) == 3
    assert {"rule", "status", "measured", "limit", "unit", "reason"} <= set(report["rules"][0])


FORBIDDEN = "actuators: {little: {adapt: false}, thumb: {adapt: false}}\n"


def test_table_a2_unadapted_fails_its_layers(tmp_path, capsys):
    """The little finger's and the thumb's small cores would end at -0.25 and -1 mm (source's notes)."""
    path = variant(tmp_path, FORBIDDEN, PARAMS / "adult.yaml")
    assert cli.main(["check", str(path), "--out", str(tmp_path / "out"), "--json"]) == 1
    report = json.loads(capsys.readouterr().out)
    (row,) = [r for r in report["rules"] if r["rule"] == "actuator.layers"]
    assert row["status"] == "fail" and row["measured"] == -1.0
    errors = {f["part"]: f["measured"] for f in report["findings"] if f["severity"] == "error"}
    assert errors == {"actuators/little": -0.25, "actuators/thumb": -1.0}


def test_what_may_not_be_thinned_is_not_made(tmp_path):
    path = variant(tmp_path, FORBIDDEN, PARAMS / "adult.yaml")
    for make in (lambda: build(path, out=tmp_path / "out", verify=False), lambda: parts(path)):
        with pytest.raises(InputError) as caught:
            make()
        assert [p.path for p in caught.value.problems] == [
            "actuators.little.tip_outer_diameter", "actuators.thumb.tip_outer_diameter"]
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(("name", "passed", "broken"), [
    ("adult", True, set()), ("thesis_finger", True, set()), ("thesis_hand", False, {"thumb.palm-stiffness"})])
def test_shipped_files(tmp_path, name, passed, broken):
    report = check(PARAMS / f"{name}.yaml", out=tmp_path / name)["checks"]
    assert report["passed"] is passed
    assert {f["rule"] for f in report["findings"] if f["severity"] == "error"} == broken
    (thumb,) = [r for r in report["rules"] if r["rule"] == "thumb.palm-stiffness"]
    if name == "adult":
        assert thumb["measured"] >= 1.25 * thumb["limit"]
    if broken:
        (found,) = [f for f in report["findings"] if f["rule"] == "thumb.palm-stiffness"]
        assert found["where"] and "mm" in found["fix"]
