"""Every rule of the registry: a design that passes, one that a single parameter breaks, and its threshold.

A limit is moved to what was measured: there the rule passes, just inside too, just outside it fails.
How far outside that is, is the row's `step`: the rounding that the rule allows for, and a little more.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from handgen import checks
from handgen.checks import thumb
from handgen.checks.limits import standard
from handgen.checks.rule import RULES
from handgen.geometry import csg
from handgen.geometry.actuator import actuator
from handgen.geometry.casting import Setup
from handgen.geometry.finger import exoskeleton
from handgen.geometry.hand import hand_part
from handgen.geometry.part import Part
from handgen.geometry.thumb import Hinge
from handgen.geometry.tooling import tooling
from handgen.parameters.model import Actuators
from tests.variant import changed, limits, named

HAND = "exoskeleton/hand"
PALM: dict[str, Any] = {}


def palm(hand):
    """The hand's part, made once a variant."""
    key = hand.model_dump_json()
    if key not in PALM:
        PALM[key] = hand_part(hand)
    return {HAND: PALM[key]}


def bones(*names):
    return lambda hand: named(exoskeleton(hand, name) for name in names)


def cast(hand):
    return named([actuator(hand, "index")])


def little(hand):
    return named([*tooling(hand, "little"), actuator(hand, "little"), exoskeleton(hand, "little")])


def punched(hand):
    """The palm with a drill through the middle of the index finger's channel."""
    part = palm(hand)[HAND]
    drill = csg.cylinder(1.0, 0, 30).turned("y", -90).moved(x=50.0, y=20.0)
    return {HAND: dataclasses.replace(part, shape=part.shape - drill)}


def hooked(hand):
    """A mould whose cavity has a lip behind the cast."""
    parts, radius = little(hand), Setup(hand, "little").profile.outer(40.0)
    name, lip = "tooling/little/mould_a", csg.box((38, radius - 1.0, -2.0), (42, radius + 1.0, -0.5))
    return parts | {name: dataclasses.replace(parts[name], shape=csg.Union((parts[name].shape, lip)))}


def torn(hand):
    """A finger's mesh that lacks a triangle."""
    (part,) = bones("index")(hand).values()
    vertices, faces = part.triangles
    return {part.name: SimpleNamespace(name=part.name, triangles=(vertices, faces[1:]))}


def crowded(hand):
    """The palm with one socket of the opposition actuators cut nearer to the other: 0.8 mm are left."""
    (part,), (one, two) = palm(hand).values(), Hinge(hand).bases()
    line = np.subtract(two.start, one.start)
    way = 1.0 - (one.radius + two.radius + 0.8) / np.linalg.norm(line)
    return {HAND: dataclasses.replace(part, shape=part.shape - one.shape.moved(*(way * line).tolist()))}


def shelf(hand):
    """A plug-sized block with a shelf that reaches 4 mm out."""
    block = csg.Union((csg.box((0, 0, 0), (10, 20, 20)), csg.box((9, 0, 15), (14, 20, 20))))
    return named([Part("tooling/index/plug", "plug", "PLA", block, (1, 1, 1), "seal")])


def standing(hand):
    """The index finger on its root: its layers are plain rings."""
    (part,) = bones("index")(hand).values()
    return {part.name: dataclasses.replace(part, up=(1.0, 0.0, 0.0))}


def index_only(hand):
    return hand.model_copy(update={"actuators": Actuators(index=hand.actuators.index)})


def unadapted(hand):
    return changed(index_only(hand), actuators__index__adapt=False)


def facing(hand, value):
    """The abduction that the thumb lacks when `value` deg of turn are needed."""
    low, high = 10.0, 89.0
    while high - low > 1e-13 * high:
        middle = (low + high) / 2
        low, high = (middle, high) if thumb.angle_needed(hand, middle) < value else (low, middle)
    return hand, limits("thumb.palm-stiffness", abduction=low)


