"""manifest.json: what a build holds, how it was made, and how to recognise every file again."""

from __future__ import annotations

import json
from typing import Any

from handgen.geometry.measure import Facts
from handgen.geometry.part import Part

SCHEMA = "handgen.manifest/1"
KINDS = {".stl": "stl", ".step": "step", ".3mf": "3mf", "_thread.csv": "thread"}


def entry(part: Part, key: str, facts: Facts, step_volume: float, files: dict[str, str]) -> dict[str, Any]:
    """A part's row: measured on its STL, `step_volume_mm3` on its B-rep.

    `key` names the content: the same key gives the same files. `print_up` is the direction, in
    the part's frame, that points up on the print bed.
    """
    named = {kind: part.name + ending for ending, kind in KINDS.items() if part.name + ending in files}
    return {
        "name": part.name,
        "role": part.role,
        "material": part.material,
        "files": named,
        "volume_mm3": round(facts.volume_mm3, 3),
        "step_volume_mm3": round(step_volume, 3),
        "area_mm2": round(facts.area_mm2, 3),
        "bbox_mm": [[round(v, 4) for v in corner] for corner in facts.bbox_mm],
        "watertight": facts.watertight,
        "bodies": facts.bodies,
        "triangles": facts.triangles,
        "print_up": list(part.up),
        "sha256": files[named["stl"]],
        "key": key,
    }


def to_bytes(document: dict[str, Any]) -> bytes:
    """JSON with a fixed layout, so that equal builds have equal manifests."""
    return (json.dumps(document, indent=1, ensure_ascii=False, allow_nan=False) + "\n").encode()
