"""Rules on fused filament: lines and overhangs."""

import dataclasses
import math
from types import SimpleNamespace

import numpy as np
import pytest

from handgen.checks.fff import line_for, line_width, overhang, printed, slices
from handgen.checks.hanging import Bed, angles, patches, steep
from handgen.checks.limits import standard
from handgen.checks.printing import watertight
from handgen.checks.sections import Triangles
from handgen.geometry import csg
from handgen.geometry.finger import exoskeleton
from handgen.geometry.measure import measure, measure_mesh
from handgen.geometry.mesh_kernel import evaluate, printable, triangles
from handgen.geometry.part import Part
from handgen.geometry.tooling import tooling
from tests.variant import changed, limits, named

UP = (0.0, 0.0, 1.0)


def surface(shape):
    return Triangles.of(printable(evaluate(shape)))


def part(shape, up=UP, role="plug", name="tooling/index/plug"):
    return named([Part(name, role, "PLA", shape, (0.5, 0.5, 0.5), "seal", up)])


def tube(outer, wall, length=20.0):
    """Along x, so that it stands on its end when x is up."""
    return csg.cylinder(outer, 0.0, length) - csg.cylinder(outer - wall, -1.0, length + 1.0)


def errors(outcome):
    return [f for f in outcome.findings if f.severity == "error"]


def standing(hand):
    """The index finger on its root: its layers are plain rings."""
    return {"exoskeleton/index": dataclasses.replace(exoskeleton(hand, "index"), up=(1.0, 0.0, 0.0))}


class TestLineWidth:
    @pytest.mark.parametrize("wall", [0.4, 0.8, 1.7, 3.1])
    def test_walls_of_a_tube(self, adult, wall):
        (item,) = printed(adult, part(tube(8.0, wall), (1.0, 0.0, 0.0)))
        for layer in slices(item):
            assert layer.thickness.min() == pytest.approx(wall, abs=0.012)
            assert layer.thickness.max() < wall + 0.05

    def test_lines_of_a_wall(self):
        walls = np.array([0.2, 0.35, 0.4375, 0.5, 2.0])
        assert line_for(walls, 0.4375) == pytest.approx([0.2, 0.35, 0.4375, 0.25, 0.4])

    @pytest.mark.parametrize("wall, status, severity", [
        (0.25, "fail", "error"), (0.35, "pass", None), (0.52, "fail", "warning"), (0.7, "pass", None)])
    def test_a_thin_tube(self, adult, wall, status, severity):
        outcome = line_width(adult, part(tube(8.0, wall), (1.0, 0.0, 0.0)), standard())
        if status == "pass":
            assert not [f for f in outcome.findings if f.severity != "info"]
            return
        finding, = outcome.findings
        assert outcome.status == "fail" and finding.severity == severity
        assert np.hypot(*finding.where[1:]) == pytest.approx(8.0 - wall / 2, abs=wall / 2 + 0.05)
        assert "seal.tube_outer_diameter" in finding.fix

    @pytest.mark.parametrize("more, status", [(1e-3, "fail"), (0.0, "pass"), (-1e-3, "pass")])
    def test_at_the_limit(self, adult, more, status):
        parts = standing(adult)
        line = line_width(adult, parts, standard()).measured
        own = limits("print.line-width", least_line=line / 0.35 + more)
        assert line_width(adult, parts, own).status == status

    def test_fingers_are_two_millimetres_of_lines(self, adult):
        outcome = line_width(adult, standing(adult), standard())
        info, = outcome.findings
        assert outcome.status == "pass" and info.severity == "info"
        assert info.measured == pytest.approx(2.0 / 0.35, abs=0.05)

    def test_a_nozzle_too_wide_for_the_plug(self, adult):
        """The little finger's plug around its tube: two lines of 0.25 mm, none of 0.8 mm."""
        for nozzle, status in ((0.25, "pass"), (0.8, "fail")):
            hand = changed(adult, printing__tooling__nozzle_size=nozzle, printing__tooling__layer_height=0.15)
            plug = [p for p in tooling(hand, "little") if p.role == "plug"]
            outcome = line_width(hand, named(plug), standard())
            assert ("fail" if errors(outcome) else "pass") == status

    @pytest.mark.parametrize("deep, status", [(0.6, "pass"), (5.0, "fail")])
    def test_strokes_of_letters_are_no_walls(self, adult, deep, status):
        """Ribs of half a millimetre, as the letters of a label or as fins, on a plate."""
        ribs = [csg.box((x, -deep, -4), (x + 0.5, 1.0, 4)) for x in range(-12, 12, 3)]
        plate = csg.Union((csg.box((-15, 0, -5), (15, 8, 5)), *ribs))
        assert line_width(adult, part(plate, role="mould_a"), standard()).status in (status, "skipped")
        assert bool(line_width(adult, part(plate, role="mould_a"), standard()).findings) == (status == "fail")

    def test_a_sharp_edge_is_no_wall(self, adult):
        wedge = csg.Extrude(csg.Path.polygon([(0, 0), (15, 0), (0, 15)]), 20.0)
        parts = part(wedge, role="exoskeleton", name="exoskeleton/index")
        assert line_width(adult, parts, standard()).status == "skipped"

    @pytest.mark.parametrize("layer, status", [(0.2, "pass"), (0.2625, "pass"), (0.263, "fail")])
    def test_a_layer_too_thick(self, adult, layer, status):
        hand = changed(adult, printing__finger__layer_height=layer)
        outcome = line_width(hand, standing(hand), standard())
        assert outcome.status == status
        if status == "fail":
            assert "printing.finger.layer_height" in errors(outcome)[0].fix

    def test_nothing_printed_is_no_pass(self, adult):
        assert line_width(adult, {}, standard()).status == "skipped"


