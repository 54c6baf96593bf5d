"""Strain energies against their derivatives, states against closed forms, stability against dense curves."""

from __future__ import annotations

import pickle
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from handgen.errors import InputError
from handgen.materials import energies, library, stability, tensors
from handgen.materials.energies import ogden
from handgen.materials.law import PAIRS, Law, law, ogden_law
from handgen.materials.states import (
    EQUIBIAXIAL,
    PLANAR,
    STATES,
    UNIAXIAL,
    nominal_stress,
    simple_shear_stress,
    slope,
)

FIRST, SECOND = "mu/alpha", "2mu/alpha^2"
LAWS = {
    "neo_hookean": law("neo_hookean", {"c10": 0.3}),
    "mooney_rivlin": law("mooney_rivlin", {"c10": 0.3, "c01": 0.7}),
    "yeoh": law("yeoh", {"c10": 0.3, "c20": -0.02, "c30": 0.004}),
    "ogden": ogden_law([0.4, 0.01, -0.2], [1.3, 5.0, -2.5], FIRST),
}
EXPONENTS = {"uniaxial": (1, -0.5, -0.5), "planar": (1, 0, -1), "equibiaxial": (1, 1, -2)}
"""Of the stretches themselves, written again from the textbook and not from the code."""


def both_invariants() -> SimpleNamespace:
    """W = c1 (I1-3)(I2-3) + c2 (I2-3)^2 + c3 (I1-3): a law of a user's own, with every second derivative."""
    return SimpleNamespace(
        FORM="invariants",
        value=lambda i, k, c1, c2, c3: c1 * (i - 3) * (k - 3) + c2 * (k - 3) ** 2 + c3 * (i - 3),
        first=lambda i, k, c1, c2, c3: (c1 * (k - 3) + c3, c1 * (i - 3) + 2 * c2 * (k - 3)),
        second=lambda i, k, c1, c2, c3: (0 * i, c1 + 0 * i, 2 * c2 + 0 * i),
        shear_modulus=lambda c1, c2, c3: 2 * c3,
    )


@pytest.fixture(params=[*LAWS, "both invariants"])
def some_law(request, monkeypatch):
    if request.param in LAWS:
        return LAWS[request.param]
    own = both_invariants()
    monkeypatch.setattr(energies, "energy", lambda name: own)
    return Law("both invariants", (0.03, 0.01, 0.3))


def points() -> np.ndarray:
    """Isochoric squared stretches: general, two equal, nearly equal, all equal; shape (n, 3)."""
    free = np.random.default_rng(5).uniform(0.4, 2.5, (20, 2))
    free = np.vstack([free, [[1.3, 1.3], [0.6, 0.6], [1.4, 1.4 * (1 + 1e-9)], [1, 1]]])
    x = np.column_stack([free, 1 / free.prod(1)])
    return np.vstack([np.roll(x, k, axis=1) for k in range(3)])


# ---- energies and laws


def test_every_energy_is_tested():
    assert set(energies.names()) == set(LAWS)


def test_no_energy_without_deformation(some_law):
    assert some_law.response(np.ones(3)).value == 0


def test_derivatives_are_those_of_the_energy(some_law):
    """Complex step: exact to rounding, so a wrong term cannot hide in a tolerance."""
    x = points()
    response = some_law.response(x)
    for a in range(3):
        ahead = some_law.response(x + 1e-30j * np.eye(3)[a])
        np.testing.assert_allclose(response.first[:, a], ahead.value.imag / 1e-30, rtol=1e-12, atol=1e-14)
        np.testing.assert_allclose(response.second[..., a], ahead.first.imag / 1e-30, rtol=1e-12, atol=1e-13)


@pytest.mark.parametrize("name", [n for n in energies.names() if energies.energy(n).FORM == "invariants"])
def test_invariant_derivatives_of_each_file(name):
    energy, constants = LAWS[name].energy, LAWS[name].constants
    i1, i2 = np.random.default_rng(1).uniform(3, 9, (2, 30))
    step = 1e-30j
    w1, w2 = energy.first(i1, i2, *constants)
    assert np.allclose(w1, np.imag(energy.value(i1 + step, i2, *constants)) / 1e-30)
    assert np.allclose(w2, np.imag(energy.value(i1, i2 + step, *constants)) / 1e-30)
    w11, w12, w22 = energy.second(i1, i2, *constants)
    assert np.allclose(w11, energy.first(i1 + step, i2, *constants)[0].imag / 1e-30)
    assert np.allclose(w12, np.imag(energy.first(i1, i2 + step, *constants)[0]) / 1e-30)
    assert np.allclose(w22, np.imag(energy.first(i1, i2 + step, *constants)[1]) / 1e-30)


