"""The page as one text: template, style, scripts, the design's numbers."""

from __future__ import annotations

import json
from collections.abc import Mapping
from importlib import resources
from pathlib import Path
from string import Template
from typing import Any

from handgen import __version__
from handgen.bending.result import Bend
from handgen.builder.survey import Survey
from handgen.report import bends, curves, making, markup, scenes, sections, three
from handgen.report.buffers import Buffer
from handgen.report.dimensions import dimensions
from handgen.report.downloads import downloads

ASSETS = "assets"
SCRIPTS = ("data.js", "stage.js", "parts.js", "markers.js", "pressure.js", "main.js")
"""In the order in which they are read."""
LIVE = "live.js"
"""Only in a page that `handgen view` serves."""


def page(survey: Survey, bent: Mapping[str, Bend], missing: Mapping[str, str], folder: Path,
         serial: int | None = None) -> str:
    """The whole page; `folder` is where it will lie. With a `serial` it asks its server for a newer one.

    Raises:
        EngineError: no three.js is found.
    """
    buffer = Buffer()
    stage = scenes.Stage(survey, buffer)
    listed = [scene.row() for scene in stage.scenes()]
    moving = bends.scene(stage, bent)
    if moving is not None:
        listed.insert(1 if survey.loaded.hand.palm else 0, moving)
    drawn = curves.draw(bent)
    measured = dimensions(survey)
    embedded = downloads(survey, bent, measured)
    panels = [sections.glance(survey, bent), sections.findings(survey),
              sections.bending(bent, missing, drawn, moving is not None), sections.dimensions(measured),
              making.section(survey, folder), sections.adapted(survey), sections.downloads(survey, embedded)]
    data = {"name": survey.loaded.hand.name, "scenes": listed, "meshes": stage.meshes,
            "findings": survey.report["findings"], "ranks": sections.ranks(survey.report),
            "curves": drawn.data if drawn else {}, "downloads": embedded}
    hand = survey.loaded.hand
    return fill(title=f"{hand.name}: report", name=hand.name, description=hand.description or "",
                verdict=sections.verdict(survey), panels="\n".join(filter(None, panels)), data=data,
                buffer=buffer.text(), serial=serial)


def fill(*, title: str, name: str, description: str, verdict: str, panels: str, data: Any, buffer: str,
         serial: int | None) -> str:
    """The template with its places filled; `verdict` and `panels` are HTML."""
    scripts = SCRIPTS if serial is None else [*SCRIPTS, LIVE]
    return Template(asset("page.html")).substitute(
        connect="'none'" if serial is None else "'self'", serial="" if serial is None else serial,
        version=__version__, title=markup.text(title),
        name=markup.text(name), description=markup.text(description), verdict=verdict, panels=panels,
        style=asset("style.css"), data=inert(data), buffer=buffer, three=three.script(),
        script='"use strict";\n(() => {\n' + "\n".join(map(asset, scripts)) + "\n})();")


def waiting(name: str, serial: int) -> str:
    """What a server shows before the first page is ready: what is wrong with the file, then the page."""
    return Template(asset("waiting.html")).substitute(
        title=markup.text(name), serial=serial, style=asset("style.css"), script=asset(LIVE))


def inert(data: Any) -> str:
    """JSON that cannot end the script element that holds it."""
    return json.dumps(data, allow_nan=False, separators=(",", ":")).replace("<", "\\u003c")


def asset(name: str) -> str:
    return resources.files(__package__).joinpath(ASSETS, name).read_text(encoding="utf-8")
