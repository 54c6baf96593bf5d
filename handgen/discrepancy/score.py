"""How probable is every explanation: nothing missing, one effect, two effects, something no effect explains.

Nuisances are Gaussian with physical priors and integrated in closed form; an effect's parameters are summed
over a grid of simulated responses with their prior; the structural error is the ensemble's covariance, of
which the scale is summed over too. Nothing is fitted and then compared: what is compared is how well each
explanation, with all that it leaves open, foresaw the data.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from statistics import NormalDist

import numpy as np

from handgen.discrepancy import law, outside
from handgen.discrepancy import pairs as of_pairs
from handgen.discrepancy.gaussian import Whitener, log_sum
from handgen.discrepancy.hypothesis import INTERVAL, WIDE, Draft, Estimate, Hypothesis, estimates
from handgen.discrepancy.library import NONE, OUTSIDE, Library, size_name
from handgen.discrepancy.observed import Observed
from handgen.discrepancy.problem import SCALE_WEIGHTS, Problem

PRIOR = {NONE: 0.40, "single": 0.30, "pair": 0.10, OUTSIDE: 0.20}
"""Before any data: of nothing missing, of all effects together, of all pairs together, of something else."""


@dataclass(frozen=True)
class Scores:
    """All hypotheses, the most probable first; probabilities add up to 1."""

    problem: Problem
    hypotheses: tuple[Hypothesis, ...]
    log_evidence: float
    """Of all of them together."""

    def __getitem__(self, name: str) -> Hypothesis:
        return next(h for h in self.hypotheses if h.id == name)

    @property
    def probabilities(self) -> dict[str, float]:
        """By id, the most probable first."""
        return {h.id: h.probability for h in self.hypotheses}

    def present(self, effect: str) -> float:
        """Probability that an effect is there, alone or with another."""
        return sum(h.probability for h in self.hypotheses if effect in h.ids)

    def without(self, *effects: str, prior: Mapping[str, float] = PRIOR) -> Scores:
        """What is left with `effects` struck off the catalogue."""
        library = self.problem.library.without(*effects)
        kept = [h for h in self.hypotheses if not set(effects) & set(h.ids)]
        shares, evidence = _shares(library, kept, prior)
        found = [replace(h, probability=share) for h, share in zip(kept, shares, strict=True)]
        return Scores(replace(self.problem, library=library), _ordered(found), evidence)

    def or_else(self, other: Scores, probability: float) -> Scores:
        """These explanations, or those of `other`: before any reading, these with this `probability`."""
        evidences = np.array([np.log(probability) + self.log_evidence,
                              np.log(1.0 - probability) + other.log_evidence])
        total = log_sum(evidences)
        shares = np.exp(evidences - total)
        found = [replace(h, probability=float(share) * h.probability)
                 for one, share in zip((self, other), shares, strict=True) for h in one.hypotheses]
        return Scores(self.problem, _ordered(found), total)


def score(library: Library, observed: Observed, *, pairs: bool = True, everything: bool = False,
          prior: Mapping[str, float] = PRIOR) -> Scores:
    """Judge every explanation of `observed` by `library`.

    `everything`: also score what a test says is not to be fitted.

    Raises:
        ValueError: the two do not belong together.
    """
    return score_problem(Problem.of(library, observed, everything=everything), pairs=pairs, prior=prior)


def score_problem(problem: Problem, *, pairs: bool = True, process: bool = True,
                  prior: Mapping[str, float] = PRIOR) -> Scores:
    """The same of a problem that is set up already; without `process` nothing outside is looked for.

    Raises:
        ValueError: nothing to score.
    """
    if not problem.used.any():
        raise ValueError("no reading takes part in the scoring")
    library = problem.library
    problem = lawful(problem)
    grids = {name: Grid.of(problem, problem.whiteners((name,)), name) for name in library.responses}
    found = [_none(problem)]
    found += [_single(problem, grid) for grid in grids.values()]
    if process:
        evidence, learned = outside.log_evidence(problem, library.baseline)
        found.append(Draft(library.called(OUTSIDE), (), evidence, {}, library.baseline + learned, 0, problem))
    if pairs and len(grids) > 1:
        found += of_pairs.drafts(problem, list(grids))
    shares, evidence = _shares(library, found, prior)
    hypotheses = [_hypothesis(draft, share) for draft, share in zip(found, shares, strict=True)]
    return Scores(problem, _ordered(hypotheses), evidence)


def lawful(problem: Problem) -> Problem:
    """`problem` with what every effect's law gets wrong where the effect explains the data best."""
    bare = replace(problem, laws={})
    grids = {name: Grid.of(bare, bare.whiteners((name,)), name) for name in problem.library.responses}
    best = {name: int((np.logaddexp.reduce(grid.log_densities) + grid.log_weights).argmax())
            for name, grid in grids.items() if len(grid.values)}
    return replace(problem, laws=law.errors(problem.library, grids, best))


