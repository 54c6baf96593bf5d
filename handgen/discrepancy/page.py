"""The diagnosis as one HTML page for people who have never heard of model selection; needs no other file."""

from __future__ import annotations

from collections.abc import Iterator
from html import escape
from pathlib import Path
from typing import Any

from handgen.discrepancy import figures
from handgen.discrepancy.verdict import RATHER

STYLE = Path(__file__).with_name("page.css")
WORDS = {
    "none": "Nothing is missing that these readings could show.",
    "named": "One effect is missing from the model.",
    "pair": "More than one effect is missing from the model.",
    "ambiguous": "Several explanations fit; these readings cannot decide between them.",
    "outside": "The model is wrong in a way that no known effect explains.",
}
SPELT = 3
"""Explanations of a class that are spelt out beside the first."""
CHECKS = {
    "datasheet": "Data sheet against law",
    "mass": "Balance against model",
    "stability": "Stability of the law",
    "weight": "Own weight against pose",
}


def page(document: dict[str, Any], names: dict[str, str]) -> str:
    """HTML. `names`: of effects and explanations, by id."""
    body = "\n".join(_body(document, names))
    style = STYLE.read_text(encoding="utf-8")
    title = escape(f"Diagnosis: {document['name']}")
    return (f'<!doctype html>\n<html lang="en"><head><meta charset="utf-8"><title>{title}</title>'
            '<meta name="viewport" content="width=device-width, initial-scale=1">'
            f"<style>{style}</style></head><body><main>\n{body}\n</main></body></html>\n")


def _body(d: dict[str, Any], names: dict[str, str]) -> Iterator[str]:
    yield f"<h1>{escape(d['name'])}</h1>"
    yield (f'<p class="quiet">The model <code>{escape(d["diagnosed_model"])}</code> '
           f"of the {escape(d['finger'])} finger of <code>{escape(d['hand'])}</code>, held against what was "
           "measured.</p>")
    yield _verdict(d, names)
    yield from _gap(d)
    yield from _curves(d)
    yield from _sure(d, names)
    yield from _where(d)
    yield from _effects(d)
    yield from _next(d, names)
    yield from _checks(d, names)
    yield from _flags(d)


def _verdict(d: dict[str, Any], names: dict[str, str]) -> str:
    lines = [f"<strong>{WORDS[d['verdict']]}</strong>"]
    if d["verdict"] in ("named", "pair"):
        lines += [f'{escape(e["sentence"])}. <span class="quiet">{_percent(e["probability"])} sure.</span>'
                  for e in d["effects"]]
    elif d["verdict"] == "ambiguous":
        lines.append("Still possible: " + "; ".join(_class(one, names) for one in d["classes"]) + ".")
    elif d["verdict"] == "outside":
        lines.append("The remaining error was learned as a smooth curve over the load, or over what is read. "
                     "That curve is no physics: do not use it beyond what was measured.")
    lines += [line for line in (_promise(d, names),) if line]
    return '<div class="verdict">' + "<br>".join(lines) + "</div>"


def _class(one: dict[str, Any], names: dict[str, str]) -> str:
    """Explanations that no reading at hand tells apart."""
    first, *others = [escape(names.get(name, name)) for name in one["ids"]]
    if not others:
        return f"<b>{first}</b> ({_percent(one['probability'])})"
    more = f" or {len(others) - SPELT} more" if len(others) > SPELT else ""
    return (f"<b>{first}</b> or, which reads the same, {', '.join(others[:SPELT])}{more} "
            f"({_percent(one['probability'])} together)")


def _promise(d: dict[str, Any], names: dict[str, str]) -> str:
    """What the added effect is worth in the test that was furthest off."""
    known = [t for t in d["gap"]["tests"]
             if t["unit"] == d["gap"]["unit"] and None not in t["held_out"].values()]
    if not d["patch"] or not known:
        return ""
    test = max(known, key=lambda t: t["held_out"]["before"])
    before, retuned, patched = (test["held_out"][s] for s in figures.STATES)
    added = "that" if d["verdict"] != "ambiguous" else " and ".join(names.get(one, one) for one in d["patch"])
    return (f"With {escape(added)} added, “{escape(test['title'])}” is predicted within <b>{patched:.2g} "
            f"{test['unit']}</b> at loads that the fit has not seen, instead of {before:.2g} "
            f"({_change(before, patched)}); adjusting the old model instead leaves {retuned:.2g} "
            f"({_change(before, retuned)}).")


