"""The chain in balance: Newton's method on joints, strips and thrust."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from handgen.simulation.rod.chain import STRAINS, STRETCHES, Chain

TOLERANCE = 1e-7
"""N mm, N: largest part of the residual."""
ITERATIONS = 40
WEIGHT_STEPS = 8
"""At most, in which weight is put on."""
HALVINGS = 8
TURN = 0.3
"""rad that a joint may turn in one iteration."""
SMALL = 1e-6
"""Of the unknowns, for the slopes of the residual."""
LENGTH = 10.0
"""mm by which a gap is divided to stand beside a force."""
ROUND = 1e-4
"""N; how sharply the actuator's end touches the bore's."""


class Balance:
    """`chain` with `coefficients` (see `known.json`)."""

    def __init__(self, chain: Chain, coefficients: Mapping[str, float]):
        self.chain, self.k = chain, coefficients
        self.share = 1.0
        """Of own weight and of the weight on the tip."""
        self.factorisations = 0
        r = chain.bore[:, None]
        reach = coefficients["reach"] * r / 2 * np.tanh(chain.beside / (coefficients["bone"] * r))
        self.strip_length = chain.strip_length + reach.sum(1)

    def unloaded(self, steps: int) -> np.ndarray | None:
        """The state without pressure, weight put on in `steps`, or in more where those do not do."""
        q: np.ndarray | None = np.zeros(self.chain.unknowns)
        for i in range(steps):
            self.share = (i + 1) / steps
            q = self.solve(q, 0.0)
            if q is None:
                return self.unloaded(2 * steps) if 2 * steps <= WEIGHT_STEPS else None
        return q

    def solve(self, q: np.ndarray, pressure: float) -> np.ndarray | None:
        """The balance at `pressure`, MPa, from `q` nearby; None: not found."""
        steps = np.vstack([np.zeros(len(q)), SMALL * np.eye(len(q))])
        rows = self.residual(q + steps, pressure)
        for _ in range(ITERATIONS):
            here = rows[0]
            if np.abs(here).max() < TOLERANCE:
                return q
            self.factorisations += 1
            try:
                step = -np.linalg.solve((rows[1:] - here).T / SMALL, here)
            except np.linalg.LinAlgError:
                return None
            widest = np.abs(step[:self.chain.joints]).max()
            if widest > TURN:
                step *= TURN / widest
            for _ in range(HALVINGS):
                # With its slopes at once: most steps are taken whole.
                rows = self.residual(q + step + steps, pressure)
                if np.linalg.norm(rows[0]) < np.linalg.norm(here):
                    break
                step /= 2
            else:
                return None
            q = q + step
        return None

    def residual(self, q: np.ndarray, pressure: float) -> np.ndarray:
        """Out-of-balance moments N mm, forces N, and contact of the actuator's end (B, 2n + 1)."""
        c, k, n = self.chain, self.k, self.chain.joints
        turn, growth, base = q[:, :n], q[:, n:2 * n], q[:, 2 * n]
        moment, pull = self._strip(turn, growth)
        thrust, stretch = self._actuator(turn, base, pressure)
        tangent = np.interp(stretch[:, c.at], STRETCHES, c.silicone_slope) / stretch[:, c.at]
        moment = moment + k["chamber"] * tangent / c.flexible * turn
        lever = c.lever + k["lever"] * c.bore + k["lift"] * c.outside * np.tanh(turn)
        slope = k["lift"] * c.outside / np.cosh(turn) ** 2
        outer = c.forces(q, self.share)
        moment = moment + outer[:, :n] - thrust * (lever + slope * turn)
        pull = pull + outer[:, n:] - thrust
        gap = (c.free + (growth + lever * turn).sum(1) - (stretch.sum(1) * c.dx - c.dx * len(c.x))) / LENGTH
        # The end pushes or is free: thrust and gap are both positive and one of them is none.
        touch = base + gap - np.sqrt(base**2 + gap**2 + ROUND**2)
        return np.concatenate([moment, pull, touch[:, None]], 1)

    def _strip(self, turn: np.ndarray, growth: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(moment, pull) of the strips' fibres (B, n)."""
        c, k = self.chain, self.k
        length = self.strip_length
        strain = ((growth / length)[..., None] - (turn / length)[..., None] * c.fibre)
        force = k["strip"] * np.interp(strain, STRAINS, c.strip_stress) * c.fibre_area
        return -(force * c.fibre).sum(-1), force.sum(-1)

    def _actuator(self, turn: np.ndarray, base: np.ndarray, pressure: float):
        """(thrust at the joints (B, n), stretch at the stations (B, m))."""
        c, k = self.chain, self.k
        passed = np.cumsum(np.abs(turn), 1) - np.abs(turn) / 2
        thrust = base[:, None] * np.exp(-k["rub"] * c.case.contact.friction * passed)
        along = np.concatenate([base[:, None], thrust], 1)[:, c.passed]
        stress = (pressure * c.pressed - along) / c.wall_area
        return thrust, np.interp(stress, c.silicone_stress, STRETCHES)

    # What a state shows

    def residual_of(self, q: np.ndarray, pressure: float) -> float:
        """Largest part of the residual over the largest thrust or weight."""
        acting = max(float((pressure * self.chain.pressed).max()), 1e-3)
        return float(np.abs(self.residual(q[None], pressure)).max() / acting)

    def stretches(self, q: np.ndarray, pressure: float) -> dict[str, np.ndarray]:
        """Largest stretch of each station of the actuator, and of each strip."""
        c, n = self.chain, self.chain.joints
        turn, growth = q[None, :n], q[None, n:2 * n]
        _, stretch = self._actuator(turn, q[None, 2 * n], pressure)
        found = stretch[0].copy()
        # The dorsal side of a bent chamber is stretched by its bend too.
        found[c.at] += np.abs(turn[0]) * c.outside / c.bend_length
        length = self.strip_length
        strip = 1 + growth[0] / length + np.abs(turn[0]) / length * c.height / 2
        return {"actuator": found, "exoskeleton": strip}

    def elongation(self, q: np.ndarray, pressure: float) -> float:
        """Growth of the actuator, mm."""
        n = self.chain.joints
        _, stretch = self._actuator(q[None, :n], q[None, 2 * n], pressure)
        return float((stretch - 1.0).sum() * self.chain.dx)

    def pushed(self, q: np.ndarray) -> float:
        """Force on the plane, N."""
        return self.chain.pushed(q)
