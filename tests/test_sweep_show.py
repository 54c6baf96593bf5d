"""What a sweep found: effects and indices against closed forms, the front, the page."""

import json
import math
import re

import numpy as np
import pytest

from handgen import cli
from handgen.sweep import draw, effects, figures, show, table
from handgen.sweep.load import prepare
from handgen.sweep.model import Axis
from handgen.sweep.variant import task
from tests.browser import chromium
from tests.sweep_files import sweep_file

UNIT = {"a": Axis(low=0.0, high=1.0), "b": Axis(low=0.0, high=1.0), "c": Axis(low=0.0, high=1.0)}


def even(count, dimension=3):
    from scipy.stats import qmc

    return qmc.Sobol(dimension, scramble=True, rng=0).random(count)


def test_indices_of_a_plane_are_its_slopes_squared():
    u = even(256)
    found = effects.sobol_indices(UNIT, u, 3 * u[:, 0] + 2 * u[:, 1] + 1, seed=0)
    assert [found["axes"][k]["S1"] for k in "abc"] == pytest.approx([9 / 13, 4 / 13, 0.0], abs=0.02)
    assert [found["axes"][k]["ST"] for k in "abc"] == pytest.approx([9 / 13, 4 / 13, 0.0], abs=0.02)


def test_indices_of_a_product_lie_in_its_interaction():
    u = even(256)
    found = effects.sobol_indices(UNIT, u, (u[:, 0] - 0.5) * (u[:, 1] - 0.5), seed=0)
    assert [found["axes"][k]["S1"] for k in "abc"] == pytest.approx([0.0, 0.0, 0.0], abs=0.02)
    assert [found["axes"][k]["ST"] for k in "abc"] == pytest.approx([1.0, 1.0, 0.0], abs=0.03)


def test_what_no_polynomial_foretells_has_no_indices():
    u = even(256)
    noise = np.random.default_rng(0).normal(size=256)
    assert "foretells only" in effects.sobol_indices(UNIT, u, noise, seed=0)["reason"]
    assert effects.sobol_indices(UNIT, u[:8], noise[:8], seed=0)["reason"] == "too few rows"
    assert effects.sobol_indices(UNIT, u, np.ones(256), seed=0)["reason"] == "the result does not vary"


def test_main_effects_are_means_over_the_rest():
    u = even(1024)
    y = 4 * u[:, 0] + np.where(u[:, 1] < 0.5, 0.0, 1.0)
    y[::7] = np.nan  # variants without a result
    a, b, c = effects.main_effects(u, list(u.T), y)
    # Eight groups: their means lie 7/8 of the slope apart.
    assert a["range"] == pytest.approx(3.5, abs=0.05) and b["range"] == pytest.approx(1.0, abs=0.1)
    assert c["range"] < 0.5 and sum(p["rows"] for p in a["points"]) == np.isfinite(y).sum()


@pytest.mark.parametrize("objectives", [2, 3])
def test_the_front_is_what_nothing_beats(objectives):
    costs = np.random.default_rng(1).normal(size=(120, objectives))
    costs[5], costs[7, 0] = np.nan, np.nan
    beaten = [not np.isfinite(x).all() or any(
        (y <= x).all() and (y < x).any() for y in costs if np.isfinite(y).all()) for x in costs]
    assert figures.front(costs).tolist() == [not b for b in beaten]


def tabled(folder, budget):
    """A sweep's folder with a table of closed-form rows."""
    prepared = prepare(sweep_file(
        folder, solver="solid", method="sobol", budget=budget,
        vary={"layers.internal": "1:2", "layers.external": "1:2"},
        objectives={"bend_angle_deg": "maximise", "finger_g": "minimise"},
        constraints={"hinge_strain": {"max": 0.8}}))
    kinds = table.columns(prepared, prepared.pressures)
    key = task(prepared, next(draw.points(prepared.sweep))).key[:50]

    def rows():
        for n, values in enumerate(draw.points(prepared.sweep)):
            x, y = values.values()
            yield {"variant": n, "hash": f"{key}{n:014x}", **values, "rules_passed": 1.0, "finger_g": x + y,
                   **({"status": "failed", "reason": "</script>"} if n % 50 == 3 else
                      {"status": "done", "bend_angle_deg": 60 + 20 * x - 5 * y, "hinge_strain": x - 1})}

    table.write(folder / "out" / "results.parquet", prepared, kinds, rows())
    return folder / "out"


