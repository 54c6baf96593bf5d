"""HTML in small pieces: everything that comes from a file is escaped here."""

from __future__ import annotations

import html
from collections.abc import Iterable, Sequence

Cell = str | float | int | None


def text(value: object) -> str:
    return html.escape(str(value))


def number(value: float | None, places: int = 2) -> str:
    """Plain decimals without needless zeros; a dash for what is not known."""
    if value is None:
        return "&ndash;"
    shown = f"{value:.{places}f}"
    shown = shown.rstrip("0").rstrip(".") if "." in shown else shown
    return "0" if shown == "-0" else shown.replace("-", "&minus;")


def section(name: str, title: str, *content: str) -> str:
    return (f'<section id="{name}" aria-labelledby="{name}-title"><h2 id="{name}-title">{text(title)}</h2>\n'
            + "\n".join(filter(None, content)) + "\n</section>")


def table(caption: str, heads: Sequence[str], rows: Iterable[Sequence[str]], numeric: Iterable[int] = ()
          ) -> str:
    """`heads` and cells are HTML; a row's first cell is its head. `numeric`: columns set right."""
    right = set(numeric)

    def kind(column: int) -> str:
        return ' class="n"' if column in right else ""

    head = "".join(f'<th scope="col"{kind(i)}>{cell}</th>' for i, cell in enumerate(heads))
    body = "\n".join(
        "<tr>" + "".join(f'<th scope="row">{cell}</th>' if i == 0 else f"<td{kind(i)}>{cell}</td>"
                         for i, cell in enumerate(row)) + "</tr>" for row in rows)
    return (f'<div class="wide" tabindex="0" role="region" aria-label="{text(caption)}">'
            f"<table><caption>{text(caption)}</caption>"
            f"<thead><tr>{head}</tr></thead><tbody>\n{body}\n</tbody></table></div>")


def facts(pairs: Iterable[tuple[str, str]]) -> str:
    """Names and their values (HTML)."""
    return ('<dl class="facts">'
            + "".join(f"<div><dt>{text(name)}</dt><dd>{value}</dd></div>" for name, value in pairs) + "</dl>")


def folded(summary: str, *content: str) -> str:
    return f"<details><summary>{text(summary)}</summary>\n" + "\n".join(content) + "\n</details>"


def quiet(words: str) -> str:
    return f'<p class="quiet">{text(words)}</p>'
