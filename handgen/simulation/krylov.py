"""Linear equations whose matrix is near the identity, by minimal residuals (Y. Saad, M. H. Schultz, SIAM J.
Sci. Stat. Comput. 7 (1986) 856-869).

A product costs a solution with the tangent's factor, and half a dozen do: none is spent on what is known
already, the residual of the last.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np


def gmres(product: Callable[[np.ndarray], np.ndarray], right: np.ndarray, tolerance: float,
          most: int) -> np.ndarray:
    """x of `product`(x) = `right` with a residual of at most `tolerance` relative to `right`, or as it is
    after `most` products."""
    size = float(np.linalg.norm(right))
    if size == 0.0:
        return np.zeros_like(right)
    ways, projected = np.empty((most + 1, len(right))), np.zeros((most + 1, most))
    ways[0] = right / size
    first = np.zeros(most + 1)
    first[0] = size
    share = np.zeros(0)
    for k in range(most):
        new = product(ways[k])
        known = ways[:k + 1]
        for _ in range(2):  # once more: what rounding leaves along the known ways
            along = known @ new
            new = new - along @ known
            projected[:k + 1, k] += along
        projected[k + 1, k] = length = float(np.linalg.norm(new))
        share, *_ = np.linalg.lstsq(projected[:k + 2, :k + 1], first[:k + 2])
        left = float(np.linalg.norm(first[:k + 2] - projected[:k + 2, :k + 1] @ share))
        if left <= tolerance * size or length == 0.0:
            break
        ways[k + 1] = new / length
    return share @ ways[:len(share)]