def _change(before: float, after: float) -> str:
    share = 100 * (1 - after / before) if before else 0.0
    return f"{share:.0f} % less" if share >= 0 else f"{-share:.0f} % more"


# The three gaps


def _gap(d: dict[str, Any]) -> Iterator[str]:
    """Before, re-tuned and patched side by side: on what was fitted, on what was left out, on other tests."""
    tests = d["gap"]["tests"]
    mine = [t for t in tests if not t["held_out_test"]]
    groups = (
        ("On the loads that it was fitted to", "How well it can be made to agree: no proof of anything.",
         [(t, t["rms"]) for t in mine if any(v is not None for v in t["rms"].values())]),
        ("On loads that were left out", "Each is left out of the fit in turn, then predicted: what counts.",
         [(t, t["held_out"]) for t in mine]),
        ("On tests that no fit has seen", "The hardest: another kind of test altogether.",
         [(t, t["held_out"]) for t in tests if t["held_out_test"]]),
    )
    yield "<h2>Does it help?</h2>"
    yield ("<p>Typical distance between simulation and measurement (root mean square), model by model. "
           f"{_key('before')} is the model as it was. {_key('retuned')} is the same model with its "
           "stiffnesses, the gauge's zero and the rulers' zeros adjusted as far as is plausible: the honest "
           "rival, which an added effect has to beat. "
           + (f"{_key('patched')} has the effect added, and is adjusted likewise.</p>" if d["patch"] else
              "Nothing was added, so there is no third one.</p>"))
    for title, words, rows in groups:
        if rows:
            yield f'<h3>{title}</h3><p class="quiet">{words}</p><table class="gaps">'
            yield from (_gap_row(d, test, values) for test, values in rows)
            yield "</table>"


def _gap_row(d: dict[str, Any], test: dict[str, Any], values: dict[str, float | None]) -> str:
    shown = figures.shown(d)
    most = max((values[s] or 0.0 for s in shown), default=0.0) or 1.0
    cells = "".join(
        f'<div class="bar"><i style="width:{60 * (values[s] or 0.0) / most:.1f}%;background:var(--{s})"></i>'
        + ("no balance" if values[s] is None else f"{values[s]:.2g} {escape(test['unit'])}")
        + f' <span class="quiet">{figures.STATES[s]}</span></div>' for s in shown)
    return f"<tr><th>{escape(test['title'])}</th><td>{cells}</td></tr>"


def _key(state: str) -> str:
    line = {"before": "dotted", "retuned": "dashed", "patched": "solid"}[state]
    return (f'<span class="key" style="border-top:3px {line} var(--{state})"></span>'
            f"<em>{figures.STATES[state]}</em>")


def _curves(d: dict[str, Any]) -> Iterator[str]:
    yield "<h2>What was simulated, what was measured</h2>"
    yield ('<p class="quiet">Dots are readings, lines are models: '
           + ", ".join(_key(state) for state in figures.shown(d))
           + ". Below each: how far the models are off (simulated less measured); the grey band is what the "
           "scatter of repeated readings alone allows. A good model stays near the band.</p>")
    yield '<div class="grid">'
    for curve in d["curves"]:
        yield f"<figure>{figures.svg(figures.panel(d, curve, figures.MARKS))}</figure>"
    yield "</div>"


def _sure(d: dict[str, Any], names: dict[str, str]) -> Iterator[str]:
    yield "<h2>How sure is it?</h2>"
    yield '<table class="gaps">'
    for one in figures.likely(d):
        yield (f"<tr><th>{escape(names.get(one['id'], one['id']))}</th><td>"
               f'<div class="bar"><i style="width:{80 * one["probability"]:.1f}%;'
               'background:var(--patched)"></i>'
               f"{figures.percent(one['probability'])}</div></td></tr>")
    yield "</table>"
    yield ('<p class="quiet">Each explanation is judged by how well it foresaw these readings, with '
           "everything that is not known exactly (stiffness, gauge, tolerances of the print) left as open as "
           "it is. <em>Nothing missing</em> and <em>something unknown</em> compete on equal terms. An effect "
           "is named from 90 % on, all its bars together, and only if the model then fits.</p>")


# Where, what next, what else


