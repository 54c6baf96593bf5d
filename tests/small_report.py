"""A report page that costs seconds: the assembly, one mould, one finger bent a little, planted findings."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from handgen.bending import request, solve
from handgen.builder import jobs
from handgen.builder.survey import Survey, Surveyed
from handgen.geometry.assembly import assembly
from handgen.geometry.catalogue import catalogue
from handgen.geometry.measure import measure, read_stl
from handgen.parameters.load import load
from handgen.report.page import page

PARAMS = Path(__file__).parent.parent / "params"
FINGER = "little"
PRESSURES = [0, 15, 30]


def finding(part: str, where, severity: str = "warning", message: str = "planted <b>here</b>") -> dict:
    return {"rule": "wall.minimum", "severity": severity, "part": part, "measured": 1.0, "limit": 2.0,
            "unit": "mm", "where": None if where is None else [float(v) for v in where], "message": message,
            "fix": "mend it", "source": "a test"}


def report(findings: list[dict]) -> dict:
    rule = {"rule": "wall.minimum", "status": "fail", "measured": 1.0, "limit": 2.0, "unit": "mm",
            "reason": "planted"}
    return {"schema": "handgen.checks/1", "passed": not any(f["severity"] == "error" for f in findings),
            "findings": findings, "rules": [rule]}


def extreme(stl: Path, axis: int, sign: float) -> np.ndarray:
    """The corner of a printed mesh that lies farthest along an axis."""
    corners = read_stl(stl.read_bytes()).reshape(-1, 3)
    return corners[np.argmax(sign * corners[:, axis])].astype(float)


def surveyed(stage: Path) -> Survey:
    """The adult hand with the parts of its assembly, its little finger, and that finger's mould."""
    loaded = load(PARAMS / "adult.yaml")
    listed = catalogue(loaded.hand)
    names = [seated.name for seated in assembly(loaded.hand)]
    names += [name for name in listed if name.startswith(("exoskeleton/", f"tooling/{FINGER}/"))]
    parts = {}
    for name in dict.fromkeys(names):
        jobs.mesh(listed[name], stage, {})
        stl = stage / f"{name}.stl"
        parts[name] = Surveyed(listed[name], stl, measure(read_stl(stl.read_bytes())))
    tip = extreme(parts["exoskeleton/hand"].stl, 0, 1.0)
    inside = extreme(parts[f"actuators/{FINGER}"].stl, 0, 1.0)
    mould = f"tooling/{FINGER}/mould_a"
    findings = [finding("exoskeleton/hand", tip), finding(f"actuators/{FINGER}", inside, "info"),
                finding(mould, extreme(parts[mould].stl, 2, -1.0)),
                finding("exoskeleton/hand", None)]
    keys = {name: listed[name].key for name in parts}
    return Survey(loaded, parts, report(findings), None, keys)


def bent(survey: Survey):
    return {FINGER: solve(request(survey.loaded, finger=FINGER, pressures=PRESSURES), keep=False)}


def written(survey: Survey, bends: dict, folder: Path, serial: int | None = None) -> str:
    return page(survey, bends, {"thumb": "left out by a test"}, folder, serial)