def test_quotients_are_differences_and_exact_where_stretches_meet(some_law):
    x = points()
    response = some_law.response(x)
    for k, (a, b) in enumerate(PAIRS):
        apart = abs(x[:, a] - x[:, b]) > 0.05
        plain = (response.first[:, a] - response.first[:, b]) / np.where(apart, x[:, a] - x[:, b], 1)
        np.testing.assert_allclose(response.quotient[apart, k], plain[apart], rtol=1e-11)
        close = abs(x[:, a] - x[:, b]) < 1e-8
        assert close.sum() >= 4
        limit = response.second[:, a, a] - response.second[:, a, b]
        np.testing.assert_allclose(response.quotient[close, k], limit[close], rtol=1e-7)


def test_the_quotient_of_nearly_equal_stretches_loses_no_digits():
    """Where a plain difference keeps three digits or none."""
    x, y = 1.4, 1.4 * (1 + 1e-5)
    mu, alpha = LAWS["ogden"].constants
    assert ogden.quotient(x, y, mu, alpha) == pytest.approx(ogden.second((x + y) / 2, mu, alpha), rel=5e-10)
    tiny = ogden.quotient(x, x * (1 + 1e-13), mu, alpha)
    assert tiny == pytest.approx(ogden.second(x, mu, alpha), rel=1e-11)


def test_ogden_contains_the_invariant_laws():
    x = points()
    neo = ogden_law([0.6], [2], FIRST).response(x)
    assert np.allclose(neo.value, law("neo_hookean", {"c10": 0.3}).response(x).value)
    mooney = ogden_law([0.6, -1.4], [2, -2], FIRST).response(x)
    assert np.allclose(mooney.value, LAWS["mooney_rivlin"].response(x).value)


def test_the_two_conventions_are_one_material_after_conversion():
    mu, alpha = [-30.921, 10.342, 26.791], [0.508, 1.375, -0.482]
    there = ogden.converted(mu, alpha, SECOND, FIRST)
    assert ogden.converted(there, alpha, FIRST, SECOND) == pytest.approx(mu, rel=1e-15)
    one, other = ogden_law(mu, alpha, SECOND), ogden_law(there, alpha, FIRST)
    assert one.constants == other.constants
    assert one.shear_modulus == pytest.approx(sum(mu)), "in the second convention G is the sum of mu"
    # written out from the formula of the second convention, independent of the code
    s = 1.7
    written = sum(2 * m / a**2 * (s**a + 2 * s ** (-a / 2) - 3) for m, a in zip(mu, alpha, strict=True))
    assert one.response(np.array([s**2, 1 / s, 1 / s])).value == pytest.approx(written, rel=1e-12)


@pytest.mark.parametrize(
    ("mu", "alpha", "words"),
    [([1.0], [2.0, 3.0], "1 mu and 2 alpha"), ([], [], "0 mu"), ([1.0], [0.0], "alpha = 0")],
)
def test_impossible_ogden_constants_are_refused(mu, alpha, words):
    with pytest.raises(ValueError, match=words):
        ogden_law(mu, alpha, FIRST)


@pytest.mark.parametrize(
    ("name", "constants", "words"),
    [
        ("neohooke", {"c10": 1}, "neo_hookean"),
        ("yeoh", {"c10": 1}, "c10, c20, c30"),
        ("neo_hookean", {}, "nothing"),
    ],
)
def test_impossible_constants_are_refused(name, constants, words):
    with pytest.raises(ValueError, match=words):
        law(name, constants)


def test_a_law_is_plain_data(some_law):
    """Workers and caches need it."""
    assert pickle.loads(pickle.dumps(some_law)) == some_law
    assert hash(some_law) == hash(pickle.loads(pickle.dumps(some_law)))


def test_the_same_functions_compile():
    numba = pytest.importorskip("numba")
    mu, alpha = LAWS["ogden"].constants
    compiled = numba.njit(ogden.quotient)
    for x, y in ((1.3, 1.3), (1.3, 0.8)):
        assert compiled(x, y, mu, alpha) == pytest.approx(float(ogden.quotient(x, y, mu, alpha)), rel=1e-12)


# ---- states


@pytest.mark.parametrize("state", STATES, ids=lambda s: s.name)
def test_nominal_stress_is_the_derivative_of_the_energy(some_law, state):
    s = np.linspace(0.7, 3, 25)
    step = 1e-30j
    powers = np.array(EXPONENTS[state.name])
    x = ((s + step)[:, None] ** powers) ** 2
    pulled = 2 if state is EQUIBIAXIAL else 1
    numeric = some_law.response(x).value.imag / 1e-30 / pulled
    np.testing.assert_allclose(nominal_stress(some_law, state, s), numeric, rtol=1e-11, atol=1e-13)
    rising = (nominal_stress(some_law, state, s + 1e-6) - nominal_stress(some_law, state, s - 1e-6)) / 2e-6
    np.testing.assert_allclose(slope(some_law, state, s), rising, rtol=1e-6, atol=1e-7)


