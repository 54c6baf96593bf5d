"""The diagnosis as one HTML page for people who have never heard of model selection; needs no other file."""

from __future__ import annotations

from collections.abc import Iterator
from html import escape
from pathlib import Path
from typing import Any

from handgen.discrepancy import figures

STYLE = Path(__file__).with_name("page.css")
WORDS = {
    "none": "Nothing is missing that these readings could show.",
    "named": "One effect is missing from the model.",
    "pair": "Two effects are missing from the model.",
    "ambiguous": "Several explanations fit; these readings cannot decide between them.",
    "outside": "The model is wrong in a way that no known effect explains.",
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
    marks = figures.MARKS
    yield f"<h1>{escape(d['name'])}</h1>"
    yield (f'<p class="quiet">The model <code>{escape(d["diagnosed_model"])}</code> '
           f"of the {escape(d['finger'])} finger of <code>{escape(d['hand'])}</code>, held against what was "
           "measured.</p>")
    yield _verdict(d, names)
    yield "<h2>What was simulated, what was measured</h2>"
    yield (f'<div class="wide">{figures.svg(figures.overview(d, marks))}</div>')
    yield ('<p class="quiet">Above: every reading as a dot, every model as a line. Below: how far each model '
           "is off; the grey band is what the scatter of repeated readings alone would allow. A good model "
           "stays near the band.</p>")
    yield "<h2>Does it help where it has not looked?</h2>"
    yield _gap(d)
    yield f'<div class="wide">{figures.svg(figures.gap_bars(d, marks))}</div>'
    yield ("<p class=\"quiet\">Every bar is an error at loads that the model had not seen: each load was "
           "left out of the "
           "fit in turn and then predicted. <em>Re-tuned only</em> is the honest rival: the old model with "
           "its "
           "stiffnesses, gauge and rulers adjusted as far as is plausible. An added effect has to beat "
           "that.</p>")
    yield "<h2>How sure is it?</h2>"
    yield f'<div class="narrow">{figures.svg(figures.probabilities(d, marks, names))}</div>'
    yield ("<p class=\"quiet\">Each explanation is judged by how well it foresaw these readings, with "
           "everything that is "
           "not known exactly (stiffness, gauge, tolerances of the print) left as open as it is. "
           "<em>Nothing missing</em> and <em>something unknown</em> compete on equal terms. An effect is "
           "named from "
           "90 % on, and only if the model then fits.</p>")
    yield from _where(d)
    yield from _effects(d)
    yield from _next(d)
    yield from _flags(d)


def _verdict(d: dict[str, Any], names: dict[str, str]) -> str:
    lines = [f"<strong>{WORDS[d['verdict']]}</strong>"]
    if d["verdict"] in ("named", "pair"):
        lines += [escape(e["sentence"]) + f' <span class="quiet">({_percent(e["probability"])} sure)</span>'
                  for e in d["effects"]]
    elif d["verdict"] == "ambiguous":
        shown = [c for c in d["candidates"] if c["probability"] >= 0.02]
        lines.append("Still possible: " + "; ".join(
            f"{escape(names.get(c['id'], c['id']))} ({_percent(c['probability'])})" for c in shown) + ".")
    elif d["verdict"] == "outside":
        lines.append("The remaining error was learned as a smooth curve over the load. That curve is no "
                     "physics: do not "
                     "use it beyond the loads that were measured.")
    return '<div class="verdict">' + "<br>".join(lines) + "</div>"


def _gap(d: dict[str, Any]) -> str:
    before, retuned, patched = (d["gap"]["held_out"][s] for s in figures.STATES)
    unit = d["gap"]["unit"]
    if not d["patch"] or None in (before, retuned, patched):
        return (f"<p>Typical error at loads left out of the fit: {_value(before)} {unit} as it was, "
                f"{_value(retuned)} "
                f"{unit} re-tuned.</p>")
    return (f"<p>Typical error at loads left out of the fit: <b>{before:.2g} {unit}</b> as it was, "
            f"<b>{retuned:.2g} {unit}</b> re-tuned only, <b>{patched:.2g} {unit}</b> with the effect added: "
            f"{100 * (1 - patched / before):.0f} % less than before, where re-tuning alone takes away "
            f"{100 * (1 - retuned / before):.0f} %.</p>")


def _where(d: dict[str, Any]) -> Iterator[str]:
    yield "<h2>Where it shows</h2><ul>"
    for one in d["located"]:
        if one["beyond_repeats"]:
            words = "; ".join(one["words"]) or "no simple shape"
            yield (f"<li><code>{escape(one['test'])}</code>: more than the repeats allow (chance "
                   f"{one['chance']:.1g}). "
                   f"Simulated less measured: {escape(words)}.</li>")
        else:
            yield f"<li><code>{escape(one['test'])}</code>: no more than the scatter of the repeats.</li>"
    yield "</ul>"


def _effects(d: dict[str, Any]) -> Iterator[str]:
    if not d["effects"]:
        return
    yield "<h2>The effects in question, and how to settle them for good</h2><table><tr><th>effect</th>"
    yield "<th>value</th><th>where it would show</th><th>measure it directly</th></tr>"
    for e in d["effects"]:
        values = "<br>".join(
            f"{escape(p['name'])} {p['value']:.3g}{_unit(p['unit'])} ({p['low']:.3g} to {p['high']:.3g})"
            for p in e["parameters"])
        yield (f"<tr><td>{escape(e['name'])}</td><td>{values}</td><td>{escape(e['signature'])}</td>"
               f"<td>{escape(e['settle'])}</td></tr>")
    yield "</table>"


def _next(d: dict[str, Any]) -> Iterator[str]:
    if d["next_test"] is not None:
        yield "<h2>What to measure next</h2>"
        yield (f"<p>{escape(d['next_test']['words'].capitalize())}. It tells apart: "
               f"{escape(', '.join(d['next_test']['separates']))}.</p>")


def _flags(d: dict[str, Any]) -> Iterator[str]:
    if d["flags"]:
        yield "<h2>Noticed on the way</h2><ul>"
        yield from (f"<li>{escape(flag)}</li>" for flag in d["flags"])
        yield "</ul>"
    yield ('<p class="quiet">Beside this page: <code>model.yaml</code>, for <code>handgen bend '
           "--model</code>.</p>")


def _percent(share: float) -> str:
    return f"{100 * share:.0f} %" if share < 0.995 else "above 99 %"


def _value(number: float | None) -> str:
    return "unknown" if number is None else f"{number:.2g}"


def _unit(unit: str) -> str:
    return "" if unit == "1" else f" {unit}"
