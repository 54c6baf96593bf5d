"""Linear equations whose matrix is near the identity, by minimal residuals (Y. Saad, M. H. Schultz, SIAM J.
Sci. Stat. Comput. 7 (1986) 856-869).

A product costs a solution with the tangent's factor, and half a dozen do: none is spent on what is known
already, the residual of the last.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np


def gmres(product: Callable[[np.ndarray], np.ndarray], right: np.ndarray, tolerance: float,
          most: int) -> np.ndarray:
    """x of `product`(x) = `right` with a residual of at most `tolerance` relative to `right`, or as it is
    after `most` products."""
    size = float(np.linalg.norm(right))
    if size == 0.0:
        return np.zeros_like(right)
    ways, triangle, turns = np.empty((most + 1, len(right))), np.zeros((most, most)), []
    ways[0] = right / size
    left, turned = size, np.zeros(most)  # of the residual: along what is not known yet, and along what is
    for k in range(most):
        new, known = product(ways[k]), ways[:k + 1]
        column = known @ new
        new = new - column @ known
        more = known @ new  # once more: what rounding leaves along the known ways
        new -= more @ known
        column += more
        length = float(np.linalg.norm(new))
        # Givens' rotations keep what is projected triangular, so that the residual is known at once.
        for i, (cosine, sine) in enumerate(turns):
            a, b = column[i:i + 2]
            column[i:i + 2] = cosine * a + sine * b, cosine * b - sine * a
        across = math.hypot(column[k], length)
        turns.append((column[k] / across, length / across))
        column[k] = across
        triangle[:k + 1, k] = column
        turned[k], left = turns[k][0] * left, -turns[k][1] * left
        if abs(left) <= tolerance * size or length == 0.0:
            break
        ways[k + 1] = new / length
    return np.linalg.solve(triangle[:k + 1, :k + 1], turned[:k + 1]) @ ways[:k + 1]
