"""The shortest schedule of a few castings by mixed-integer programming (HiGHS), for tests.

Written from the rules alone: it shares nothing with `handgen.worksheet.timeline` but the durations.
"""

import itertools

import numpy as np
from scipy.optimize import Bounds, LinearConstraint, milp


def shortest(durations, moulds):
    """Minutes until the last actuator leaves its mould, proven."""
    d, names = durations, list(durations.wind)
    # Operations of the hands: six an actuator, and a mix that each pour could have of its own.
    ops = {(n, what): time for n in names for what, time in (
        ("wind", d.wind[n]), ("close", d.assemble), ("pour1", d.pour), ("open", d.open), ("pour2", d.pour),
        ("out", d.demould))}
    pours = [op for op in ops if op[1].startswith("pour")]
    ops |= {("mix", pour): d.mix for pour in pours}
    columns = _Columns(sum(ops.values()) + 2 * len(names) * d.cure)
    for op in ops:
        columns.add(op)
    columns.add("end")
    for n in names:
        columns.atleast({(n, "close"): 1, (n, "wind"): -1}, d.wind[n])
        columns.atleast({(n, "pour1"): 1, (n, "close"): -1}, d.assemble)
        columns.atleast({(n, "open"): 1, (n, "pour1"): -1}, d.pour + d.cure)
        columns.atleast({(n, "pour2"): 1, (n, "open"): -1}, d.open)
        columns.atleast({(n, "out"): 1, (n, "pour2"): -1}, d.pour + d.cure)
        columns.atleast({"end": 1, (n, "out"): -1}, d.demould)
    _mixes(columns, pours, d)
    _one_pair_of_hands(columns, ops, pours)
    _moulds(columns, names, moulds, d)
    return columns.least("end")


def _mixes(columns, pours, d):
    """Every pour takes from one mix; a mix that nothing takes from does not count."""
    for pour in pours:
        taken = {}
        for mix in pours:
            use = ("uses", pour, mix)
            columns.add(use, binary=True)
            taken[use] = 1
            columns.atleast({pour: 1, ("mix", mix): -1, use: -columns.big}, d.mix - columns.big)
            columns.atleast({pour: -1, ("mix", mix): 1, use: -columns.big},
                            d.pour - d.pot_life - columns.big)
            columns.atleast({("uses", mix, mix): 1, use: -1} if mix != pour else {use: 0}, 0)
        columns.exactly(taken, 1)


def _one_pair_of_hands(columns, ops, pours):
    for one, other in itertools.combinations(ops, 2):
        first = ("before", one, other)
        columns.add(first, binary=True)
        idle = {("uses", op[1], op[1]): -columns.big for op in (one, other) if op[0] == "mix"}
        slack = columns.big * (1 + len(idle))
        columns.atleast({other: 1, one: -1, first: -columns.big, **idle}, ops[one] - slack)
        columns.atleast({one: 1, other: -1, first: columns.big, **idle},
                        ops[other] - columns.big * len(idle))


def _moulds(columns, names, moulds, d):
    """Each actuator takes one of the moulds, from its closing until it is out."""
    for n in names:
        for mould in range(moulds):
            columns.add(("takes", n, mould), binary=True)
        columns.exactly({("takes", n, mould): 1 for mould in range(moulds)}, 1)
    for one, other in itertools.permutations(names, 2):
        columns.add(("first", one, other), binary=True)
    for one, other in itertools.combinations(names, 2):
        for mould in range(moulds):
            columns.atleast({("first", one, other): 1, ("first", other, one): 1, ("takes", one, mould): -1,
                             ("takes", other, mould): -1}, -1)
    for one, other in itertools.permutations(names, 2):
        columns.atleast({(other, "close"): 1, (one, "out"): -1, ("first", one, other): -columns.big},
                        d.demould - columns.big)


class _Columns:
    def __init__(self, big):
        self.big, self.index, self.binary = big, {}, []
        self.rows, self.low, self.high = [], [], []

    def add(self, name, binary=False):
        self.index[name] = len(self.index)
        self.binary.append(binary)

    def atleast(self, terms, low, high=np.inf):
        self.rows.append(terms)
        self.low.append(low)
        self.high.append(high)

    def exactly(self, terms, value):
        self.atleast(terms, value, value)

    def least(self, name):
        matrix = np.zeros((len(self.rows), len(self.index)))
        for i, terms in enumerate(self.rows):
            for term, factor in terms.items():
                matrix[i, self.index[term]] += factor
        cost = np.zeros(len(self.index))
        cost[self.index[name]] = 1.0
        binary = np.array(self.binary)
        solved = milp(cost, constraints=LinearConstraint(matrix, self.low, self.high), integrality=binary,
                      bounds=Bounds(0, np.where(binary, 1, np.inf)), options={"mip_rel_gap": 1e-6})
        assert solved.success, solved.message
        return solved.fun
