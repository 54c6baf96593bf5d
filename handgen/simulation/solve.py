"""From no load to full load: Newton with mixed integration points, steps that adapt, folds that are told.

A state is accepted only when it is in balance (TOLERANCE), every Jacobian is positive and the tangent made
from its own stresses is positive definite: a stable equilibrium. That last factorisation is not lost: it
gives the next step's tangent predictor, bent by the change of tangents from step to step.

A step that fails is cut back. Where the shortest step fails, the finger may have reached a limit point:
then it is followed in artificial time, against a viscous drag that is let go little by little (every step of
it a minimum of energy + drag |q - q_before|^2 / 2), down to whatever stable state lies below. If there is one
the point is kept and marked as a fold; if there is none the curve ends there.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from handgen.simulation import line_search, runaway
from handgen.simulation.contact import SOFT
from handgen.simulation.krylov import gmres
from handgen.simulation.sparse import factoriser
from handgen.simulation.system import Load, System

TOLERANCE = 1e-5
"""Largest out-of-balance force over the largest acting one."""
LEAST_FORCE = 1e-3
"""N; what an acting force counts at least."""
ITERATIONS, MOST_ITERATIONS = 12, 24
"""Of Newton; beyond the first number only while the residual falls to a quarter in two of them."""
HOPELESS, LATE = 1e9, 8
"""A residual beyond which Newton does not come back; from iteration LATE on it must be below 1."""
COUPLED, SOLUTIONS = 1e-4, 30
"""Error of a step relative to the step, up to which friction's part of the equations is solved, and the
solutions with the symmetric part's factor that it may take."""
NEARLY = 1e-3
"""Residual from which on the tangent of the iteration before serves once more: a hundredth is left by it."""
TURN = 0.3
"""rad that a bone may turn in one iteration: beyond, a straight step strains what only rotates."""
NEGATIVES, UNSTABLE = 4, 2
"""Negative pivots of a tangent on the way to balance, at most: hundreds mean a bad predictor; and tangents
that have some: a way that met a third one led to no stable state wherever it was looked at."""
STEPS = Load(0.1, 0.004, 0.06, 0.05, 0.1)
"""First steps: share of own weight, MPa, N, shares of the silicone's stiffness and of the fit."""
LONGEST = Load(0.5, 0.020, 0.20, 0.3, 0.5)
SHORTEST = Load(0.01, 0.0005, 0.002, 0.005, 0.01)
GROWTH, CUT = 2.0, 0.5
"""Of a step after an easy and after a failed one."""
EASY, PLAIN = 6, 3
"""Iterations up to which the next step may be longer, and may be so by GROWTH twice."""
ROUNDED = 1e-9
"""Shares of the way to a target closer than that are one."""
JUMP = 1.0
"""mm that some place moves at least where the finger folds; a state nearer by was only hard to find."""
AFTER = 0.5
"""First step after that, as a share of the very first."""
DRAG = 1.0
"""N/mm on an element's share of mass, at first, when a fold is followed in artificial time."""
CALM = 0.1
"""Largest force that the drag holds, over the largest acting one, at which the finger is let go."""
TOO_WEAK = 2.5
"""Times a drag that was too weak, the least that is tried next; it is forgotten by a fifth a step."""
RELAXATIONS = 120
"""Steps of artificial time at most."""


@dataclass
class Point:
    """A stable state."""

    load: Load
    q: np.ndarray
    residual: float
    folds: tuple[float, ...] = ()
    """Pressures, MPa, of the jumps on the way here from the target before."""


@dataclass
class Cost:
    """What a run has cost so far."""

    factorisations: int = 0
    assemblies: int = 0
    indefinite: int = 0
    steps: int = 0
    cuts: int = 0


