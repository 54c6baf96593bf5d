"""Results as tables for people: what `build`, `check`, `bend` and `measure` say on the terminal."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

Style = Callable[[str, str], str]
"""(text, ANSI style) -> the text in that style, where the terminal wants it."""
COLOURS = {"error": "31", "fail": "31", "warning": "33", "overridden": "33", "pass": "32", "skipped": "2",
           "info": "2"}
"""ANSI styles of severities and statuses."""


def built(result: dict[str, Any], style: Style) -> str:
    """What a maker wants to know: what is wrong and how to mend it, and where the files are."""
    lines = [_broken(f, style) for f in result["checks"]["findings"] if f["severity"] == "error"]
    verdict = style("passes", "32") if result["passed"] else style("fails", "31")
    files = f"see {result['out']}" if result["manifest"] else "nothing printable was written"
    return "\n".join([*lines, f"{result['name']} {verdict}; {files}"])


def _broken(finding: dict[str, Any], style: Style) -> str:
    """A finding in two lines: what and where, and what mends it."""
    where = finding["where"]
    place = "" if where is None else " at ({:.1f}, {:.1f}, {:.1f})".format(*where)
    head = style(f"{finding['severity']} {finding['rule']}", COLOURS[finding["severity"]])
    return f"{head} {finding['part']}{place}: {finding['message']}\n    mend: {finding['fix']}"


def checked(result: dict[str, Any], style: Style) -> str:
    """A line a rule, then every finding above `info`, the worst first."""
    report = result["checks"]
    lines = [f"{'rule':<22}{'status':<12}{'measured':>10}{'limit':>10}  {'unit':<7}what was judged"]
    for row in report["rules"]:
        status = style(f"{row['status']:<12}", COLOURS[row["status"]])
        lines.append(f"{row['rule']:<22}{status}{_figure(row['measured']):>10}{_figure(row['limit']):>10}"
                     f"  {row['unit']:<7}{row['reason']}")
    told = [f for severity in ("error", "warning") for f in report["findings"] if f["severity"] == severity]
    lines += ["", *(_broken(f, style) for f in told)] if told else []
    verdict = style("passes", "32") if result["passed"] else style("fails", "31")
    return "\n".join([*lines, "", f"{result['name']} {verdict}; pictures and checks.json: {result['out']}"])


def _figure(value: float | None) -> str:
    return "" if value is None else f"{value:.4g}"


COLUMNS = {"pressure_kPa": ("kPa", "g"), "tip_load_N": ("weight, N", "g"), "tip_drop_mm": ("drop, mm", ".1f"),
           "bend_angle_deg": ("bend, deg", ".1f"), "bend_angle_error_deg": ("+-, deg", ".1f"),
           "elongation_mm": ("longer, mm", ".1f"),
           "tip_force_N": ("force, N", ".3f"), "max_stretch": ("stretch", ".2f")}
"""Keys of a bend's points, their heads and formats; those that hold nothing are left out."""


def bent(document: dict[str, Any], reached: str, folder: str, style: Style) -> str:
    """A line a point, what is to be known of it behind, then how far it went and where the files are."""
    points = document["points"]
    bare = document["part"] == "exoskeleton"
    silent = {"pressure_kPa"} if bare else set() if any(p["tip_load_N"] for p in points) else {"tip_load_N"}
    shown = [key for key in COLUMNS if key not in silent and any(p.get(key) is not None for p in points)]
    lines = ["".join(f"{COLUMNS[key][0]:>12}" for key in shown)]
    for point in points:
        cells = ("" if point.get(key) is None else f"{point[key]:{COLUMNS[key][1]}}" for key in shown)
        words = "; ".join(filter(None, [point["note"], *point["flags"]]))
        row = ("".join(f"{cell:>12}" for cell in cells) + f"  {words}").rstrip()
        lines.append(row if point["converged"] else style(row, COLOURS["fail"]))
    complete = all(point["converged"] for point in points)
    lines += ["", *document["notes"], ""] if document["notes"] else [""]
    work = f"{document['factorisations']} factorisations of " if document["factorisations"] else ""
    spent = "solved before" if document["cached"] else (
        f"{work}{document['unknowns']} unknowns, {document['wall_s']:.1f} s")
    verdict = style(reached, COLOURS["pass" if complete else "fail"])
    return "\n".join([*lines, f"{document['name']} {document['finger']}: {verdict}; {spent}; see {folder}"])


