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
        jitter = 1e-9 * float(np.trace(covariance)) / max(len(covariance), 1)
        return cls(np.linalg.cholesky(covariance + jitter * np.eye(len(covariance))))

    @cached_property
    def inverse(self) -> np.ndarray:
        """Of `lower`: many rows are whitened by one covariance."""
        return dtrtri(self.lower, lower=1)[0]

    def __call__(self, rows: np.ndarray) -> np.ndarray:
        """(..., s) whitened along the last axis."""
        return rows @ self.inverse.T

    @property
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