def limit(rule: str, name: str, share: Callable[[Any], float] = lambda hand: 1.0, **others):
    """A setter: the measured value over `share` of the hand becomes the rule's limit `name`."""
    return lambda hand, value: (hand, limits(rule, **{name: value / share(hand)}, **others))


def overall(outcome):
    return outcome.measured


def found(outcome):
    return min(f.measured for f in outcome.findings if f.severity != "info")


@dataclass(frozen=True)
class Row:
    """How one rule is tried.

    `base` and `parts` make the design that passes, `broken` is the one parameter that breaks it (or
    `broken_parts` a mesh that no parameter makes, as the geometry refuses it). At the threshold `edge`
    makes the parts, `set` puts a limit, `read` is what was measured under the limit `probe`; the limit
    is a `least` or a most.
    """

    parts: Callable
    set: Callable
    broken: dict[str, Any] = field(default_factory=dict)
    broken_parts: Callable | None = None
    base: Callable = lambda hand: hand
    edge: Callable | None = None
    read: Callable = overall
    probe: float | None = None
    least: bool = True
    step: float = 1e-4


ROWS = {
    "wall.minimum": Row(
        bones("index"), limit("wall.minimum", "pourable"), {"fingers__index__base_bore_diameter": 18.8},
        edge=cast, step=0.02),
    "wall.between-bores": Row(
        palm, limit("wall.between-bores", "lines", lambda hand: hand.printing.hand.nozzle_size),
        {"printing__hand__nozzle_size": 0.8}, edge=crowded, read=found, probe=3.0, step=0.05),
    "bore.breakthrough": Row(
        palm, limit("bore.breakthrough", "opening"), broken_parts=punched, edge=punched, least=False),
    "thread.gap": Row(
        cast, limit("thread.gap", "least_gap"), {"thread__pitch": 6.0}, base=index_only,
        read=found, probe=9.0),
    "thread.layer": Row(
        cast, limit("thread.layer", "most_slack"), {"thread__diameter": 0.51}, base=index_only,
        read=found, probe=0.0, least=False),
    "thumb.palm-stiffness": Row(palm, facing, {"opposition__sheet_thickness": 8.0}),
    "actuator.layers": Row(
        cast, lambda hand, value: (changed(hand, casting__minimum_core_tip_diameter=value), standard()),
        {"actuators__index__tip_outer_diameter": 9.4}, base=unadapted),
    "actuator.clearance": Row(
        cast, limit("actuator.clearance", "least"), {"actuators__index__base_outer_diameter": 16.1}),
    "actuator.length": Row(
        cast, limit("actuator.length", "most_empty"), {"actuators__index__outer_length": 93.0}, least=False),
    "core.demould": Row(
        little, limit("core.demould", "undercut__core_large"), {"actuators__little__thread__diameter": 0.4},
        base=lambda hand: changed(hand, actuators__little__thread__groove=True), least=False),
    "mould.split": Row(
        little, limit("mould.split", "undercut"), {"casting__mould_fit": 0.05}, edge=hooked, least=False),
    "suspender.centring": Row(
        little, limit("suspender.centring", "least_layer"), {"casting__core_fit": 0.4}),
    "seal.fit": Row(little, limit("seal.fit", "least_squeeze"), {"seal__plug_squeeze": 0.0}),
    "print.build-volume": Row(
        bones("index"), limit("print.build-volume", "excess"), {"printing__build_volume": [100, 100, 220]},
        least=False, step=1e-3),
    "print.line-width": Row(
        bones("index"), limit("print.line-width", "least_line", lambda hand: 0.35),
        {"fingers__index__base_bore_diameter": 19.6}, edge=standing, step=1e-3),
    "print.overhang": Row(
        bones("index"), limit("print.overhang", "reach", least_area=0.0),
        {"fingers__index__joints__0__rest_angle": 25.0}, edge=shelf, read=found, probe=1.0, least=False,
        step=1e-3),
    "fingers.interference": Row(
        bones("index", "middle"), limit("fingers.interference", "least_gap"),
        {"fingers__index__placement__root": [78, 29.3, 0]}, read=found, probe=11.0),
    "solid.watertight": Row(
        bones("index"), limit("solid.watertight", "faults"), broken_parts=torn, edge=torn, least=False),
    "hinge.strain": Row(
        bones("index"), limit("hinge.strain", "elongation_at_yield__Ninjaflex", yield_safety=1.0),
        {"fingers__index__joints__1__slot_length": 5.0}, least=False),
}


