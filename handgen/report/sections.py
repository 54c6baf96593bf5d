"""The page's text: findings, bends, dimensions, what was adapted and assumed, what to fetch."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from handgen.bending.result import Bend
from handgen.builder.survey import Survey
from handgen.geometry.actuator import adaptations
from handgen.report import making, markup
from handgen.report.curves import Curves
from handgen.report.dimensions import WORDS, Dimension

FAR = 0.05
"""mm of the measured from the asked dimension that is marked: more than the mesh's chords take."""
SHOW_BEND = '<p><button type="button" data-scene="bend">Show the hand under pressure</button></p>'
WORST = ("error", "warning", "info")
TOLD = (20.0, 60.0, 100.0)
"""kPa of the table of bends."""


def verdict(survey: Survey) -> str:
    findings = survey.report["findings"]
    errors = sum(f["severity"] == "error" for f in findings)
    warnings = sum(f["severity"] == "warning" for f in findings)
    word, kind = ("passes", "pass") if survey.report["passed"] else ("fails", "fail")
    return f'<p class="verdict {kind}">{word}: {_count(errors, "error")}, {_count(warnings, "warning")}</p>'


def glance(survey: Survey, bent: Mapping[str, Bend]) -> str:
    """The few numbers that say what it is."""
    mass = making.masses(survey)
    pairs = []
    if (hand := survey.parts.get(making.HAND)) is not None:
        low, high = hand.facts.bbox_mm
        size = " &times; ".join(f"{b - a:.0f}" for a, b in zip(low, high, strict=True))
        pairs += [("exoskeleton", f"{size} mm"), ("its mass, filled", f"{mass[making.HAND]:.0f} g")]
    silicone = [value for name, value in mass.items() if name.startswith("actuators/")]
    pairs += [("silicone in the actuators", f"{sum(silicone):.0f} g"), ("parts", str(len(survey.parts)))]
    if "index" in bent and (angle := _at(bent["index"], 60.0, "bend_angle_deg")) is not None:
        pairs.append(("index at 60 kPa", f"{angle:.0f}&deg;"))
    rules = survey.report["rules"]
    pairs.append(("rules passed", f"{sum(r['status'] == 'pass' for r in rules)} of {len(rules)}"))
    links = [("findings", "Findings"), ("bending", "Bend"), ("dimensions", "Dimensions"), ("making", "Print"),
             ("adapted", "Adapted, assumed"), ("downloads", "Downloads")]
    nav = "".join(f'<a href="#{name}">{title}</a>' for name, title in links)
    return markup.section("glance", "At a glance", markup.facts(pairs),
                          f'<nav aria-label="On this page" style="margin-top:.8rem">{nav}</nav>')


def ranks(report: Mapping[str, Any]) -> list[int]:
    """The number by which a reader finds each finding of the report: the worst come first, from 1."""
    order = sorted(range(len(report["findings"])),
                   key=lambda n: WORST.index(report["findings"][n]["severity"]))
    return [order.index(n) + 1 for n in range(len(order))]


def findings(survey: Survey) -> str:
    """Every finding, the worst first; choosing one shows its place on the model."""
    report, rank = survey.report, ranks(survey.report)
    numbered = list(enumerate(report["findings"]))
    lists = {kind: [_finding(n, rank[n], f) for n, f in numbered if f["severity"] == kind] for kind in WORST}
    told = lists["error"] + lists["warning"]
    content = [f'<ol class="findings">{"".join(told)}</ol>' if told else "<p>No rule is broken.</p>"]
    if lists["info"]:
        content.append(markup.folded(f"Worth knowing ({len(lists['info'])})",
                                     f'<ol class="findings">{"".join(lists["info"])}</ol>'))
    content.append(markup.folded(f"All rules ({len(report['rules'])})", _rules(report["rules"])))
    return markup.section("findings", "Findings", *content)