def test_textbook_closed_forms():
    s = np.linspace(0.8, 3, 12)
    c10, c01 = 0.3, 0.7
    mooney = LAWS["mooney_rivlin"]
    np.testing.assert_allclose(
        nominal_stress(mooney, UNIAXIAL, s), 2 * (s - s**-2) * (c10 + c01 / s), atol=1e-14
    )
    np.testing.assert_allclose(nominal_stress(mooney, PLANAR, s), 2 * (s - s**-3) * (c10 + c01), atol=1e-14)
    np.testing.assert_allclose(
        nominal_stress(mooney, EQUIBIAXIAL, s), 2 * (s - s**-5) * (c10 + c01 * s**2), atol=1e-13
    )
    k = s**2 + 2 / s - 3
    np.testing.assert_allclose(
        nominal_stress(LAWS["yeoh"], UNIAXIAL, s),
        2 * (s - s**-2) * (0.3 - 0.04 * k + 0.012 * k**2),
        atol=1e-13,
    )
    mu, alpha = LAWS["ogden"].constants
    for state, power in ((UNIAXIAL, -0.5), (PLANAR, -1), (EQUIBIAXIAL, -2)):
        written = sum(m * (s ** (a - 1) - s ** (power * a - 1)) for m, a in zip(mu, alpha, strict=True))
        np.testing.assert_allclose(nominal_stress(LAWS["ogden"], state, s), written, atol=1e-13)


def test_small_strain_moduli(some_law):
    g = some_law.shear_modulus
    for state, factor in ((UNIAXIAL, 3), (PLANAR, 4), (EQUIBIAXIAL, 6)):
        assert slope(some_law, state, np.array(1.0)) == pytest.approx(factor * g, rel=1e-12)
        assert nominal_stress(some_law, state, np.array(1.0)) == pytest.approx(0, abs=1e-15)
    assert simple_shear_stress(some_law, np.array(1e-6)) == pytest.approx(1e-6 * g, rel=1e-9)


def test_simple_shear(some_law):
    """Against W of the sheared cube itself."""
    shear = np.array([0.0, 0.3, 1.0, 2.5])
    step = 1e-5

    def energy(amount):
        f = np.eye(3) + amount[:, None, None] * np.outer([1, 0, 0], [0, 1, 0])
        return some_law.response(np.linalg.eigvalsh(f.swapaxes(1, 2) @ f)).value

    numeric = (energy(shear + step) - energy(shear - step)) / (2 * step)
    np.testing.assert_allclose(simple_shear_stress(some_law, shear), numeric, rtol=1e-8, atol=1e-9)


def test_mooney_rivlin_is_linear_in_simple_shear():
    mooney, shear = LAWS["mooney_rivlin"], np.array([0.0, 0.3, 1.0, 2.5])
    np.testing.assert_allclose(simple_shear_stress(mooney, shear), mooney.shear_modulus * shear, rtol=1e-13)


# ---- tensors


def cauchy_greens() -> np.ndarray:
    """Right Cauchy-Green tensors: undeformed, coincident and nearly coincident stretches, turned, general."""
    rng = np.random.default_rng(0)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    general = np.eye(3) + 0.3 * rng.normal(size=(4, 3, 3))
    special = [np.eye(3), np.diag([1.2, 1.2, 0.6]), np.diag([1.3, 1.3 * (1 + 1e-9), 0.7])]
    special.append(turn @ np.diag([1.2, 1.2, 0.6]) @ turn.T)
    return np.concatenate([special, general.swapaxes(1, 2) @ general])


@pytest.mark.parametrize("function", [tensors.plain, tensors.isochoric])
def test_stress_and_tangent_are_derivatives(some_law, function):
    c = cauchy_greens()
    _, stress, tangent = function(some_law, c)
    for i in range(3):
        for j in range(3):
            step = np.zeros((3, 3))
            step[i, j] += 5e-7
            step[j, i] += 5e-7
            ahead, behind = function(some_law, c + step), function(some_law, c - step)
            np.testing.assert_allclose((ahead[0] - behind[0]) / 1e-6, stress[:, i, j], atol=1e-8)
            np.testing.assert_allclose((ahead[1] - behind[1]) / 1e-6, tangent[..., i, j], atol=2e-7)