def shelf(reach):
    return csg.Union((csg.box((0, 0, 0), (10, 20, 20)), csg.box((9, 0, 15), (10 + reach, 20, 20))))


def gate(span):
    return csg.box((0, 0, 0), (20 + span, 12, 20)) - csg.box((10, -1, -1), (10 + span, 13, 12))


class TestHanging:
    def test_angles(self):
        solid = surface(csg.box((0, 0, 0), (4, 4, 4)))
        assert sorted(set(np.round(angles(solid)))) == [-90, 0, 90]

    def test_reach_of_a_shelf(self):
        solid = surface(shelf(3.0))
        patch, = patches(solid, steep(solid, 70.0, 0.4))
        assert patch.area == pytest.approx(60) and patch.angle == pytest.approx(90)
        assert patch.reach().max() == pytest.approx(3.0, abs=0.35)
        # Two places of one wall are no bridge, however near it runs.
        assert patch.span(patch.reach() > 1.0).min() > 10.0

    def test_span_of_a_gate(self):
        solid = surface(gate(8.0))
        patch, = patches(solid, steep(solid, 70.0, 0.4))
        span = patch.span(patch.reach() > 3.0)
        span = span[np.isfinite(span)]
        assert patch.area == pytest.approx(96)
        assert span.min() == pytest.approx(8.0, abs=0.1) and span.max() < 9.0

    def test_the_ceiling_of_a_bore(self):
        radius = 8.0
        block = csg.box((0, -12, -12), (30, 12, 12)) - csg.cylinder(radius, -1.0, 31.0)
        solid = surface(block)
        patch, = patches(solid, steep(solid, 70.0, 0.4))
        half = math.radians(20)
        assert patch.area == pytest.approx(30 * radius * 2 * half, rel=0.1)
        assert patch.span(np.ones(len(patch.places), bool)).max() < 2.6 * radius * math.sin(half)

    def test_what_starts_in_the_air(self):
        hook = csg.Union((shelf(8.0), csg.box((14, 5, 8), (17, 15, 16))))
        solid = surface(hook)
        lowest = min(patches(solid, steep(solid, 70.0, 0.4)), key=lambda p: p.places[:, 2].mean())
        assert np.isinf(lowest.reach()).all() and lowest.area == pytest.approx(30)

    def test_what_support_reaches(self):
        solid = surface(csg.Union((shelf(8.0), csg.box((9, 0, 0), (14, 20, 3)))))
        patch = max(patches(solid, steep(solid, 70.0, 0.4)), key=lambda p: p.places[:, 2].mean())
        seen = Bed(solid).seen_from(patch.places)
        beyond = patch.places[:, 0] > 14
        assert seen[patch.places[:, 0] > 15].all() and not seen[patch.places[:, 0] < 13].any()
        assert beyond.any()

    def test_steepness_is_measured_against_the_limit(self):
        for slope, count in ((69.0, 0), (71.0, 1)):
            run = 6.0 * math.tan(math.radians(slope))
            wedge = csg.Extrude(csg.Path.polygon([(0, 0), (10, 0), (10, 2), (10 + run, 8), (0, 8)]), 10.0)
            solid = surface(wedge.turned("x", 90))
            assert len(patches(solid, steep(solid, 70.0, 0.4))) == count


class TestOverhang:
    @pytest.mark.parametrize("reach, status", [(0.9, "pass"), (4.0, "fail")])
    def test_a_shelf(self, adult, reach, status):
        outcome = overhang(adult, part(shelf(reach)), standard())
        assert outcome.status == status
        if status == "fail":
            finding, = outcome.findings
            assert outcome.measured == pytest.approx(90) and outcome.limit == 70
            assert finding.measured == pytest.approx(4.0, abs=0.3)
            assert finding.where == pytest.approx((14.0, 10.0, 15.0), abs=10)
            assert "reaches" in finding.message and "part_support.plug" in finding.fix

    @pytest.mark.parametrize("span, status", [(9.5, "pass"), (10.5, "fail")])
    def test_a_bridge(self, adult, span, status):
        outcome = overhang(adult, part(gate(span)), standard())
        assert outcome.status == status
        if status == "fail":
            assert outcome.findings[0].measured == pytest.approx(span, abs=0.8)
            assert "spans" in outcome.findings[0].message

    @pytest.mark.parametrize("more, status", [(1e-3, "pass"), (0.0, "pass"), (-1e-3, "fail")])
    def test_at_the_limit(self, adult, more, status):
        found = overhang(adult, part(shelf(4.0)), standard()).findings[0]
        own = limits("print.overhang", reach=found.measured + more, least_area=0.0)
        assert overhang(adult, part(shelf(4.0)), own).status == status

    @pytest.mark.parametrize("more, status", [(0.5, "pass"), (0.0, "pass"), (-0.5, "fail")])
    def test_support_angle_at_the_limit(self, adult, more, status):
        run = 6.0 * math.tan(math.radians(75.0))
        wedge = csg.Extrude(csg.Path.polygon([(0, 0), (10, 0), (10, 2), (10 + run, 8), (0, 8)]), 10.0)
        hand = changed(adult, printing__tooling__support_angle=75.0 + more)
        assert overhang(hand, part(wedge.turned("x", 90)), standard()).status == status

    def test_support_makes_it_information(self, adult):
        for support, status in (("none", "fail"), ("touching build plate", "pass"), ("everywhere", "pass")):
            hand = changed(adult, printing__tooling__support=support)
            outcome = overhang(hand, part(shelf(4.0)), standard())
            assert outcome.status == status
            if status == "pass":
                info, = outcome.findings
                assert info.severity == "info" and info.measured == pytest.approx(60, abs=4)

    def test_support_of_one_role(self, adult):
        hand = changed(adult, printing__tooling__part_support={"plug": "everywhere"})
        assert overhang(hand, part(shelf(4.0)), standard()).status == "pass"
        assert overhang(hand, part(shelf(4.0), role="collar"), standard()).status == "fail"

    def test_the_way_a_part_stands(self, adult):
        for up, status in ((UP, "fail"), ((0.0, 0.0, -1.0), "pass"), ((0.0, 1.0, 0.0), "pass")):
            assert overhang(adult, part(shelf(4.0), up), standard()).status == status

    def test_a_place_is_told_in_the_parts_own_frame(self, adult):
        """The same shelf stood on its side in its own frame, and turned back on the bed."""
        turned = shelf(4.0).turned("y", 90)
        where = overhang(adult, part(turned, (1.0, 0.0, 0.0)), standard()).findings[0].where
        assert where[0] == pytest.approx(15, abs=0.01) and where[2] == pytest.approx(-14, abs=0.5)

    def test_tooling_of_the_adult_hand_passes(self, adult):
        outcome = overhang(adult, named(tooling(adult, "index")), standard())
        assert outcome.status == "pass" and not errors(outcome)

    def test_a_finger_standing_on_its_root_needs_support_in_its_slots(self, adult):
        finger = dataclasses.replace(exoskeleton(adult, "index"), up=(1.0, 0.0, 0.0))
        found = errors(overhang(adult, named([finger]), standard()))
        slots = [j.position + j.slot_length / 2 for j in adult.fingers.index.joints]
        assert [round(f.where[0], 1) for f in found if "reaches" in f.message] == slots

    def test_nothing_printed_is_no_pass(self, adult):
        assert overhang(adult, {}, standard()).status == "skipped"


class TestWatertight:
    CUBE = triangles(evaluate(csg.box((0, 0, 0), (4, 4, 4))))

    def judge(self, adult, vertices, faces):
        made = SimpleNamespace(name="tooling/index/plug", triangles=(np.asarray(vertices, np.float32), faces))
        return watertight(adult, {made.name: made}, standard())

    def test_a_closed_mesh_passes(self, adult):
        assert self.judge(adult, *self.CUBE).status == "pass"

    @pytest.mark.parametrize("face", range(12))
    def test_a_missing_triangle_is_found_where_it_was(self, adult, face):
        vertices, faces = self.CUBE
        finding, = self.judge(adult, vertices, np.delete(faces, face, axis=0)).findings
        assert "3 edges have no partner" in finding.message
        assert np.linalg.norm(vertices[faces[face]].mean(axis=0) - finding.where) < 2.0

    def test_a_triangle_the_wrong_way_round(self, adult):
        vertices, faces = self.CUBE
        turned = faces.copy()
        turned[3] = turned[3][::-1]
        assert "6 edges have no partner" in self.judge(adult, vertices, turned).findings[0].message

    def test_a_crumb_beside_the_part(self, adult):
        vertices, faces = self.CUBE
        both = np.vstack([vertices, 0.01 * vertices + 9.0]), np.vstack([faces, faces + len(vertices)])
        finding, = self.judge(adult, *both).findings
        assert "2 bodies" in finding.message and finding.where == pytest.approx((9.02,) * 3, abs=0.03)

    def test_inside_out(self, adult):
        vertices, faces = self.CUBE
        assert "inside out" in self.judge(adult, vertices, faces[:, ::-1]).findings[0].message

    def test_vertices_named_twice_are_one(self):
        vertices, faces = self.CUBE
        by_name, by_place = measure_mesh(vertices, faces), measure(vertices[faces])
        assert by_name == by_place and by_name.faults() == []
        assert by_name.volume_mm3 == pytest.approx(64) and by_name.area_mm2 == pytest.approx(96)
