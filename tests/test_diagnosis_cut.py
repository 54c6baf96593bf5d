"""An effect is not named at the last size that the simulation found a balance for: what lies beyond, of it or
of its rivals, could not be judged."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from handgen.discrepancy import document
from handgen.discrepancy.dense import dense
from handgen.discrepancy.score import score
from handgen.discrepancy.verdict import MISFIT, SURE, verdict
from tests.small_library import library, readings, truth


def cut(lib, name, above):
    """`lib` without a balance at the last load of the finger's test where an effect is larger."""
    response = lib.responses[name]
    lost = response.predictions.copy()
    lost[np.ix_(response.axes[0] > above, lib.points("finger")[-1:])] = np.nan
    return replace(lib, responses=lib.responses | {name: replace(response, predictions=lost)})


def test_values_next_to_those_without_a_balance_are_the_last():
    axes = (np.linspace(0, 1, 5), np.linspace(0, 2, 5))
    first, second = np.meshgrid(*axes, indexing="ij")
    predictions = np.stack([first + second, np.where(first + second > 2.6, np.nan, second)], axis=-1)
    whole = dense(axes, [np.ones(5)] * 2, predictions, {2: 5})
    assert not whole.last.any() and not whole.on(np.array([0])).last.any()
    found = whole.on(np.array([0, 1]))
    step = np.array([0.25, 0.5])
    for value, last in zip(found.values, found.last, strict=True):
        further = [value + step * move for move in ([1, 0], [0, 1])]
        assert last == any(x.sum() > 2.6 and (x <= [1, 2]).all() for x in further)
    nowhere = np.where(predictions[..., 1:] < 2.6, predictions[..., 1:], np.nan)
    assert (dense(axes, [np.ones(5)] * 2, nowhere, {2: 5}).last == found.last).all()


@pytest.mark.parametrize("names", [("sag",), ("sag", "soft"), ("curl", "soft")])
def test_an_effect_is_not_named_where_the_model_ends(names):
    """Its true size lies beyond: the last that is left still fits, and better than all else."""
    lib = library()
    seen = readings(lib, truth(lib, **dict.fromkeys(names, 1.0)))
    whole = verdict(score(lib, seen))
    assert (set(whole.effects), whole.best.cut) == (set(names), ()) and whole.word in ("named", "pair")
    scores = score(cut(lib, names[0], 0.8), seen)
    found = verdict(scores)
    assert (found.word, found.best.id, found.best.cut) == ("ambiguous", whole.best.id, names[:1])
    assert found.best.probability > SURE and found.best.p_value > MISFIT
    (flag,) = document._cut(SimpleNamespace(scores=scores, verdict=found))
    assert f"the last size of {names[0]} that the model finds a balance for" in flag
    assert not document._cut(SimpleNamespace(scores=scores, verdict=whole))


def test_where_the_model_ends_far_off_nothing_changes():
    lib = library()
    found = verdict(score(cut(lib, "sag", 1.6), readings(lib, truth(lib, sag=1.0))))
    assert (found.word, found.effects, found.best.cut) == ("named", ("sag",), ())