def test_both_forms_make_the_same_tensors():
    """Mooney-Rivlin through invariants and through eigenvectors, at coincident stretches too."""
    c = cauchy_greens()
    through_invariants = tensors.isochoric(LAWS["mooney_rivlin"], c)
    through_directions = tensors.isochoric(ogden_law([0.6, -1.4], [2, -2], FIRST), c)
    for one, other in zip(through_invariants, through_directions, strict=True):
        np.testing.assert_allclose(one, other, atol=1e-12)


# ---- stability


def test_safe_laws_are_stable_to_large_strain():
    for name in ("neo_hookean", "mooney_rivlin"):
        assert stability.failures(LAWS[name], 5) == []
        assert stability.stable_up_to(LAWS[name], 5) == 5


@given(st.lists(st.tuples(st.floats(0.01, 2), st.floats(0.2, 6), st.booleans()), min_size=1, max_size=3))
def test_terms_of_positive_modulus_are_stable_materials(terms):
    """With every mu alpha > 0 each term is convex in the logarithmic strains."""
    signed = [(m, a) if up else (-m, -a) for m, a, up in terms]
    one = ogden_law([m for m, _ in signed], [a for _, a in signed], FIRST)
    assert not {f.condition for f in stability.failures(one, 3)} & {"drucker", "baker-ericksen", "pull"}


def test_the_silicone_of_the_literature_fails_where_its_own_curves_say():
    """Onsets against dense curves drawn from the closed forms, not from the code under test."""
    one = library.parameter_set("ecoflex-00-50-ogden-elsayed").build()
    found = {(f.state, f.condition): f for f in stability.failures(one, 3)}
    mu, alpha = one.constants
    s = np.linspace(1, 4, 300_001)
    for state, power in (("planar", -1), ("equibiaxial", -2)):
        stress = sum(m * (s ** (a - 1) - s ** (power * a - 1)) for m, a in zip(mu, alpha, strict=True))
        peak = s[np.flatnonzero(np.diff(stress) < 0)[0]]
        assert found[state, "monotone"].stretch == pytest.approx(peak, abs=3e-5)
    negative = s[1:][stress[1:] < 0][0]
    assert found["equibiaxial", "pull"].stretch == pytest.approx(negative, abs=3e-5)
    assert found["equibiaxial", "baker-ericksen"].stretch == pytest.approx(negative, abs=3e-5), (
        "same thing there"
    )
    assert ("uniaxial", "monotone") not in found, "the one state that it was fitted in"
    assert min(f.stretch for f in found.values()) == pytest.approx(1.061, abs=1e-3)


def test_drucker_against_the_energy_in_logarithmic_strains():
    """Least eigenvalue of the Hessian of W(e1, e2, -e1-e2), by differences, at either side of the onset."""
    one = library.parameter_set("ecoflex-00-50-ogden-elsayed").build()
    onset = {f.state: f.stretch for f in stability.failures(one, 3) if f.condition == "drucker"}

    def least(state, stretch):
        base = np.log(stretch) * np.array(EXPONENTS[state])
        h = 1e-4
        basis = np.array([[1, -1, 0], [1, 1, -2]]) / np.sqrt([[2], [6]])

        def w(u):
            return one.response(np.exp(2 * (base + u @ basis))).value

        e = np.eye(2) * h
        hessian = [[w(a + b) - w(a - b) - w(b - a) + w(-a - b) for b in e] for a in e]
        return np.linalg.eigvalsh(np.array(hessian) / (4 * h * h))[0]

    assert set(onset) == set(EXPONENTS)
    for state, stretch in onset.items():
        assert least(state, stretch - 1e-3) > 0 > least(state, stretch + 1e-3)


def test_an_unstable_set_is_refused_with_state_strain_and_alternatives():
    with pytest.raises(InputError) as caught:
        library.usable("ecoflex-00-50-ogden-elsayed", 1.0, file="mine.yaml", path="materials.Ecoflex 00-50")
    (problem,) = caught.value.problems
    assert (problem.file, problem.path) == ("mine.yaml", "materials.Ecoflex 00-50")
    assert "in planar tension from 11.2 % strain" in problem.message
    assert "in equibiaxial tension from 6.08 % strain its nominal stress stops rising" in problem.message
    assert "ecoflex-00-50-neo-hookean" in problem.allowed
    assert "elsayed" not in problem.allowed
    assert library.usable("ecoflex-00-50-ogden-elsayed", 0.05), "stable over so little strain"
    assert library.usable("ecoflex-00-50-neo-hookean", 1.7)


def test_a_negative_modulus_is_named():
    misread = library.parameter_set("ninjaflex-ogden-yap").build(FIRST)
    assert "Young's modulus there is -21.6 MPa" in stability.reason(misread, 0.1)
    assert stability.stable_up_to(misread, 0.1) == 0