def _finding(index: int, rank: int, found: Mapping[str, Any]) -> str:
    where = "" if found["where"] is None else " at ({:.1f}, {:.1f}, {:.1f})".format(*found["where"])
    measured = "" if found["measured"] is None else f"measured {found['measured']:.4g} {found['unit']}"
    limit = "" if found["limit"] is None else f"limit {found['limit']:.4g} {found['unit']}"
    numbers = ", ".join(filter(None, (measured, limit)))
    severity = found["severity"]
    return (f'<li data-finding="{index}"><button type="button">'
            f'<span class="number {severity}">{rank}</span>'
            f'<b class="{severity}">{severity}</b> <b>{markup.text(found["rule"])}</b>'
            f'<br><span class="where">{markup.text(found["part"] + where)}</span></button>'
            f'<p>{markup.text(found["message"])}</p><p>Mend: {markup.text(found["fix"])}</p>'
            f'<p class="quiet">{markup.text("; ".join(filter(None, (numbers, found["source"]))))}</p></li>')


def _rules(rules: Iterable[Mapping[str, Any]]) -> str:
    return markup.table("Rules", ["rule", "status", "measured", "limit", "unit", "what was judged"], [
        (markup.text(r["rule"]), f'<span class="{r["status"]}">{r["status"]}</span>', _four(r["measured"]),
         _four(r["limit"]), markup.text(r["unit"]), markup.text(r["reason"])) for r in rules], (2, 3))


def bending(bent: Mapping[str, Bend], missing: Mapping[str, str], curves: Curves | None, shown: bool) -> str:
    """Curves and a few numbers of every finger; why a finger has none."""
    content = []
    if curves is not None:
        content.append(f"<figure>{curves.svg}</figure>")
        if shown:
            content.append(SHOW_BEND)
    if bent:
        some = next(iter(bent.values())).document
        content.append(markup.quiet(
            f"Every finger bent on its own, palm down, own weight on, model {some['model']}, solver "
            f"{some['solver']}. Dots were solved; between them slider and shape follow straight lines. "
            "Fingers do not feel one another or the palm."))
        heads = ["finger", *(f"{p:g} kPa" for p in TOLD), "reached", "to be known"]
        content.append(markup.table("Bend of the fingertips, degrees", heads,
                                    [_bent(*each) for each in bent.items()], range(1, len(TOLD) + 1)))
    content += [f"<p>{markup.text(f'{name}: {why}')}</p>" for name, why in missing.items()]
    return markup.section("bending", "Under pressure", *content) if content else ""


def _bent(name: str, found: Bend) -> tuple[str, ...]:
    flags = dict.fromkeys(flag.split(" strained")[0] + " strained beyond its law's data"
                          if " strained" in flag else flag
                          for point in found.document["points"] for flag in point["flags"])
    angles = (markup.number(_at(found, p, "bend_angle_deg"), 0) for p in TOLD)
    reached = found.reached.removeprefix("reached ")
    return (markup.text(name), *angles, markup.text(reached), markup.text("; ".join(flags)))


def dimensions(found: Iterable[Dimension]) -> str:
    """As built, over what the source says: a row a part and a column a dimension, as its tables have them."""
    found = list(found)
    return markup.section(
        "dimensions", "Dimensions as built",
        markup.quiet("Measured on the very triangles that are printed, mm; below each the source's "
                     f"value, and what was asked where the part leaves it by more than {FAR:g}."),
        *(_dimensions(title, [d for d in found if d.what.startswith(kind)])
          for kind, title in (("exoskeleton/", "Exoskeletons"), ("actuators/", "Actuators"))))


def _dimensions(title: str, found: list[Dimension]) -> str:
    keys = list(dict.fromkeys(d.name for d in found))
    title = ", ".join([title, *dict.fromkeys(d.where for d in found)])
    rows: dict[str, dict[str, Dimension]] = {}
    for each in found:
        rows.setdefault(each.what, {})[each.name] = each
    return markup.table(title, ["", *(WORDS[key] for key in keys)], [
        (markup.text(part.split("/")[1].replace("_", " ")), *(_dimension(row[key]) for key in keys))
        for part, row in rows.items()], range(1, len(keys) + 1))


