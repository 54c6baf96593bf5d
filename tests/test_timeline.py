"""The day of the castings: rules kept, no shorter than proven, as short as an exact solver finds."""

import itertools

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from handgen.errors import InputError
from handgen.geometry.actuator import thread_turns
from handgen.worksheet.timeline import (
    ASSEMBLE,
    CURE,
    DEMOULD,
    HANDS,
    MIX,
    OPEN,
    POUR,
    WIND,
    Durations,
    lower_bound,
    plan,
)
from tests.exact_schedule import shortest

SLACK = 1e-6


def broken(timeline, d, moulds):
    """Every rule that a schedule breaks, from its steps alone."""
    steps, faults = timeline.steps, []
    hands = sorted((s for s in steps if s.what in HANDS), key=lambda s: s.start)
    faults += [f"two things at once at {b.start:.1f}" for a, b in itertools.pairwise(hands)
               if b.start < a.end - SLACK]
    lengths = {ASSEMBLE: d.assemble, MIX: d.mix, POUR: d.pour, CURE: d.cure, OPEN: d.open, DEMOULD: d.demould,
               **{(WIND, name): time for name, time in d.wind.items()}}
    faults += [f"{s.what} takes {s.end - s.start:.2f}" for s in steps
               if abs(s.end - s.start - lengths.get(s.what, lengths.get((s.what, *s.actuators), 0))) > SLACK]
    chain = [(WIND, 0), (ASSEMBLE, 1), (POUR, 1), (CURE, 1), (OPEN, 1), (POUR, 2), (CURE, 2), (DEMOULD, 2)]
    taken = []
    for name in d.wind:
        own = {(s.what, s.layer): s for s in steps if s.what != MIX and s.actuators == (name,)}
        count = sum(s.actuators == (name,) and s.what != MIX for s in steps)
        if sorted(own) != sorted(chain) or count != len(chain):
            faults.append(f"{name} has other steps: {sorted(own)}")
            continue
        faults += [f"{name}: {a} after {b}" for a, b in itertools.pairwise(chain)
                   if own[b].start < own[a].end - SLACK]
        # Silicone cures from when it is poured, not when somebody finds time.
        faults += [f"{name} waits to cure" for layer in (1, 2)
                   if abs(own[CURE, layer].start - own[POUR, layer].end) > SLACK]
        taken.append((own[ASSEMBLE, 1].start, own[DEMOULD, 2].end))
    for start, _ in taken:
        if sum(a <= start + SLACK and b > start + SLACK for a, b in taken) > moulds:
            faults.append(f"more than {moulds} moulds at {start:.1f}")
    filled = 0
    for mix, pours in timeline.mixes:
        filled += len(pours)
        faults += [f"poured {p.end - mix.start:.1f} min after A met B" for p in pours
                   if p.end - mix.start > d.pot_life + SLACK]
        if {p.actuators[0] for p in pours} != set(mix.actuators):
            faults.append("a mix is not for what it fills")
    if filled != 2 * len(d.wind):
        faults.append(f"{filled} pours")
    return faults


@pytest.fixture(scope="module")
def adults(adult):
    turns = {name: thread_turns(adult, name) for name in adult.actuators.present()}
    return Durations.of(adult.casting, turns)


@pytest.mark.parametrize("moulds", [1, 2, 3, 4, 5, 6, 7, 20])
def test_seven_castings_within_a_tenth_of_what_is_possible(moulds, adults):
    day = plan(adults, moulds)
    assert len(adults.wind) == 7
    assert broken(day, adults, moulds) == []
    assert day.bound <= day.end <= 1.1 * day.bound


def test_a_mould_more_is_never_worse(adults):
    ends = [plan(adults, moulds).end for moulds in range(1, 9)]
    assert ends == sorted(ends, reverse=True) and ends[6] == ends[7]


TIMES = st.builds(
    Durations,
    wind=st.lists(st.floats(0.5, 30), min_size=1, max_size=8).map(
        lambda times: {f"a{i}": t for i, t in enumerate(times)}),
    assemble=st.floats(0, 20), mix=st.floats(0.5, 10), pour=st.floats(0.3, 6), pot_life=st.floats(16, 120),
    cure=st.floats(5, 600), open=st.floats(0, 30), demould=st.floats(0, 30))


