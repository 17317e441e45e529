"""A Gaussian process through noisy values at points of a box, one length scale a quantity.

Values y at n points are a constant m, a smooth function and noise whose variance at each point is
known, as that of a mean over seeds is, plus one that is not. With the covariance K of the function
at the points (Matern, nu = 5/2, r the distance with every edge in units of its length scale) and
the diagonal N of both noises, the function at x is expected at

    m + k(x)' (K + N)^-1 (y - m),    k = s^2 (1 + a + a^2/3) exp(-a),    a = sqrt(5) r

[Rasmussen2006, chapters 2 and 4]. Length scales, s^2 and the unknown noise are where their marginal
likelihood [Rasmussen2006, chapter 5] times a prior is largest: 1 over a length is half-normal with
one edge of the box as its scale, so that a function is not expected to bend more than once from end
to end unless the values say so. m is its best linear estimate. Functions that agree with the
values are drawn path by path: one of the prior, from random Fourier features, is moved by what it
misses the values by [Wilson2020].

Whether the model is of any use is asked of points that it has not seen: Q^2 is 1 less its squared
error there over that of the mean of the seen ones [Marrel2009]. Derived here: it predicts if the
gain in squared error is told from none over the points, one-sided at 5 %; a model that fits noise
predicts worse than the mean, so that the test errs on the side of no model.

References:
    Marrel2009: A. Marrel, B. Iooss, B. Laurent, O. Roustant, Calculations of Sobol indices for the
        Gaussian process metamodel, Reliability Engineering & System Safety, 2009.
    Rasmussen2006: C. E. Rasmussen and C. K. I. Williams, Gaussian Processes for Machine Learning,
        2006.
    Wilson2020: J. Wilson et al., Efficiently sampling functions from Gaussian process posteriors,
        ICML, 2020.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import sqrt
from typing import NamedTuple

import numpy as np
from scipy.linalg import cho_factor, cho_solve
from scipy.optimize import minimize
from scipy.spatial.distance import cdist

FOLDS = 8
STARTS = (0.7, 3.0)  # length scales that the search for the best ones begins at
LENGTHS = (0.05, 50.0)  # edges of the box; the longer end is a quantity without effect
LEAST_NOISE = 1e-6  # of the values' variance, so that equal points make no singular matrix
FEATURES = 600  # of a path: the prior's covariance is met to about 1 / sqrt of it
TOLD = 1.645  # standard errors of a gain that is told from none, one-sided at 5 %

Function = Callable[[np.ndarray], np.ndarray]


class Quality(NamedTuple):
    """How well a model predicts points that it has not seen.

    Attributes:
        q_squared: 1 less its squared error over that of the mean; at most 1, below 0 for a model
            that is worse than the mean.
        predicts: Whether it is better than the mean by more than chance.
    """

    q_squared: float
    predicts: bool


@dataclass(frozen=True, kw_only=True, eq=False)
class GaussianProcess:
    """A fitted model.

    Attributes:
        points: Places in the unit box. Shape (n, k).
        values: At the points. Shape (n,).
        noise: Variance of the values at each point, known and found together. Shape (n,).
        variance: s^2, of the function.
        lengths: Length scales in edges of the box. Shape (k,).
        mean: m, the constant.
    """

    points: np.ndarray
    values: np.ndarray
    noise: np.ndarray
    variance: float
    lengths: np.ndarray
    mean: float

    def predict(self, places: np.ndarray, values: np.ndarray | None = None) -> np.ndarray:
        """Expected function at places of shape (m, k), other values in place of its own if given.

        Values of shape (n, draws) give a result of shape (m, draws), one column each.
        """
        seen = self.values if values is None else values
        weights = cho_solve(self._factor(), seen - self.mean)
        return self.mean + self._covariance(places, self.points) @ weights

    def paths(self, generator: np.random.Generator, values: np.ndarray) -> Function:
        """Functions drawn from those that agree with values, one a column of shape (n, draws).

        Returns:
            From places of shape (m, k) to an array of shape (m, draws).
        """
        n, draws = values.shape
        k = len(self.lengths)
        # A Matern covariance of 5/2 is a mixture of Gaussian ones: its frequencies are Student's t.
        spread = np.sqrt(5.0 / generator.chisquare(5.0, (FEATURES, 1)))
        frequencies = generator.standard_normal((FEATURES, k)) * spread / self.lengths
        phases = generator.uniform(0.0, 2.0 * np.pi, FEATURES)
        weights = generator.standard_normal((FEATURES, draws)) * sqrt(
            2.0 * self.variance / FEATURES
        )

        def prior(places: np.ndarray) -> np.ndarray:
            return np.cos(places @ frequencies.T + phases) @ weights

        noise = generator.standard_normal((n, draws)) * np.sqrt(self.noise)[:, None]
        missed = values - self.mean - prior(self.points) - noise
        moved = cho_solve(self._factor(), missed)
        return lambda places: (
            self.mean + prior(places) + self._covariance(places, self.points) @ moved
        )

    def _covariance(self, one: np.ndarray, other: np.ndarray) -> np.ndarray:
        return self.variance * _matern(cdist(one / self.lengths, other / self.lengths))

    def _factor(self) -> tuple[np.ndarray, bool]:
        own = self._covariance(self.points, self.points) + np.diag(self.noise)
        factor: tuple[np.ndarray, bool] = cho_factor(own, lower=True)
        return factor


def _matern(distance: np.ndarray) -> np.ndarray:
    a = sqrt(5.0) * distance
    return np.asarray((1.0 + a + a * a / 3.0) * np.exp(-a))


def fit_process(
    points: np.ndarray, values: np.ndarray, noise: np.ndarray | float = 0.0
) -> GaussianProcess:
    """The Gaussian process of the likeliest length scales.

    Args:
        points: Places in the unit box. Shape (n, k).
        values: At the points. Shape (n,).
        noise: Known variance of the values, of each point or of all.
    """
    scale = float(np.std(values)) or 1.0
    centre = float(np.mean(values))
    y = (values - centre) / scale
    known = np.broadcast_to(np.asarray(noise, dtype=float), y.shape) / scale**2
    squares = (points[:, None, :] - points[None, :, :]) ** 2
    k = points.shape[1]
    bounds = [
        (np.log(1e-3), np.log(1e3)),
        *[tuple(np.log(LENGTHS))] * k,
        (np.log(LEAST_NOISE), np.log(10.0)),
    ]
    found = [
        minimize(
            _loss,
            np.array([0.0, *[np.log(length)] * k, np.log(0.1)]),
            (squares, y, known),
            jac=True,
            bounds=bounds,
            method="L-BFGS-B",
            options={"maxiter": 200},
        )
        for length in STARTS
    ]
    best = min(found, key=lambda result: float(result.fun)).x
    variance, lengths, extra = np.exp(best[0]), np.exp(best[1:-1]), np.exp(best[-1])
    covariance = variance * _matern(np.sqrt(squares @ lengths**-2.0))
    factor = cho_factor(covariance + np.diag(known + extra), lower=True)
    return GaussianProcess(
        points=points,
        values=values,
        noise=(known + extra) * scale**2,
        variance=float(variance) * scale**2,
        lengths=lengths,
        mean=centre + scale * _constant(factor, y),
    )


def _constant(factor: tuple[np.ndarray, bool], y: np.ndarray) -> float:
    """Best linear estimate of the constant below the function."""
    ones = cho_solve(factor, np.ones(len(y)))
    return float(ones @ y) / float(ones.sum())


def _loss(
    theta: np.ndarray, squares: np.ndarray, y: np.ndarray, known: np.ndarray
) -> tuple[float, np.ndarray]:
    """Minus the logarithm of marginal likelihood times prior, and its gradient in log parameters.

    Args:
        theta: Logarithms of s^2, of k length scales and of the unknown noise. Shape (k + 2,).
        squares: Squared distance of every pair of points along each edge. Shape (n, n, k).
        y: Values. Shape (n,).
        known: Known variances. Shape (n,).
    """
    variance, lengths, extra = np.exp(theta[0]), np.exp(theta[1:-1]), np.exp(theta[-1])
    a = np.sqrt(5.0 * (squares @ lengths**-2.0))
    decay = variance * np.exp(-a)
    covariance = decay * (1.0 + a + a * a / 3.0)
    factor = cho_factor(covariance + np.diag(known + extra), lower=True)
    left = y - _constant(factor, y)
    weights = cho_solve(factor, left)
    inverse = cho_solve(factor, np.eye(len(y)))
    prior = 0.5 * float(np.sum(lengths**-2.0))
    loss = 0.5 * float(left @ weights) + float(np.sum(np.log(np.diag(factor[0])))) + prior
    pull = 0.5 * (inverse - np.outer(weights, weights))  # of the loss in every entry of K + N
    slope = 5.0 / 3.0 * decay * (1.0 + a)  # of the covariance in 1/2 of r^2, but for its sign
    by_length = np.einsum("ij,ijk->k", pull * slope, squares) * lengths**-2.0 - lengths**-2.0
    gradient = [np.sum(pull * covariance), *by_length, extra * np.trace(pull)]
    return loss, np.array(gradient)


def quality(points: np.ndarray, values: np.ndarray, noise: np.ndarray | float = 0.0) -> Quality:
    """How well `fit_process` predicts points that it is not given, each left out in one fold.

    Every fold chooses its own length scales. Arguments as of `fit_process`.
    """
    fold = np.arange(len(values)) % FOLDS
    known = np.broadcast_to(np.asarray(noise, dtype=float), values.shape)
    errors, plain = np.empty(len(values)), np.empty(len(values))
    for number in range(FOLDS):
        out, seen = fold == number, fold != number
        if not out.any():
            continue
        model = fit_process(points[seen], values[seen], known[seen])
        errors[out] = (values[out] - model.predict(points[out])) ** 2
        plain[out] = (values[out] - values[seen].mean()) ** 2
    total = float(plain.sum())
    if total <= 0.0:
        return Quality(0.0, predicts=False)
    gain = plain - errors
    error = float(np.std(gain, ddof=1)) / sqrt(len(gain))
    return Quality(1.0 - float(errors.sum()) / total, float(gain.mean()) > TOLD * error)