@dataclass(frozen=True)
class Grid:
    """An effect's dense predictions, whitened for each scale of the structural error."""

    id: str
    values: np.ndarray
    predictions: np.ndarray
    log_weights: np.ndarray
    last: np.ndarray
    """See `Dense.last`."""
    white: tuple[np.ndarray, ...]
    """Whitened residuals (m, s) of each scale."""
    log_densities: np.ndarray
    """(scales, m) with the scales' prior in it."""

    @classmethod
    def of(cls, problem: Problem, whiteners: Sequence[Whitener], name: str,
           shares: Sequence[float] = SCALE_WEIGHTS) -> Grid:
        dense = problem.library.responses[name].dense.on(problem.scored)
        residuals = problem.data - dense.predictions[:, problem.scored]
        white = tuple(whiten(residuals) for whiten in whiteners)
        densities = np.array([
            whiten.log_norm - (w**2).sum(axis=1) / 2 + np.log(share)
            for whiten, w, share in zip(whiteners, white, shares, strict=True)])
        return cls(name, dense.values, dense.predictions, dense.log_weights, dense.last, white, densities)


def _none(problem: Problem) -> Draft:
    residual = problem.data - problem.library.baseline[problem.scored]
    terms = [float(w.log_density(residual)) + np.log(share)
             for w, share in zip(problem.whiteners(), SCALE_WEIGHTS, strict=True)]
    library = problem.library
    return Draft(library.called(), (), log_sum(np.array(terms)), {}, library.baseline, 0, problem)


def _single(problem: Problem, grid: Grid) -> Draft:
    library = problem.library
    name, names = library.called(grid.id), library.responses[grid.id].parameters
    if len(grid.values) == 0:
        return Draft(name, (grid.id,), -np.inf, {grid.id: ()}, library.baseline, 0, problem)
    posterior = np.logaddexp.reduce(grid.log_densities) + grid.log_weights
    best = int(posterior.argmax())
    return Draft(name, (grid.id,), log_sum(posterior), {grid.id: estimates(names, grid.values, posterior)},
                 grid.predictions[best], len(names), problem, (grid.id,) if grid.last[best] else ())


def _ordered(found: Sequence[Hypothesis]) -> tuple[Hypothesis, ...]:
    return tuple(sorted(found, key=lambda h: -h.probability))


def _shares(library: Library, drafts: Sequence[Draft | Hypothesis],
            prior: Mapping[str, float]) -> tuple[list[float], float]:
    """(probability of each of `drafts`, which are all that there is; their log evidence together)."""
    families = [_family(library, draft) for draft in drafts]
    shares = np.array([prior[family] / families.count(family) for family in families])
    for i, draft in enumerate(drafts):
        shares[i] *= np.prod([library.prior_odds.get(name, 1.0) for name in draft.ids])
    logs = np.array([d.log_evidence for d in drafts]) + np.log(shares / shares.sum())
    total = log_sum(logs)
    return [float(share) for share in np.exp(logs - total)], total


def _family(library: Library, draft: Draft | Hypothesis) -> str:
    """What it says beside the effects that are on."""
    if draft.outside:
        return OUTSIDE
    return (NONE, "single", "pair")[len(set(draft.ids) - set(library.on))]


def _hypothesis(draft: Draft, probability: float) -> Hypothesis:
    from scipy.special import chdtrc

    problem, library = draft.problem, draft.problem.library
    whiten, slopes = problem.whitener(draft.ids), problem.jacobian(draft.ids)
    residual = problem.data - draft.centre[problem.scored]
    white = whiten(residual)
    spread = slopes[problem.scored] @ library.prior
    gain = whiten(spread.T)
    nuisances = gain @ white
    left = library.prior - gain @ gain.T
    size = float(white @ white)
    freedoms = max(len(residual) - draft.count, 1)
    return Hypothesis(draft.id, (*library.on, *draft.ids), draft.log_evidence, probability,
                      {**_sizes(library, nuisances, left), **draft.parameters}, nuisances, left,
                      draft.centre, draft.centre + slopes @ nuisances, size, freedoms,
                      float(chdtrc(freedoms, size)), draft.cut)


def _sizes(library: Library, nuisances: np.ndarray, left: np.ndarray) -> dict[str, tuple[Estimate, ...]]:
    """Parameters of the effects that are on, as the data leave them."""
    column = {name: at for at, name in enumerate(library.nuisances)}
    found = {}
    for effect, values in library.on.items():
        sizes = []
        for name, value in values.items():
            at = column.get(size_name(effect, name))
            off, sigma = (0.0, 0.0) if at is None else (nuisances[at], np.sqrt(left[at, at]))
            low, high, *wide = (float(NormalDist(value + off, sigma).inv_cdf(share) if sigma else value)
                                for share in (*INTERVAL, *WIDE))
            sizes.append(Estimate(name, float(value + off), low, high, (wide[0], wide[1])))
        found[effect] = tuple(sizes)
    return found