def sliced(result: dict[str, Any], style: Style) -> str:
    """A line a slice: time, filament, layers; below it whatever differs from Table B.1, and warnings."""
    lines = [f"{'part':<34}{'slicer':<13}{'time':>9}{'filament':>11}{'mass':>9}{'layers':>8}"]
    for row in result["rows"]:
        lines.append(f"{row['part']:<34}{row['slicer']:<13}{hours(row['print_time_s']):>9}"
                     f"{row['filament_mm'] / 1000:>9.2f} m{row['filament_g']:>7.1f} g{row['layers']:>8}")
        lines += [style(f"    {r['row']}: {r['found']} instead of {r['asked']} {r['unit']}", COLOURS["fail"])
                  for r in row["table"] if r["equal"] is False]
        lines += [f"    {row['slicer']}: {warning}" for warning in row["warnings"]]
    told = sum(row["agrees"] for row in result["rows"])
    verdict = style(f"{told} of {len(result['rows'])} slices agree with the print settings",
                    COLOURS["pass" if result["passed"] else "fail"])
    return "\n".join([*lines, "", f"{result['name']}: {verdict}; see {result['out']}"])


def planned(result: dict[str, Any]) -> str:
    """Silicone by mix, the length of the day by moulds, and where the page is."""
    day = result["days"][str(result["mould_sets"])]
    silicone = sum(mix["a_g"] + mix["b_g"] for mix in result["mixes"])
    taken, least = (hours(3600 * day[key]) for key in ("hours", "at_least_hours"))
    lines = [f"{len(result['mixes'])} mixes, {silicone:.0f} g of silicone; the last actuator leaves its mould"
             f" after {taken}, no plan is shorter than {least}"]
    if result["prints"]["not_sliced"]:
        lines.append(f"{result['prints']['not_sliced']} parts have no print time: run `handgen slice` first")
    return "\n".join([*lines, f"{result['name']}: see {result['file']}"])


def hours(seconds: float) -> str:
    """Seconds as 2 h 05."""
    minutes = round(seconds / 60)
    return f"{minutes // 60} h {minutes % 60:02d}"


def validated(document: dict[str, Any], folder: str, style: Style) -> str:
    """Of every test each model's RMS and largest residual; what being stuck or weightless would change; the
    actuator with and without its thread."""
    lines = []
    for test in document["tests"]:
        lines += [style(test["title"], "1"), f"  {'':<24}{'RMS':>10}{'largest':>10}  {test['unit']}"]
        may = [load for load, allowed in zip(test["loads"], test["may_be_fitted"], strict=True) if allowed]
        for name, model in test["models"].items():
            lines.append(_off(name, model, "gap", "fitted" if model["fitted"] else "predicted", style))
            if may and len(may) < len(test["loads"]):
                words = f"up to {max(may):g} {test['load_unit']}"
                lines.append(_off("", model, "gap_where_fitting_is_allowed", words, style))
        if test["variants"]:
            lines += _compared(test)
    lines += [_balloon(balloon) for balloon in document["balloon"]]
    return "\n".join([*lines, f"{document['name']}; see {folder}"])


def _compared(test: dict[str, Any]) -> list[str]:
    """Rows of readings: measured, each model, and the same stuck to its bore and without own weight."""
    rows = {"measured": test["means"]}
    for name, model in test["models"].items():
        rows[name] = model["simulated"]
        rows |= {f"{name}, {what}": models[name]["simulated"] for what, models in test["variants"].items()}
    head = f"  {test['load_unit']:<24}" + "".join(f"{load:>7g}" for load in test["loads"])
    return [head, *(f"  {name:<24}" + "".join(f"{'-' if v is None else format(v, '.1f'):>7}" for v in row)
                    for name, row in rows.items())]


def _balloon(balloon: dict[str, Any]) -> str:
    parts = [f"{words} longer by {_figure(balloon[key]['elongation_mm'])}, wider by "
             f"{_figure(balloon[key]['widening_mm'])} mm at {balloon[key]['reached_kPa']:g} kPa"
             for key, words in (("wound", "with its thread"), ("bare", "without it"))]
    return f"free actuator, {balloon['model']}: {'; '.join(parts)}"


def _off(name: str, model: dict[str, Any], key: str, words: str, style: Style) -> str:
    gap = model[key]
    numbers = f"{'-':>10}{'-':>10}" if gap is None else f"{gap['rms']:>10.2f}{gap['largest']:>+10.2f}"
    relative = f"{100 * gap['rms_relative']:.1f} %, " if gap and gap["rms_relative"] is not None else ""
    line = f"  {name:<24}{numbers}  {relative}{words}"
    return line if model["complete"] else style(f"{line}; {model['reached']}", COLOURS["fail"])


def effects(document: dict[str, Any], style: Style) -> str:
    """Every effect with what it says, its numbers, where it shows and what settles it."""
    lines = []
    for one in document["effects"]:
        lines.append(f"{style(one['id'], '1')}: {one['name']}")
        for p in one["parameters"]:
            unit = "" if p["unit"] == "1" else f" {p['unit']}"
            usual = "either way" if p["usual"] is None else f"usually {p['usual']:.3g}"
            lines.append(f"    {p['name']:<11}{p['low']:g} to {p['high']:g}{unit}, absent at {p['null']:g}, "
                         f"{usual}: {p['meaning']}")
        lines += [f"    {what:<11}{one[what]}" for what in ("signature", "settle", "source")]
    return "\n".join(lines)