def test_show_says_what_matters_and_draws_it(tmp_path, capsys):
    folder = tabled(tmp_path, 200)
    assert cli.main(["sweep", "show", str(folder), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["statuses"] == {"done": 196, "failed": 4}
    bend = found["effects"]["bend_angle_deg"]["sobol"]["axes"]
    assert bend["layers.internal"]["S1"] == pytest.approx(400 / 425, abs=0.02)
    best = found["best"][0]
    assert best["hinge_strain"] <= 0.8 and best["bend_angle_deg"] > 60 + 20 * 1.7 - 10
    for name in ("effects.png", "parallel.png", "pareto.png", "sweep.html"):
        assert (folder / name).stat().st_size > 2000
    text = (folder / "sweep.html").read_text(encoding="utf-8")
    assert not re.search(r"(src|href)=|https?://", text) and text.count("</script>") == 2


def test_the_page_holds_texts_pages_and_reasons(tmp_path):
    prepared = prepare(sweep_file(tmp_path, solver="solid", vary={"thread.material": ["PET", "nylon"]}))
    made = ({"variant": n, "hash": f"{n:064x}", "thread.material": ["PET", "nylon"][n % 2],
             **({"status": "invalid", "reason": f"why {n}"} if n % 3 == 0 else
                {"status": "done", "bend_angle_deg": 50.0 + n})} for n in range(450))
    table.write(tmp_path / "results.parquet", prepared, table.columns(prepared, ()), made)
    show(tmp_path)
    with chromium() as browser:
        view, errors = browser.new_page(), []
        view.on("pageerror", lambda error: errors.append(str(error)))
        view.goto((tmp_path / "sweep.html").as_uri())
        first = view.locator("#rows tr").nth(1).locator("td").all_inner_texts()
        assert first[:3] == ["449", "nylon", "499"] and first[-1] == "done"
        view.click("#on")
        assert view.inner_text("#page") == "201 to 400 of 450"
        view.select_option("#status", label="invalid")
        assert (view.inner_text("#chosen"), view.inner_text("#page")) == ("150 chosen", "1 to 150 of 150")
        assert view.locator("#rows tr").nth(1).locator("td").last.inner_text() == "invalid: why 0"
        assert not errors


def test_show_without_a_table(tmp_path, capsys):
    assert cli.main(["sweep", "show", str(tmp_path), "--json"]) == 2
    assert "no table of a sweep" in json.loads(capsys.readouterr().out)["errors"][0]["message"]
    assert cli.main(["sweep", "shew", "here", "--json"]) == 2


@pytest.mark.slow
def test_a_hundred_thousand_rows_stay_usable(tmp_path):
    """In a browser: every row is there, a brush chooses among them."""
    document = show(tabled(tmp_path, 100_000))
    assert (tmp_path / "out" / "sweep.html").stat().st_size < 8e6
    with chromium() as browser:
        view, errors = browser.new_page(viewport={"width": 1200, "height": 900}), []
        view.on("pageerror", lambda error: errors.append(str(error)))
        view.goto((tmp_path / "out" / "sweep.html").as_uri())
        assert view.inner_text("#chosen") == "100000 chosen"
        box = view.locator("#parallel").bounding_box()
        x = box["x"] + 60  # the first axis
        view.mouse.move(x, box["y"] + 60)
        view.mouse.down()
        view.mouse.move(x, box["y"] + 160)
        view.mouse.up()
        assert 0.2e5 < int(view.inner_text("#chosen").split()[0]) < 0.6e5 and not errors
        assert view.locator("#rows tr").count() == 201
    assert math.isfinite(document["best"][0]["bend_angle_deg"])
