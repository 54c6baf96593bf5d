"""GLB for viewers: a named, coloured node for every part of the assembled hand.

glTF 2.0 wants metres and y upwards; a root node turns z dorsal into y up and scales the
millimetres of the meshes, so that positions stay those of the STL files.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Iterable

import numpy as np

ARRAY, ELEMENTS = 34962, 34963
FLOAT, UNSIGNED = 5126, 5125
TO_METRES_Y_UP = [0.001, 0, 0, 0, 0, 0, -0.001, 0, 0, 0.001, 0, 0, 0, 0, 0, 1]
"""Columns of p -> (x, z, -y) / 1000."""
Node = tuple[str, np.ndarray, np.ndarray, tuple[float, float, float]]


def to_bytes(name: str, nodes: Iterable[Node]) -> bytes:
    """A GLB file of `nodes`: (name, vertices (n, 3) in mm, faces (m, 3), sRGB colour 0..1)."""
    scene: dict = {key: [] for key in ("nodes", "meshes", "materials", "accessors", "bufferViews")}
    scene["nodes"].append({"name": name, "matrix": TO_METRES_Y_UP, "children": []})
    blob = bytearray()

    def accessor(array: np.ndarray, kind: str, target: int, component: int, **bounds) -> int:
        scene["bufferViews"].append(
            {"buffer": 0, "byteOffset": len(blob), "byteLength": array.nbytes, "target": target})
        scene["accessors"].append({"bufferView": len(scene["bufferViews"]) - 1, "componentType": component,
                                   "count": len(array), "type": kind, **bounds})
        blob.extend(array.tobytes())
        return len(scene["accessors"]) - 1

    for label, vertices, faces, colour in nodes:
        points = np.ascontiguousarray(vertices, "<f4")
        corners = np.ascontiguousarray(faces, "<u4").reshape(-1)
        primitive = {
            "attributes": {"POSITION": accessor(
                points, "VEC3", ARRAY, FLOAT,
                min=points.min(axis=0).tolist(), max=points.max(axis=0).tolist())},
            "indices": accessor(corners, "SCALAR", ELEMENTS, UNSIGNED),
            "material": len(scene["materials"]),
        }
        scene["materials"].append({"name": label, "pbrMetallicRoughness": {
            "baseColorFactor": [*_linear(colour), 1.0], "metallicFactor": 0.0, "roughnessFactor": 0.7}})
        scene["nodes"][0]["children"].append(len(scene["nodes"]))
        scene["nodes"].append({"name": label, "mesh": len(scene["meshes"])})
        scene["meshes"].append({"name": label, "primitives": [primitive]})
    return _pack({"asset": {"version": "2.0", "generator": "handgen"}, "scene": 0,
                  "scenes": [{"nodes": [0]}], "buffers": [{"byteLength": len(blob)}], **scene}, bytes(blob))


def _linear(colour: tuple[float, float, float]) -> list[float]:
    """sRGB to the linear values that glTF asks for (IEC 61966-2-1)."""
    return [round(c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4, 6) for c in colour]


def _pack(document: dict, blob: bytes) -> bytes:
    text = json.dumps(document, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    chunks = b"".join(struct.pack("<I4s", len(chunk), kind) + chunk
                      for kind, chunk in ((b"JSON", text), (b"BIN\0", blob)))
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks
