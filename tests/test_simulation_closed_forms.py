"""The two solid elements against closed forms, and how fast their errors fall."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

from handgen.materials.law import law
from handgen.materials.states import EQUIBIAXIAL, STATES, UNIAXIAL, nominal_stress
from tests.small_solids import LAWS, Body, block, crooked

BULK = 1e4
"""MPa; 7000 shear moduli and more: what changes of volume cost is less than the tests' tolerances."""
MOONEY, MU = LAWS["mooney_rivlin"], 2 * (0.21 + 0.525)


@pytest.fixture(params=LAWS)
def some_law(request):
    return LAWS[request.param]


@pytest.fixture(params=(8, 20), ids=["Q1P0", "quadratic"])
def nodes(request):
    return request.param


def held_box(unit: np.ndarray, ends) -> np.ndarray:
    """Supports of a box: planes of symmetry at 0, and the ends at 1 of the axes `ends`."""
    fixed = unit < 1e-9
    for axis in ends:
        fixed[unit[:, axis] > 1 - 1e-9, axis] = True
    return fixed


class TestHomogeneousStates:
    @pytest.mark.parametrize("state", STATES, ids=lambda s: s.name)
    @pytest.mark.parametrize("stretch", [0.8, 1.7])
    def test_nominal_stress(self, nodes, some_law, state, stretch):
        size = np.array([2.0, 1.5, 1.0])
        x, cells, unit = crooked((2, 2, 2), nodes)
        ends = {0: stretch}
        if state is not UNIAXIAL:
            ends[1] = stretch if state is EQUIBIAXIAL else 1.0
        fixed = held_box(unit, ends)

        def place(share):
            now = x.copy()
            for axis, final in ends.items():
                end = unit[:, axis] > 1 - 1e-9
                now[end, axis] *= 1 + share * (final - 1)
            return now

        found, held = Body(x, cells, some_law, BULK).solve(fixed, place, steps=6)
        pulled = held[unit[:, 0] > 1 - 1e-9, 0].sum() / (size[1] * size[2])
        assert pulled == pytest.approx(nominal_stress(some_law, state, np.array(stretch)), rel=5e-3)
        thinned = stretch ** (state.powers[2] / 2)
        assert found[unit[:, 2] > 1 - 1e-9, 2] == pytest.approx(thinned, rel=2e-3)


def ring(inner: float, outer: float, height: float, sector: float):
    """Unit cube -> sector of a tube around z: radius, angle, height."""

    def place(unit):
        r, a = inner + (outer - inner) * unit[:, 0], sector * unit[:, 1]
        return np.stack([r * np.cos(a), r * np.sin(a), height * unit[:, 2]], -1)

    return place


def tube_chamber(unit: np.ndarray, cells: np.ndarray, centre: int) -> np.ndarray:
    """Faces of a tube's bore and of the lid, a fan to `centre`, that closes it at its upper end."""
    inner = cells[(unit[cells[:, :8]][:, (0, 3, 4, 7), 0] < 1e-9).all(axis=1)]
    wall = inner[:, [0, 3, 7, 4]]
    top = inner[(unit[inner[:, 4], 2] > 1 - 1e-9)]
    lid = np.stack([top[:, 4], top[:, 7], np.full(len(top), centre), np.full(len(top), centre)], -1)
    return np.vstack([wall, lid])


def inflated(count: int, radial: int, around: int, widened: float, bulk: float = BULK):
    """(largest error of a radius over the bore's growth, relative error of pressure) of a quarter tube.

    Plane strain, bore 2 -> 2 `widened`, outside 3.2. Of 8 nodes the air pushes as in the closed form and the
    tube answers; those of 20 know no air: their bore is moved, and what holds it is pressure.
    """
    a, b, h = 2.0, 3.2, 0.5
    x, cells, unit = block((radial, around, 1), count, ring(a, b, h, np.pi / 2))
    grown = a * a * (widened**2 - 1)
    def rise(r):
        k = 1 + grown / r**2  # squared hoop stretch
        return MU * (k - 1 / k) * r / (r * r + grown)

    pressure = quad(rise, a, b)[0]
    fixed = np.zeros((len(x) + 1, 3), bool)
    fixed[:-1, 2] = fixed[-1] = True
    fixed[:-1, 1] |= unit[:, 1] < 1e-9
    fixed[:-1, 0] |= unit[:, 1] > 1 - 1e-9
    chamber = tube_chamber(unit, cells, len(x)) if count == 8 else np.zeros((0, 4), int)
    x, bore = np.vstack([x, [0, 0, h]]), np.append(unit[:, 0] < 1e-9, False)
    body = Body(x, cells, MOONEY, bulk, chamber)
    if count == 8:
        found, _ = body.solve(fixed, air=pressure, steps=6)
    else:
        fixed[bore] = True
        moved = np.outer(bore, [widened - 1, widened - 1, 0])
        found, held = body.solve(fixed, lambda share: x * (1 + share * moved), steps=6)
        pushed = np.einsum("ni,ni->", held[bore, :2], found[bore, :2])  # times 1 / (area times radius)
        pushed /= np.pi / 2 * h * (a * widened) ** 2
        pressure = pushed / pressure
    radius = np.hypot(*found[:-1, :2].T)
    true = np.sqrt(np.hypot(*x[:-1, :2].T) ** 2 + grown)
    error = np.abs(radius - true).max() / (a * (widened - 1))
    return (error, abs(pressure - 1)) if count == 20 else (error, 0.0)


class TestTube:
    @pytest.mark.parametrize(("count", "radial", "around"), [(8, 8, 16), (20, 2, 4)])
    def test_thick_tube_inflates_as_the_closed_form(self, count, radial, around):
        """Quarter of a tube in plane strain, its bore widened by 30 %."""
        assert max(inflated(count, radial, around, 1.3)) < 5e-3

    @pytest.mark.parametrize(("count", "counts"), [(8, (4, 32, 3)), (20, (2, 6, 6))])
    def test_torsion_of_a_round_bar(self, count, counts):
        """Torque pi mu t (b^4 - a^4)/2 and, neo-Hookean, the push -pi mu t^2 (b^2 - a^2)^2/4 (Poynting).

        Universal deformation of an incompressible round bar: radii stay. Here with a thin core that turns.
        """
        a, b, h, twist = 0.3, 1.0, 1.0, 0.6
        x, cells, unit = block(counts, count, ring(a, b, h, np.pi))
        both = np.concatenate([x, x * [-1, -1, 1]])
        cells = np.vstack([cells, cells + len(x)])
        both, inverse = merged(both)
        unit = np.concatenate([unit, unit])[np.unique(inverse, return_index=True)[1]]
        cells = inverse[cells]
        neo = law("neo_hookean", {"c10": 0.5})
        end = unit[:, 2] > 1 - 1e-9
        held = (unit[:, 2] < 1e-9) | end | (unit[:, 0] < 1e-9)

        def place(share):
            angle = share * twist * both[:, 2]
            c, s = np.cos(angle), np.sin(angle)
            px, py, pz = both.T
            return np.stack([c * px - s * py, s * px + c * py, pz], -1)

        found, force = Body(both, cells, neo, BULK).solve(np.repeat(held[:, None], 3, axis=1), place)
        torque = np.cross(found[end], force[end])[:, 2].sum()
        assert torque == pytest.approx(np.pi * twist * (b**4 - a**4) / 2, rel=5e-3)
        if count == 20:  # a second-order effect, carried by pressure: constant ones are too coarse for it
            pushed = -np.pi * (twist * (b * b - a * a)) ** 2 / 4
            assert force[end, 2].sum() == pytest.approx(pushed, rel=0.025)


def merged(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(points without repetition, number of each among them)."""
    _, first, inverse = np.unique(np.round(points, 9), axis=0, return_index=True, return_inverse=True)
    return np.ascontiguousarray(points[first]), inverse.ravel()


def bent(count: int, along: int, through: int, thickness: float = 1.0):
    """(error of places over thickness, RMS, relative one of the moment) of Rivlin's flexure of a block.

    Plane strain, curved sides free, length 4, bent by 1.2 rad, stretches k = w r along and 1/k across. Moment
    per width from sigma_rr = W(k) - W(k_outer), W = mu/2 (k^2 + 1/k^2 - 2), sigma_tt = sigma_rr + k W'(k).
    """
    length, angle = 4.0, 1.2

    def curvature(share):
        """(w, c) of r^2 = 2 X / w + c; both curved sides free: k_inner k_outer = 1."""
        w = share * angle / length
        return w, brentq(lambda c: w**4 * (c * c - (thickness / w) ** 2) - 1, thickness / w, 2 / w**2)

    x, cells, unit = block((through, along, 1), count,
                           lambda u: (u - [0.5, 0.0, 0.0]) * [thickness, length, 1.0])

    def place(share):
        w, c = curvature(share)
        r = np.sqrt(2 * x[:, 0] / w + c)
        return np.stack([r * np.cos(w * x[:, 1]) - np.sqrt(c), r * np.sin(w * x[:, 1]), x[:, 2]], -1)

    fixed = np.zeros((len(x), 3), bool)
    fixed[(unit[:, 1] < 1e-9) | (unit[:, 1] > 1 - 1e-9)] = True
    fixed[:, 2] = True
    found, force = Body(x, cells, MOONEY, 1e6 * MU).solve(fixed, place, steps=6)
    end = unit[:, 1] > 1 - 1e-9
    moment = np.cross(found[end], force[end])[:, 2].sum()
    w, c = curvature(1.0)
    inner, outer = np.sqrt(c - thickness / w), np.sqrt(c + thickness / w)

    def stress(r):
        k = w * r
        return MU * (k * k - k**-2) + MU / 2 * (k * k + k**-2 - (w * outer) ** 2 - (w * outer) ** -2)

    exact = quad(lambda r: stress(r) * r, inner, outer)[0]
    off = np.linalg.norm(found - place(1.0), axis=1)
    return np.sqrt(np.mean(off**2)) / thickness, abs(moment / exact - 1)


def rates(errors) -> np.ndarray:
    return np.log2(np.array(errors[:-1]) / np.array(errors[1:]))


class TestRates:
    """How fast errors fall where edges are halved: bending to 69 degrees and a tube widened by 30 %."""

    def test_the_trilinear_element_is_of_second_order(self):
        place, moment = np.transpose([bent(8, 8 * n, 2 * n) for n in (1, 2, 4)])
        assert (rates(place) > 1.9).all()
        assert (rates(moment) > 1.9).all()
        assert (rates([inflated(8, 4 * n, 8 * n, 1.3, 1e5 * MU)[0] for n in (1, 2, 4)]) > 1.9).all()

    def test_the_quadratic_element_is_of_third_order_nearly(self):
        place, moment = np.transpose([bent(20, 4 * n, n) for n in (1, 2, 4)])
        assert (rates(place) > 2.4).all()
        assert (rates(moment) > 3.3).all()
        radius, pressure = np.transpose([inflated(20, n, 2 * n, 1.3, 1e6 * MU) for n in (1, 2, 4)])
        assert (rates(radius) > 2.8).all()
        assert (rates(pressure) > 2.8).all()

    def test_only_the_quadratic_element_does_not_lock_in_a_thin_strip(self):
        """Length over thickness 20, elements ten times as long as thick: why the strips have 20 nodes."""
        assert bent(20, 4, 1, thickness=0.2)[1] < 0.02
        assert bent(8, 8, 2, thickness=0.2)[1] > 1.0