class Solver:
    """Follows the equilibrium of `system` from no load."""

    def __init__(self, system: System, factoriser_name: str = ""):
        self.system = system
        self.matrix = factoriser(system.pattern, system.crew, factoriser_name)
        self.cost = Cost()
        self.folds: list[float] = []
        self.ran_away: runaway.Wall | None = None
        """The wall that gave way, where one did."""
        self._steps = list(STEPS.parts)
        self._slope: tuple[np.ndarray, float, tuple[float, ...]] | None = None
        self._stands: np.ndarray | None = None
        """The state whose tangent stands factorised."""
        self._unstable = False
        """Whether a drag has led through unstable states."""

    # Steps

    def begin(self) -> Point | None:
        """The unloaded state, which is in balance as drawn."""
        s, point = self.system, Point(Load(), np.zeros(self.system.size), 0.0)
        s.assemble(point.q, point.load, exact=True)
        s.extrapolate(point.q, np.zeros_like(point.q))
        # Surfaces that just touch would let the first predictor pass through them: half of it they hold.
        s.grip = 2 * SOFT
        _, _, values, _ = s.assemble(point.q, point.load, exact=False)
        s.grip = 0.0
        s.accept(point.q)
        self._stands = point.q
        return point if self._factorise(values) else None

    def advance(self, point: Point, target: Load) -> tuple[Point, bool]:
        """(the furthest stable state towards `target`, whether it got there)."""
        folds: tuple[float, ...] = ()
        whole = np.abs(np.subtract(target.parts, point.load.parts))
        if not whole.any():
            return replace(point, folds=folds), True
        start, gone, last = point.load, 0.0, 1.0
        failed: list[float] = []  # shares of the way, the nearest last
        while gone < 1.0 - ROUNDED:
            ahead = self._ahead(whole, 1.0 - gone, failed[-1] - gone if failed else np.inf, last)
            new = start.towards(target, gone + ahead) if gone + ahead < 1.0 - ROUNDED else target
            found = self._step(point, new)
            if found is not None:
                self.cost.steps += 1
                point, iterations = found
                gone, last = gone + ahead, ahead
                failed = [other for other in failed if other > gone + ROUNDED]
                if iterations <= EASY:
                    self._scale(whole, GROWTH if iterations > PLAIN else GROWTH**2)
                continue
            self.cost.cuts += 1
            self._slope = None
            failed.append(gone + ahead)
            self._steps = [w * ahead * CUT if w else s for w, s in zip(whole, self._steps, strict=True)]
            if self._shortest(whole):
                # A long step on: nearer to the limit point it would linger there.
                gone += min(1.0 - gone, 1.0 / float((whole / LONGEST.parts).max()))
                jumped = self._relaxed(point.q, start.towards(target, gone))
                if jumped is None or not self._stable(jumped):
                    return replace(point, folds=folds), False
                if self._unstable and self._apart(jumped.q, point.q) > JUMP:
                    folds += (point.load.pressure,)
                    self.folds.append(point.load.pressure)
                point, failed = jumped, []
                self.system.accept(point.q)
                self._steps = [AFTER * first for first in STEPS.parts]
        return replace(point, folds=folds), True

    def _ahead(self, whole: np.ndarray, left: float, room: float, last: float) -> float:
        """The next step as a share of the `whole` way, of which so much is `left`.

        Where a longer step failed, `room` ahead, it leads only from no farther than the `last` one went.
        """
        step = min(s / w for s, w in zip(self._steps, whole, strict=True) if w)
        if room <= left and step >= room:
            return room if room <= last + ROUNDED else room / 2
        if step < left < 2 * step:
            return left / 2  # two equal steps rather than a long and a tiny one
        return min(step, left)

    def _apart(self, q: np.ndarray, other: np.ndarray) -> float:
        """The farthest that any place is from itself in another state, mm."""
        return float(np.abs(self.system.positions(q) - self.system.positions(other)).max())

    def _scale(self, gap: np.ndarray, factor: float) -> None:
        """Lengthen or shorten the steps of the loads that vary."""
        self._steps = [min(s * factor, most) if g else s
                       for g, s, most in zip(gap, self._steps, LONGEST.parts, strict=True)]

    def _shortest(self, gap: np.ndarray) -> bool:
        return any(g != 0 and s < least for g, s, least in zip(gap, self._steps, SHORTEST.parts, strict=True))

    def _step(self, point: Point, load: Load) -> tuple[Point, int] | None:
        """(stable state under `load`, iterations) or None; leaves its tangent factorised."""
        s, q = self.system, point.q
        if self._stands is not q and not self._stable(point):
            return None
        self._stands = None
        force = s.reload(q, load)
        change = np.subtract(load.parts, point.load.parts)
        size = float(np.abs(change / STEPS.parts).max())
        first = self._solve(-force)
        step, slope, direction = first, first / size, tuple(np.sign(change))
        if self._slope is not None and self._slope[2] == direction:
            before, length, _ = self._slope
            step = first + (slope - before) / length * size**2 / 2
        # What bends a step keeps lengths as rotations change them: it strains nothing to first order.
        s.extrapolate(q, first)
        found = self._newton(q + step, load)
        if found is not None:
            new, residual, iterations, values = found
            if self._factorise(values):
                s.accept(new)
                self._stands = new
                self._slope = (slope, size, direction)
                return Point(load, new, residual), iterations
        self._slope = None
        return None

    def _newton(self, q: np.ndarray, load: Load, drag: np.ndarray | None = None,
                centre: np.ndarray | None = None, assembled: tuple | None = None,
                ) -> tuple[np.ndarray, float, int, np.ndarray] | None:
        """(q in balance, residual, iterations, tangent) from `q`, or None; `drag` (n,) N/mm to `centre`.
        `assembled`: what the system gave at `q` just now, which is used up.

        In balance the extrapolated stresses are the state's own to first order in what is left of the
        residual, so the last tangent serves the test of stability and the next predictor.
        """
        s = self.system
        earlier = last = np.inf
        fresh, unstable = False, 0
        for iteration in range(MOST_ITERATIONS + 1):
            _, force, values, least = assembled or s.assemble(q, load, exact=False)
            assembled = None
            self.cost.assemblies += 1
            if least <= 0.0 or not np.isfinite(force).all():
                return None
            if drag is not None:
                force = force + drag * (q - centre)
                values[s.pattern.diagonal] += drag
            residual = float(np.abs(force).max() / self._acting(load))
            if residual < TOLERANCE:
                return q, residual, iteration, values
            if residual > (HOPELESS if iteration < LATE else 1.0):
                return None
            if iteration >= ITERATIONS and (iteration == MOST_ITERATIONS or residual > earlier / 4):
                return None
            earlier, last = last, residual
            if fresh and residual < NEARLY:
                fresh = False
            elif not (fresh := self._factorise(values)):
                self.cost.indefinite += 1
                unstable += 1
                if drag is not None or unstable > UNSTABLE or self.matrix.indefinite(values) > NEGATIVES:
                    return None
            step = self._solve(-force)
            turn = np.abs(step[s.turns]).max(initial=0.0)
            if turn > TURN:
                step *= TURN / turn
            step *= line_search.share(s, q, step, force)
            s.extrapolate(q, step)
            q = q + step
        return None

    def _relaxed(self, q: np.ndarray, load: Load) -> Point | None:
        """The stable state that a drag, let go little by little, leads to from `q`.

        Friction's bonds follow every step of artificial time. Past a limit point the finger lingers, nearly
        in balance, before it runs: it is let go each time that what the drag holds has fallen to a tenth. A
        wall that gives way ends it (`handgen.simulation.runaway`); `ran_away` keeps it.
        """
        s = self.system
        centre, strength, weak, calm = q, DRAG, 0.0, CALM
        self._unstable = False
        for _ in range(RELAXATIONS):
            assembled = s.assemble(centre, load, exact=True)
            self._unstable = self._unstable or not self._factorise(assembled[2])
            s.extrapolate(centre, np.zeros_like(centre))
            found = self._newton(centre, load, strength * s.inertia, centre, assembled)
            if found is None:
                weak, strength = strength, 3.0 * strength
                if strength > 1e6 * DRAG:
                    return None
                continue
            dragged = float(np.abs(strength * s.inertia * (found[0] - centre)).max() / self._acting(load))
            centre = found[0]
            s.accept(centre)
            wall = runaway.weakest(s, centre)
            if wall.runs_away:
                self.ran_away = wall
                return None
            calm = max(calm, min(CALM, dragged / 10))
            if dragged < calm:
                free = self._newton(centre, load)
                if free is not None:
                    return Point(load, free[0], free[1])
                calm = dragged / 10
            # As low as is easy to follow, but not at once to where it was too low: what it must hold changes.
            strength *= 0.8 if found[2] > EASY else 0.4 if found[2] > PLAIN else 0.16
            strength, weak = max(strength, TOO_WEAK * weak), 0.8 * weak
        return None

    def _stable(self, point: Point) -> bool:
        """Whether the tangent of `point` is positive definite; it stays factorised."""
        _, _, values, least = self.system.assemble(point.q, point.load, exact=True)
        self._stands = point.q if least > 0.0 and self._factorise(values) else None
        return self._stands is not None

    def _factorise(self, values: np.ndarray) -> bool:
        self.cost.factorisations += 1
        return self.matrix.factorise(values)

    def _solve(self, force: np.ndarray) -> np.ndarray:
        """What `force` moves, by the factorised tangent and by friction's part, which is not symmetric.

        The factor preconditions: half a dozen solutions with it do.
        """
        found, friction = self.matrix.solve(force), self.system.coupling()
        if friction is None:
            return found
        return gmres(lambda step: step + self.matrix.solve(friction(step)), found, COUPLED, SOLUTIONS)

    def _acting(self, load: Load) -> float:
        """The largest acting force on an unknown, N: what the residual is measured against."""
        return max(self.system.loads.largest(load), LEAST_FORCE)
