"""Acceptance: what a build writes loads in PrusaSlicer as it is, with nothing to repair."""

import re
import subprocess

import pytest

from handgen.builder import build
from handgen.export import stl, threemf
from handgen.geometry.catalogue import catalogue
from tests.conftest import PARAMS
from tests.sliced import box, needs_slicers

REPAIRED = ("edges_fixed", "degenerate_facets", "facets_removed", "facets_reversed", "open_edges",
            "backwards_edges", "repair", "warning", "error")
"""What PrusaSlicer lists of a mesh that it had to mend."""


def info(file):
    """What PrusaSlicer says of a model file."""
    done = subprocess.run(["prusa-slicer", "--info", str(file)], capture_output=True, text=True, check=True)
    facts = dict(re.findall(r"^(\w+) = +(.+)$", done.stdout, re.M))
    told = done.stdout.lower() + re.sub(r"^\[.*\[trace\].*$", "", done.stderr, flags=re.M).lower()
    return facts, [word for word in REPAIRED if word in told]


@needs_slicers
def test_a_mesh_with_a_hole_is_found_out(tmp_path):
    mesh = box(10.0, 10.0, 10.0)
    file = tmp_path / "holed.stl"
    file.write_bytes(stl.to_bytes(mesh._replace(faces=mesh.faces[1:])))
    facts, mended = info(file)
    assert facts["manifold"] == "no" or mended


@needs_slicers
def test_a_finger_and_a_mould_load_without_repair(adult, tmp_path):
    for name in ("exoskeleton/little", "tooling/little/suspender"):
        part = catalogue(adult)[name]
        meshes = {"stl": stl.to_bytes(part.triangles),
                  "3mf": threemf.to_bytes(part.triangles, "part", part.material, part.colour)}
        for ending, content in meshes.items():
            file = tmp_path / f"part.{ending}"
            file.write_bytes(content)
            facts, mended = info(file)
            assert (facts["manifold"], facts["number_of_parts"].strip(), mended) == ("yes", "1", []), name
            assert float(facts["volume"]) == pytest.approx(part.mesh.volume, rel=1e-4)


@pytest.mark.slow
@needs_slicers
def test_every_file_of_a_build_loads_without_repair(tmp_path):
    """Acceptance 2 of the issue; what is not built as 3MF is written as one here."""
    built = build(PARAMS / "adult.yaml", tmp_path)
    listed = catalogue_of_the_adult()
    for row in built["manifest"]["parts"]:
        part = listed[row["name"]]
        files = [tmp_path / row["files"][kind] for kind in ("stl", "3mf") if kind in row["files"]]
        if "3mf" not in row["files"]:
            files.append(tmp_path / "part.3mf")
            files[-1].write_bytes(threemf.to_bytes(part.triangles, "part", part.material, part.colour))
        for file in files:
            facts, mended = info(file)
            assert (facts["manifold"], facts["number_of_parts"].strip(), mended) == ("yes", "1", []), file
            assert float(facts["volume"]) == pytest.approx(row["volume_mm3"], rel=1e-4)


def catalogue_of_the_adult():
    from handgen.parameters.load import load

    return catalogue(load(PARAMS / "adult.yaml").hand)
