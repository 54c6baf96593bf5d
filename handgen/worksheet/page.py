"""The worksheet as one HTML file: no network, no script, and a style for paper."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from html import escape

from handgen import __version__, tables
from handgen.slicing.printer import printer
from handgen.worksheet import bill, prints, steps
from handgen.worksheet.chart import WORDS, chart
from handgen.worksheet.prints import Print
from handgen.worksheet.sheet import Sheet
from handgen.worksheet.silicone import FIRST, SECOND, TIP, Portion
from handgen.worksheet.style import STYLE
from handgen.worksheet.timeline import CURE, POUR, Step, Timeline

LAYERS = {FIRST: "outer layer", SECOND: "inner layer"}
TIPS = " Tips are filled afterwards, from a mix of their own and with a cure of their own."
SLICERS = {"prusaslicer": "PrusaSlicer", "cura": "Cura"}
SOURCE = "the source printed its hand in about 30 h and weighed 92 g (Section 4.2.3, Equation 5.1)"


def page(sheet: Sheet) -> str:
    """The whole file."""
    hand = sheet.loaded.hand
    body = "".join((
        f"<h1>Worksheet: {escape(hand.name)}</h1>",
        f'<p class="lead">{escape(hand.description)}. Times in hours and minutes; everything marked'
        " <i>assumed</i> in the parameter file is a guess until you have done it once.</p>",
        _section("1. Print", _printing(sheet)),
        _section("2. Buy", _bill(sheet)),
        _section("3. Silicone and thread", _portions(sheet), "sheet"),
        _section("4. The day of the castings", _day(sheet)),
        *(_section(f"5.{i} {_words(name)}", _actuator(sheet, name), "sheet")
          for i, name in enumerate(sheet.pours, 1)),
        _section("6. After the last mould", _list(steps.post_cure(hand, sheet.day.end))),
        _section("7. Put it together", _list(steps.assembling(hand))),
        _section("8. What is assumed here", _assumptions(sheet)),
        f"<footer>handgen {__version__}; parameters {sheet.loaded.sha256[:12]}</footer>",
    ))
    return ('<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">'
            '<meta name="viewport" content="width=device-width, initial-scale=1">'
            f"<title>Worksheet: {escape(hand.name)}</title><style>{STYLE}</style></head>"
            f"<body><main>{body}</main></body></html>\n")


# Printing


def _printing(sheet: Sheet) -> str:
    rows = [_print_row(one) for one in sheet.prints]
    seconds, grams, unknown = prints.total([one for one in sheet.prints if one.needed])
    told = f"All that is needed: {tables.hours(seconds)}, {grams:.0f} g of filament."
    if unknown:
        told = f"<b>{unknown} parts have no time yet:</b> run <code>handgen slice</code> first."
    machine = escape(printer(sheet.loaded.hand.printing).name)
    told = (f"<p>{told} Numbers in brackets do not stand on the part: mark it yourself. Profiles lie in"
            f" <code>slicer_profiles/</code>, G-code for the {machine} in <code>slices/</code>.</p>")
    head = ["", "on the part", "part", "profile", "stands on", "PrusaSlicer", "Cura", "filament"]
    return told + _table(head, rows) + _why_other_than_the_source(sheet)


def _print_row(one: Print) -> list[str]:
    times = [tables.hours(one.slices[s]["print_time_s"]) if s in one.slices else "" for s in SLICERS]
    mass = f"{one.slice['filament_g']:.1f} g" if one.slice else ""
    number = f"<b>{escape(one.number)}</b>" if one.embossed else f"({escape(one.number)})"
    name = one.part.name.removeprefix("tooling/").replace("/", " / ").replace("_", " ")
    trial = "" if one.needed else " <small>for trials only</small>"
    bed = {"none": "the plate", "skirt": "the plate"}.get(one.profile.adhesion, f"a {one.profile.adhesion}")
    if one.profile.support != "none":
        bed += ", supported"
    return ["&#9744;", number, escape(name) + trial, escape(one.profile.name), bed, *times, mass]


def _why_other_than_the_source(sheet: Sheet) -> str:
    """The hand's time and mass beside the source's."""
    one = next((p for p in sheet.prints if p.profile.column == "hand"), None)
    if one is None or sheet.hand_volume is None:
        return ""
    process, volume = one.profile.process, sheet.hand_volume
    hours = prints.least_hours(volume, one.profile)
    mass = volume * process.density / 1000
    found = "; ".join(f"{SLICERS[s]} {tables.hours(row['print_time_s'])} and {row['filament_g']:.0f} g"
                      for s, row in one.slices.items()) or "not sliced yet"
    return (
        f"<p><b>The hand:</b> {found}; {SOURCE}. Why they differ: lines of {process.nozzle_size:g} x"
        f" {process.layer_height:g} mm at {process.speed:g} mm/s fill the {volume / 1000:.0f} cm3 of this"
        f" hand in no less than {hours:.0f} h, and it then weighs {mass:.0f} g; {process.flow:g} % flow,"
        " support and travel come on top. 30 h and 92 g both fit about 70 % of the source's 111 cm3: its"
        " print was probably not full.</p>")


# Materials


def _bill(sheet: Sheet) -> str:
    prices = sheet.loaded.hand.prices
    rows = [[escape(line.item), escape(line.amount), _number(line.grams, "g"), _number(line.ml, "ml"),
             "" if line.price is None else f"{line.price:.2f}", escape(line.note)] for line in sheet.bill]
    total, without = bill.cost(sheet.bill)
    rows.append(["<b>together</b>", "", "", "", f"<b>{total:.2f}</b>",
                 escape(f"without {', '.join(without)}" if len(without) < len(sheet.bill) else
                        "no prices: give them in the parameter file")
                 if without else ""])
    extra = _table(["", "and, not in the sum"],
                   [["&#9744;", escape(f"{what}: {why}")] for what, why in bill.CONSUMABLES])
    head = ["material", "amount", "mass", "volume", prices.currency, ""]
    return _table(head, rows, numbers=(2, 3, 4)) + extra


def _portions(sheet: Sheet) -> str:
    hand = sheet.loaded.hand
    rows = []
    for name, made in sheet.pours.items():
        for pour in made:
            mixed = Portion.of(pour.ml, hand.casting)
            rows.append([escape(_words(name)), LAYERS.get(pour.layer, "tip"), f"{pour.cavity / 1000:.2f}",
                         f"{pour.cup / 1000:.2f}", *(f"{amount:.1f}" for amount in (
                             mixed.a_g, mixed.b_g, mixed.a_ml, mixed.b_ml))])
    wound = [[escape(_words(w.actuator)), f"{escape(w.material)} {w.diameter:g} mm", f"{w.pitch:g} mm",
              f"{w.turns:.1f}", f"{w.length / 1000:.2f} m", f"{w.cut / 1000:.2f} m"] for w in sheet.windings]
    return (f"<p>{escape(hand.casting.silicone.name)}, {hand.casting.silicone.density:g} g/cm3, with"
            f" {hand.casting.mixing_loss:g} % for cup and stirrer; several moulds share a mix, see 4.</p>"
            + _table(["actuator", "pour", "layer, ml", "cup, ml", "A, g", "B, g", "A, ml", "B, ml"], rows,
                     numbers=range(2, 8))
            + _table(["actuator", "thread", "pitch", "turns", "wound", "cut"], wound, numbers=range(2, 6)))


# The day


def _day(sheet: Sheet) -> str:
    hand, day = sheet.loaded.hand, sheet.day
    compared = [[f"{n}", tables.hours(60 * t.end), f"{len(t.mixes)}", _proof(t)]
                for n, t in sorted(sheet.timelines.items())]
    mixes = {id(mix): (pours, sheet.mixed(pours)) for mix, pours in day.mixes}
    rows = [_moment(step, mixes.get(id(step)), hand.casting.silicone.pot_life)
            for step in day.steps if step.what not in (CURE, POUR)]
    return "".join((
        _list(steps.preparation(hand)), f"<p>{escape(steps.mixing(hand))}</p>",
        chart(day, list(sheet.pours)),
        _table(["moulds filled at once", "until the last is out", "mixes", "any shorter?"], compared),
        "<p>One pair of hands. Cures are least times: a night may fall into any of them."
        f"{TIPS * any(pour.layer == TIP for made in sheet.pours.values() for pour in made)}</p>",
        f'<div class="sheet">{_table(["", "from", "to", "do", "actuator", "silicone"], rows)}</div>'))


def _proof(timeline: Timeline) -> str:
    if timeline.gap < 0.0005:
        return "no"
    return f"by {100 * (1 - timeline.bound / timeline.end):.1f} % at most"


def _moment(step: Step, mix: tuple[list[Step], Portion] | None, pot_life: float) -> list[str]:
    clock = [tables.hours(60 * step.start), tables.hours(60 * step.end)]
    if mix is None:
        layer = f" ({LAYERS[step.layer]})" if step.layer and step.what != "assemble" else ""
        who = escape(", ".join(map(_words, step.actuators)))
        return ["&#9744;", *clock, WORDS[step.what] + layer, who, ""]
    pours, portion = mix
    clock[1] = tables.hours(60 * pours[-1].end)
    latest = tables.hours(60 * (step.start + pot_life))
    amounts = (f"A {portion.a_g:.1f} g + B {portion.b_g:.1f} g "
               f"<small>({portion.a_ml:.1f} + {portion.b_ml:.1f} ml), full by {latest}</small>")
    fills = ", ".join(f"{_words(p.actuators[0])} ({LAYERS[p.layer].split()[0]})" for p in pours)
    return ["&#9744;", *clock, "<b>mix and pour</b>", escape(fills), amounts]


# Actuators


def _actuator(sheet: Sheet, name: str) -> str:
    winding = next(w for w in sheet.windings if w.actuator == name)
    numbers = sheet.numbers(name)
    groups = steps.actuator(sheet.loaded.hand, winding, sheet.pours[name], numbers)
    words = "".join(f"<h3>{escape(title)}</h3>{_list(todo, numbers.values())}" for title, todo in groups)
    shown = "".join(f'<img src="{uri}" alt="{escape(_words(name))}: {what}">'
                    for uri, what in zip(sheet.pictures.get(name, ()), ("its tooling", "its two pours"),
                                         strict=False))
    return f'<div class="two"><div>{words}</div><div class="shown">{shown}</div></div>'


# Pieces


def _assumptions(sheet: Sheet) -> str:
    wanted = ("casting.", "seal.", "prices", "printing.", "thread.pitch")
    rows = [[f"<code>{escape(a['path'])}</code>", escape(str(a["value"])), escape(a["reason"])]
            for a in sheet.loaded.assumptions if a["path"].startswith(wanted)]
    return _table(["parameter", "value", "why"], rows)


def _section(title: str, content: str, kind: str = "") -> str:
    return f'<section class="{kind}"><h2>{escape(title)}</h2>{content}</section>'


def _list(todo: Iterable[str], numbers: Iterable[str] = ()) -> str:
    """Boxes to tick; part `numbers` stand out from the words (one of them is "If")."""
    lines = "".join(f"<li>{escape(line)}</li>" for line in todo)
    if found := "|".join(map(re.escape, numbers)):
        lines = re.sub(rf"\b({found})\b", r"<b>\1</b>", lines)
    return f'<ul class="todo">{lines}</ul>'


def _table(head: Sequence[str], rows: Sequence[Sequence[str]], numbers: Iterable[int] = ()) -> str:
    """`rows` are HTML already; columns `numbers` are set to the right."""
    right = set(numbers)

    def cells(row: Sequence[str], tag: str) -> str:
        marks = (" class=n" if i in right else "" for i in range(len(row)))
        return "".join(f"<{tag}{mark}>{cell}</{tag}>" for mark, cell in zip(marks, row, strict=True))

    lines = "".join(f"<tr>{cells(row, 'td')}</tr>" for row in rows)
    return (f'<div class="wide"><table><thead><tr>{cells([escape(h) for h in head], "th")}</tr></thead>'
            f"<tbody>{lines}</tbody></table></div>")


def _number(value: float | None, unit: str) -> str:
    return "" if value is None else f"{value:.1f} {unit}"


def _words(name: str) -> str:
    return name.replace("_", " ")