def reported(result: dict[str, Any], style: Style) -> str:
    """Where the page is, and what is missing on it."""
    lines = [f"{finger} is not bent: {why}" for finger, why in result["missing"].items()]
    verdict = style("passes", "32") if result["passed"] else style("fails", "31")
    return "\n".join([*lines, f"{result['name']} {verdict}, {result['findings']} findings; "
                              f"{result['page']} ({result['bytes'] / 1e6:.1f} MB)"])


def measured(report: dict[str, Any], style: Style) -> str:
    """Size, closed or not, walls: a line each."""
    low, high = ("({:.2f}, {:.2f}, {:.2f})".format(*corner) for corner in report["bbox_mm"])
    shells = f"bodies {report['bodies']}, voids {report['voids']}, inside out {report['inside_out']}"
    faults = ", ".join(f"{kind} {count}" for kind, count in report["edges"].items() if count)
    place = "" if not faults else ", one at ({:.2f}, {:.2f}, {:.2f})".format(*report["fault_at"])
    closed = f"no; edges: {faults}{place}" if faults else "yes" if report["watertight"] else "no"
    lines = [
        ("size", "{:.2f} x {:.2f} x {:.2f} mm".format(*report["size_mm"]) + f", from {low} to {high}"),
        ("volume", "none" if report["volume_mm3"] is None else f"{report['volume_mm3']:.6g} mm3"),
        ("area", f"{report['area_mm2']:.6g} mm2, {report['triangles']} triangles"),
        ("watertight", closed),
        ("shells", shells),
        *_walls(report),
        *(("hint", hint) for hint in report["hints"]),
    ]
    verdict = style("is sound", "32") if report["passed"] else style("is not sound", "31")
    return "\n".join([*(f"{name:<12}{text}" for name, text in lines), f"{report['file']} {verdict}"])


def _walls(report: dict[str, Any]) -> list[tuple[str, str]]:
    """The least wall with its place, and how the walls are spread over the surface."""
    walls = report["thickness"]
    if walls is None:
        return [("walls", f"not measured: {report['thickness_missing']}")]
    least = "{:.4g} mm at ({:.2f}, {:.2f}, {:.2f})".format(walls["least_mm"], *walls["at"])
    total = sum(row["area_mm2"] for row in walls["histogram"])
    spread = [("", f"{row['from_mm']:>6.1f} to {row['to_mm']:<6.1f} mm {row['area_mm2'] / total:>6.1%}")
              for row in walls["histogram"] if row["area_mm2"] > 0.0]
    shares = ", ".join(f"{p} %: {value:.3g}" for p, value in walls["percentiles_mm"].items())
    return [("least wall", least), ("walls, mm", shares), *spread]


VERDICTS = {"none": "nothing is missing that these readings could show", "named": "missing from the model",
            "pair": "more than one effect is missing from the model",
            "ambiguous": "these readings cannot decide between",
            "outside": "wrong in a way that no effect of the catalogue explains"}


def diagnosed(document: dict[str, Any], folder: str, style: Style) -> str:
    """What is missing and how sure that is, the three gaps, what to measure next, what was noticed."""
    word = document["verdict"]
    lines = [style(f"{word}: {VERDICTS[word]}", "32" if word == "none" else "33")]
    for effect in document["effects"]:
        lines.append(f"  {100 * effect['probability']:.1f} %  {effect['sentence']}")
    head = f"{'error at loads left out of the fit':<36}"
    if word == "ambiguous":
        for ids in (one["ids"] for one in document["classes"] if len(one["ids"]) > 1):
            more = [f"{len(ids) - 4} more"] if len(ids) > 4 else []
            lines.append(f"  {' or '.join(ids[:4] + more)}: no reading here tells them apart")
    lines += ["", head + "".join(f"{word:>11}" for word in ("as it was", "re-tuned", "patched"))]
    for test in document["gap"]["tests"]:
        gaps = [test["held_out"][state] for state in ("before", "retuned")]
        gaps.append(test["held_out"]["patched"] if document["patch"] else None)
        name = test["test"] + (", never fitted" if test["held_out_test"] else "") + f", {test['unit']}"
        lines.append(f"{name:<36}" + "".join(f"{'-' if g is None else f'{g:.2f}':>11}" for g in gaps))
    if document["next_test"]:
        lines += ["", f"measure next: {document['next_test']['words']}"]
    if document["measure_directly"]:
        one = document["measure_directly"]
        lines += ["", f"or settle {one['name']} without any model: {one['how']}"]
    if document["flags"]:
        lines += ["", *(f"noticed: {flag}" for flag in document["flags"])]
    return "\n".join([*lines, "", f"see {folder}/diagnosis.html; the model: {document['model']}"])
