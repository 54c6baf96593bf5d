"""Log densities of many residuals under one Gaussian."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg.lapack import dtrtri


@dataclass(frozen=True)
class Whitener:
    """Turns residuals of covariance C into independent ones of variance 1."""

    lower: np.ndarray
    """Cholesky factor of C."""

    @classmethod
    def of(cls, covariance: np.ndarray) -> Whitener:
        return cls.all_of(covariance[None])[0]

    @classmethod
    def all_of(cls, covariances: np.ndarray) -> list[Whitener]:
        """Of each of (c, s, s) covariances."""
        size = covariances.shape[-1]
        jitter = 1e-9 * np.trace(covariances, axis1=1, axis2=2) / max(size, 1)
        lowers = np.linalg.cholesky(covariances + jitter[:, None, None] * np.eye(size))
        return [cls(lower) for lower in lowers]

    @cached_property
    def inverse(self) -> np.ndarray:
        """Of `lower`: many rows are whitened by one covariance."""
        return dtrtri(self.lower, lower=1)[0]

    def __call__(self, rows: np.ndarray) -> np.ndarray:
        """(..., s) whitened along the last axis."""
        return rows @ self.inverse.T

    @cached_property
    def log_norm(self) -> float:
        return float(-np.log(np.diag(self.lower)).sum() - len(self.lower) / 2 * np.log(2 * np.pi))

    def log_density(self, rows: np.ndarray) -> np.ndarray:
        """Of each row of residuals."""
        return self.log_norm - (self(rows) ** 2).sum(axis=-1) / 2


def log_sum(values: np.ndarray) -> float:
    """log of the sum of exponentials."""
    if len(values) == 0:
        return -np.inf
    most = values.max()
    return float(most + np.log(np.exp(values - most).sum())) if np.isfinite(most) else float(most)
