"""A timeline as a drawing: one row for the hands, one for each actuator; SVG that prints."""

from __future__ import annotations

from html import escape
from math import ceil

from handgen.worksheet.timeline import ASSEMBLE, CURE, DEMOULD, MIX, OPEN, POUR, WIND, Step, Timeline

FILLS = {WIND: "#b7402a", ASSEMBLE: "#5a7fa8", MIX: "#7a5aa8", POUR: "#e09a2f", CURE: "#ded6bd",
         OPEN: "#4f8f5b", DEMOULD: "#2f6f3b"}
WORDS = {WIND: "wind", ASSEMBLE: "close mould", MIX: "mix", POUR: "pour", CURE: "cure",
         OPEN: "open, close again", DEMOULD: "demould"}
LEFT, WIDE, ROW, TOP = 110.0, 860.0, 20.0, 24.0
"""Of names, of the chart, of a row, above it; in the drawing's own units."""
MOST_TICKS = 14


def chart(timeline: Timeline, actuators: list[str]) -> str:
    """The drawing as an SVG element."""
    rows = {"hands": 0, **{name: i + 1 for i, name in enumerate(actuators)}}
    scale = WIDE / timeline.end
    height = TOP + ROW * len(rows) + 26
    shapes = [_axis(timeline.end, scale, TOP + ROW * len(rows)), *(_name(n, i) for n, i in rows.items())]
    for step in timeline.steps:
        who = step.actuators if step.what != MIX else ()
        hands = () if step.what == CURE else ("hands",)
        shapes += [_bar(step, rows[row], scale) for row in (*who, *hands)]
    shapes.append(_key(TOP + ROW * len(rows) + 18))
    return (f'<svg viewBox="0 0 {LEFT + WIDE + 10:.0f} {height:.0f}" role="img" '
            f'aria-label="timeline of {timeline.end / 60:.1f} hours">{"".join(shapes)}</svg>')


def _axis(end: float, scale: float, bottom: float) -> str:
    hours = end / 60
    step = next(s for s in (1, 2, 4, 6, 12, 24, 48, ceil(hours)) if hours / s <= MOST_TICKS)
    marks = [(h, LEFT + 60 * h * scale) for h in range(0, int(hours) + 1, step)]
    return "".join(
        f'<line x1="{x:.1f}" x2="{x:.1f}" y1="{TOP - 4}" y2="{bottom:.1f}" stroke="#ccc"/>'
        f'<text x="{x:.1f}" y="{TOP - 8}" text-anchor="middle">{h} h</text>' for h, x in marks)


def _name(name: str, row: int) -> str:
    return (f'<text x="{LEFT - 8}" y="{TOP + ROW * row + 14:.1f}" text-anchor="end">'
            f'{escape(name.replace("_", " "))}</text>')


def _bar(step: Step, row: int, scale: float) -> str:
    x, width = LEFT + step.start * scale, max((step.end - step.start) * scale, 0.6)
    text = ""
    if step.what == CURE and width > 50:
        text = (f'<text x="{x + width / 2:.1f}" y="{TOP + ROW * row + 14:.1f}" text-anchor="middle">'
                f'{"outer" if step.layer == 1 else "inner"} layer</text>')
    return (f'<rect x="{x:.1f}" y="{TOP + ROW * row + 2:.1f}" width="{width:.1f}" height="{ROW - 4}" '
            f'fill="{FILLS[step.what]}"><title>{WORDS[step.what]}</title></rect>{text}')


def _key(y: float) -> str:
    step = (LEFT + WIDE) / len(WORDS)
    return "".join(
        f'<rect x="{i * step:.1f}" y="{y - 9:.1f}" width="10" height="10" fill="{FILLS[what]}"/>'
        f'<text x="{i * step + 14:.1f}" y="{y:.1f}">{words}</text>'
        for i, (what, words) in enumerate(WORDS.items()))