def _dimension(found: Dimension) -> str:
    words = [f"source {markup.number(found.source)}" if found.source is not None else "source &ndash;"]
    off = found.source is not None and abs(found.source - found.measured) > FAR
    missed = abs(found.asked - found.measured) > FAR
    words += [f"asked {markup.number(found.asked)}"] if missed else []
    kind = ' class="warning"' if off or missed else ""
    return f'<b{kind}>{found.measured:.2f}</b><br><span class="quiet">{", ".join(words)}</span>'


def adapted(survey: Survey) -> str:
    """What was asked for and could not be, and what nobody gave."""
    changed = adaptations(survey.loaded.hand)
    reasons: dict[str, list[str]] = {}
    for each in survey.loaded.assumptions:
        reasons.setdefault(each["reason"], []).append(f"{each['path']} = {each['value']}")
    listed = [f"<h3>{markup.text(reason)}</h3>{_list(lines)}" for reason, lines in reasons.items()]
    content = [f"<p><b>{markup.text(a.path)}</b>: {markup.text(a.reason)} ({markup.text(a.source)})</p>"
               for a in changed] or ["<p>Nothing had to be adapted.</p>"]
    return markup.section("adapted", "Adapted and assumed", *content,
                          markup.folded(f"Assumptions ({len(survey.loaded.assumptions)})", *listed))


def _list(lines: Iterable[str]) -> str:
    return '<ul class="plain">' + "".join(f"<li>{markup.text(line)}</li>" for line in lines) + "</ul>"


def downloads(survey: Survey, embedded: Mapping[str, Mapping[str, str]]) -> str:
    """What is in the page, and the files beside it where there is a build."""
    inside = "".join(
        f'<li><button type="button" data-download="{key}">{markup.text(file["name"])}</button> '
        f'<span class="quiet">{markup.text(file["words"])}</span></li>' for key, file in embedded.items())
    content = [f"<h3>In this page</h3><ul>{inside}</ul>", _parts(survey)]
    return markup.section("downloads", "Parts and downloads", *content)


def _parts(survey: Survey) -> str:
    """Every part with its size; its files where a build of these parameters lies beside the page."""
    mass = making.masses(survey)
    files = {row["name"]: row["files"] for row in survey.built["parts"]} if survey.built else {}
    rows = []
    for name, each in survey.parts.items():
        size = " &times; ".join(f"{b - a:.1f}" for a, b in zip(*each.facts.bbox_mm, strict=True))
        links = " ".join(f'<a href="{markup.text(path)}" download>{markup.text(kind)}</a>'
                         for kind, path in files.get(name, {}).items())
        rows.append((markup.text(name), markup.text(each.part.material), size,
                     markup.number(each.facts.volume_mm3 / 1e3), markup.number(mass[name], 1),
                     *([links] if files else [])))
    words = ("Links lead to the build beside this page." if files else
             "No build of these parameters lies beside this page: `handgen build` writes STL, STEP and 3MF.")
    heads = ["part", "material", "size, mm", "cm3", "g, filled", *(["files"] if files else [])]
    return (f"<h3>Parts</h3>{markup.quiet(words)}"
            + markup.folded(f"All parts ({len(rows)})", markup.table("Parts", heads, rows, (3, 4))))


def _at(found: Bend, pressure: float, key: str) -> float | None:
    return next((p[key] for p in found.document["points"] if abs(p["pressure_kPa"] - pressure) < 1e-6), None)


def _four(value: float | None) -> str:
    return "" if value is None else f"{value:.4g}"


def _count(number: int, word: str) -> str:
    return f"{number} {word}{'' if number == 1 else 's'}"