def _where(d: dict[str, Any]) -> Iterator[str]:
    yield "<h2>Where it shows</h2><ul>"
    notes = {curve["test"]: curve["note"] for curve in d["curves"]}
    titles = {test["test"]: test["title"] for test in d["gap"]["tests"]}
    for one in d["located"]:
        if one["beyond_repeats"]:
            words = "; ".join(one["words"]) or "off in no simple shape"
            yield (f"<li><b>{escape(titles[one['test']])}</b>: further off than {_scatter(one)} allows (by "
                   f"chance only {_chance(one['chance'])}). The model as it was is {escape(words)}.")
        else:
            yield f"<li><b>{escape(titles[one['test']])}</b>: no more than {_scatter(one)} allows."
        if notes.get(one["test"]):
            yield f'<br><span class="quiet">Noted by those who measured: {escape(notes[one["test"]])}</span>'
        yield "</li>"
    yield "</ul>"


def _scatter(one: dict[str, Any]) -> str:
    return ("the scatter of the repeats" if one["assumed_scatter"] is None else
            f"an assumed scatter of {one['assumed_scatter']:.2g} {escape(one['unit'])} (read once only)")


def _chance(share: float) -> str:
    return f"once in {1 / share:,.0f}" if share > 1e-6 else "once in more than a million"


def _effects(d: dict[str, Any]) -> Iterator[str]:
    if not d["effects"]:
        return
    yield "<h2>The effects in question, and how to settle them for good</h2>"
    yield '<table class="stack"><tr><th>effect</th>'
    yield "<th>value</th><th>where it would show</th><th>measure it directly</th></tr>"
    for e in d["effects"]:
        values = "<br>".join(
            f"{escape(p['name'])} {p['value']:.3g}{_unit(p['unit'])} ({p['low']:.3g} to {p['high']:.3g})"
            for p in e["parameters"])
        yield (f"<tr><td>{escape(e['name'])}</td><td>{values}</td><td>{escape(e['signature'])}</td>"
               f"<td>{escape(e['settle'])}</td></tr>")
    yield "</table>"


def _next(d: dict[str, Any], names: dict[str, str]) -> Iterator[str]:
    if d["verdict"] == "none":
        return
    yield "<h2>What to measure next</h2>"
    if d["next_test"] is not None:
        words = d["next_test"]["words"]
        told = [escape(names.get(one, one)) for one in d["next_test"]["separates"]]
        what = f"apart: {', '.join(told)}" if len(told) > 1 else f"which way it is: {told[0]}"
        yield f"<p>{escape(words[0].upper() + words[1:])}. It tells {what}.</p>"
    if d["verdict"] in ("named", "pair"):
        if direct := "; ".join(escape(e["settle"]) for e in d["effects"] if not e["settled"]):
            yield f"<p>To settle it without any model: {direct}.</p>"
    elif d["verdict"] == "outside":
        yield ("<p>It is rather the reading than the finger: photograph a ruler along all that is read, from "
               "where the readings were taken.</p>" if (d["unknown_in_reading"] or 0.0) > RATHER else
               "<p>No test can be proposed for what is unknown. Repeat the test that is furthest off, with "
               "more loads where it is, and look at what the finger does there.</p>")
    elif d["next_test"] is None:
        yield "<p>No test on these set-ups would decide.</p>"
    if d["measure_directly"] is not None:
        one = d["measure_directly"]
        yield f"<p>Without any model, {escape(one['name'])} is settled so: {escape(one['how'])}.</p>"


def _checks(d: dict[str, Any], names: dict[str, str]) -> Iterator[str]:
    """What data sheet, balance and model say against each other."""
    if not d["checks"]:
        return
    yield "<h2>What could be seen without any test</h2><ul>"
    for one in d["checks"]:
        about = names.get(one["effect"] or "", one["subject"])
        yield f"<li><b>{CHECKS[one['check']]}, {escape(about)}.</b> {escape(one['message'])}.</li>"
    yield "</ul>"


def _flags(d: dict[str, Any]) -> Iterator[str]:
    flags = d["flags"][len(d["checks"]):]
    if flags:
        yield "<h2>Noticed on the way</h2><ul>"
        yield from (f"<li>{escape(flag)}</li>" for flag in flags)
        yield "</ul>"
    yield ('<p class="quiet">Beside this page: <code>model.yaml</code>, for <code>handgen bend '
           "--model</code>, and every number here in <code>diagnosis.json</code>.</p>")


def _percent(share: float) -> str:
    return f"{100 * share:.0f} %" if share < 0.995 else "above 99 %"


def _unit(unit: str) -> str:
    return "" if unit == "1" else f" {unit}"