def judge(rule, hand, parts, own=None):
    return checks.outcome(rule, hand, parts, own or standard())


def errors(outcome):
    return [f for f in outcome.findings if f.severity != "info"]


def test_every_rule_has_a_row():
    assert list(ROWS) == list(RULES)


@pytest.mark.parametrize("rule", ROWS)
def test_a_design_that_passes(adult, rule):
    row = ROWS[rule]
    hand = row.base(adult)
    outcome = judge(rule, hand, row.parts(hand))
    assert (outcome.status, errors(outcome)) == ("pass", [])
    assert outcome.rule == rule and outcome.reason and outcome.unit == RULES[rule].unit


@pytest.mark.parametrize("rule", ROWS)
def test_a_single_parameter_breaks_it(adult, rule):
    row = ROWS[rule]
    hand = changed(row.base(adult), **row.broken)
    parts = (row.broken_parts or row.parts)(hand)
    outcome = judge(rule, hand, parts)
    assert outcome.status == "fail" and errors(outcome)
    # The row of the table shows what broke: its number, or its words where the unit differs.
    assert any((f.measured, f.limit) == (outcome.measured, outcome.limit) or f.message in outcome.reason
               or f.measured is None or f.unit != outcome.unit for f in errors(outcome))
    for finding in errors(outcome):
        assert finding.rule == rule and finding.part in {*parts, HAND}
        assert finding.measured is None or np.isfinite(finding.measured)
        assert finding.limit is not None and finding.unit
        assert finding.message and finding.fix and finding.source
        assert len(finding.where) == 3 and all(type(c) is float for c in finding.where)


@pytest.mark.parametrize("rule", ROWS)
def test_inside_passes_outside_fails_the_limit_passes(adult, rule):
    row = ROWS[rule]
    hand = row.base(adult)
    parts = (row.edge or row.parts)(hand)
    given = row.set(hand, row.probe) if row.probe is not None else (hand, standard())
    measured = row.read(judge(rule, given[0], parts, given[1]))
    outside = row.step if row.least else -row.step
    for beside, status in ((-outside, "pass"), (0.0, "pass"), (outside, "fail")):
        moved, own = row.set(hand, measured + beside)
        assert judge(rule, moved, parts, own).status == status, (measured, beside)


def test_table_a2_as_it_stands_leaves_no_core_in_little_finger_and_thumb(adult):
    hand = changed(adult, actuators__little__adapt=False, actuators__thumb__adapt=False)
    parts = named(actuator(adult, name) for name in hand.actuators.present())
    outcome = judge("actuator.layers", hand, parts)
    assert outcome.status == "fail"
    assert [(f.part, f.severity, f.measured) for f in outcome.findings] == [
        ("actuators/little", "error", -0.25), ("actuators/thumb", "error", -1.0)]
    adapted = judge("actuator.layers", adult, parts)
    assert adapted.status == "overridden" and {f.severity for f in adapted.findings} == {"warning"}


@pytest.mark.parametrize("rule", ROWS)
def test_without_its_parts_a_rule_is_skipped_and_says_why(adult, rule):
    outcome = judge(rule, adult, {})
    assert outcome.status == "skipped" and outcome.reason and outcome.findings == ()
    assert checks.report(adult, [outcome])["passed"] is False
