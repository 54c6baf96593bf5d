"""A sweep's results as text for people: the plan, the run, the table."""

from __future__ import annotations

from typing import Any

from handgen.sweep.run import duration

FEW = 8
"""Columns of a table on a terminal, beside the axes."""


def planned(plan: dict[str, Any]) -> str:
    """How many, how long, how much."""
    lines = [f"{plan['name']}: {plan['variants']} variants ({plan['method']}, {plan['solver']}),"
             f" {plan['known']} known, {plan['missing']} to compute"]
    for name, axis in plan["axes"].items():
        values = f"{axis['values']} values" if axis["values"] else "drawn"
        lines.append(f"  {name}: {values}, sets {axis['sets']} number{'s' if axis['sets'] > 1 else ''}")
    if plan["missing"] and plan["seconds"] is not None:
        lines.append(f"{plan['seconds_each']:.2g} s a variant, {plan['workers']} workers:"
                     f" {duration(plan['seconds'])}; {plan['store_MB']:.3g} MB of disk,"
                     f" about {plan['memory_MB']:.0f} MB of memory")
    for one in plan["tried"]:
        if one["reason"] or one["rules_broken"]:
            lines.append("note: one that was tried " + (
                f"is {one['status']}: {one['reason']}" if one["reason"] else f"breaks {one['rules_broken']}"))
    if plan["confirms"]:
        lines.append(f"then the best {plan['confirms']} are confirmed, which is not counted here")
    if plan["base_breaks"]:
        lines.append(f"warning: the base file breaks {', '.join(plan['base_breaks'])}")
    return "\n".join(lines)


def ran(result: dict[str, Any]) -> str:
    """What came of a run."""
    statuses = ", ".join(f"{count} {status}" for status, count in sorted(result["statuses"].items()))
    lines = [f"{result['variants']} variants: {statuses}; {result['computed']} computed,"
             f" {result['reused']} known before"]
    for found in result["reasons"]:
        such = ", such as" if found["rows"] > 1 else ""
        lines.append(f"  {found['rows']} {found['status']}{such}: {found['reason']}")
    for what, told in (("rules_broken", "break"), ("bounds_missed", "miss")):
        lines += [f"  {rows} {told} {name}" for name, rows in sorted(result[what].items())]
    if result["best"]:
        lines += ["", *_rows(result["best"][:5], result)]
    elif result["objectives"] and not result["feasible"]:
        lines.append("no variant keeps to every rule and constraint")
    if result["confirmed"]:
        lines += ["", "confirmed:", *_rows(result["confirmed"], result, "rules_broken")]
        if not result["held"]:
            lines.append("none of them keeps to every rule and constraint")
    lines += ["", *(f"kept: {file}" for file in result["kept"])]
    return "\n".join([*lines, f"results: {result['results']}"])


def _rows(rows: list[dict[str, Any]], result: dict[str, Any], *more: str) -> list[str]:
    shown = ["variant", *result["axes"], *result["objectives"], *result["constraints"],
             *(name for name in more if any(row.get(name) for row in rows))]
    heads = [name.split(".")[-1] if name in result["axes"] else name for name in shown]
    cells = [[_cell(row.get(name)) for name in shown] for row in rows]
    widths = [max(len(head), *(len(row[i]) for row in cells)) + 2 for i, head in enumerate(heads)]
    return ["".join(text.rjust(width) for text, width in zip(line, widths, strict=True))
            for line in (heads, *cells)]


def _cell(value: Any) -> str:
    return "" if value is None else f"{value:.4g}" if isinstance(value, float) else str(value)


def shown(document: dict[str, Any]) -> str:
    """What a sweep found: the best rows and what each axis does."""
    statuses = ", ".join(f"{count} {status}" for status, count in sorted(document["statuses"].items()))
    lines = [f"{document['name']}: {document['variants']} variants: {statuses}"]
    if document["best"]:
        lines += ["", *_rows(document["best"], document)]
    for name, found in document["effects"].items():
        sobol = found["sobol"]
        told = sobol.get("reason") or f"polynomial's R2 {sobol['r2']:.3f}"
        lines += ["", f"{name}{'range of means':>34}{'S1':>8}{'ST':>8}   {told}"]
        for axis, main in sorted(found["main"].items(), key=lambda pair: -pair[1]["range"]):
            one = sobol.get("axes", {}).get(axis)
            indices = f"{one['S1']:>8.2f}{one['ST']:>8.2f}" if one else ""
            lines.append(f"  {axis:<{len(name) + 18}}{main['range']:>14.4g}{indices}")
    return "\n".join([*lines, "", f"page: {document['page']}"])