@settings(max_examples=60, deadline=None)
@given(TIMES, st.integers(1, 9))
def test_any_times_keep_the_rules(durations, moulds):
    day = plan(durations, moulds)
    assert broken(day, durations, moulds) == []
    assert day.end >= day.bound - SLACK


def test_a_mix_fills_what_its_pot_life_allows():
    """Moulds that are ready at once, and a mix that takes long: as many as possible share it, but no more."""
    d = Durations({f"a{i}": 0.5 for i in range(7)}, 0.0, 10.0, 2.0, 16.0, 180.0, 0.0, 0.0)
    day = plan(d, 7)
    assert broken(day, d, 7) == []
    assert max(len(pours) for _, pours in day.mixes) == d.batch == 3


@pytest.mark.parametrize(("cure", "pot_life", "wind"), [
    (180.0, 18.0, {"a": 9.0, "b": 3.0}), (20.0, 40.0, {"a": 5.0, "b": 6.0}),
    (8.0, 8.0, {"a": 10.0, "b": 4.0})])
@pytest.mark.parametrize("moulds", [1, 2])
def test_an_exact_solver_lies_between_bound_and_plan(cure, pot_life, wind, moulds):
    d = Durations(wind, 5.0, 4.0, 2.0, pot_life, cure, 15.0, 10.0)
    exact = shortest(d, moulds)
    assert lower_bound(d, moulds) <= exact + 1e-4
    assert exact - 1e-4 <= plan(d, moulds).end <= 1.1 * exact


@pytest.mark.slow
@pytest.mark.parametrize("moulds", [1, 2, 3])
def test_three_castings_against_an_exact_solver(moulds):
    d = Durations({"a": 9.0, "b": 3.0, "c": 6.0}, 5.0, 4.0, 2.0, 18.0, 180.0, 15.0, 10.0)
    exact = shortest(d, moulds)
    assert lower_bound(d, moulds) <= exact + 1e-4
    assert exact - 1e-4 <= plan(d, moulds).end <= 1.01 * exact


@pytest.mark.slow
@settings(max_examples=40, deadline=None)
@given(TIMES.filter(lambda d: len(d.wind) <= 2), st.integers(1, 2))
def test_no_schedule_of_any_times_is_shorter_than_the_bound(durations, moulds):
    exact = shortest(durations, moulds)
    assert lower_bound(durations, moulds) <= exact + 1e-3
    assert plan(durations, moulds).end >= exact - 1e-3


def test_one_casting_alone_is_a_sum():
    d = Durations({"a": 7.0}, 5.0, 4.0, 2.0, 18.0, 180.0, 15.0, 10.0)
    day = plan(d, 1)
    assert day.end == pytest.approx(7 + 5 + 4 + 2 + 180 + 15 + 4 + 2 + 180 + 10)
    assert [s.what for s in day.steps] == [
        WIND, ASSEMBLE, MIX, POUR, CURE, OPEN, MIX, POUR, CURE, DEMOULD]


@pytest.mark.parametrize(("changes", "path"), [
    ({"moulds": 0}, "casting.mould_sets"), ({"moulds": -2}, "casting.mould_sets"),
    ({"wind": {}}, "actuators"),
    ({"pot_life": 5.9}, "casting.silicone.pot_life"), ({"cure": -1.0}, "cure"), ({"pour": 0.0}, "pour"),
    ({"open": float("nan")}, "open"), ({"cure": float("inf")}, "cure")])
def test_wrong_inputs_are_refused(changes, path):
    values = dict(wind={"a": 7.0}, assemble=5.0, mix=4.0, pour=2.0, pot_life=18.0, cure=180.0, open=15.0,
                  demould=10.0) | changes
    moulds = values.pop("moulds", 1)
    with pytest.raises(InputError) as refused:
        plan(Durations(**values), moulds)
    assert [p.path for p in refused.value.problems] == [path]
