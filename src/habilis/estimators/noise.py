"""Gaussian noise: its covariance, and vectors in units of it."""

from typing import Any

import numpy as np
from jaxtyping import Float64

_SINGULAR = 1e-10  # the least eigenvalue of a correlation matrix that can be inverted well


def covariance_of(noise: Any, size: int | None = None) -> Float64[np.ndarray, "p p"]:
    """The covariance of a sensor's noise, of a sensor of so many components if that is known."""
    given = np.asarray(noise)
    problem = (
        f"noise is {str(noise)[:60]}; give a standard deviation, one a component of the sensor"
    )
    if given.dtype.kind not in "iuf" or given.ndim > 2 or not np.isfinite(given).all():
        raise ValueError(f"{problem}, or a covariance matrix")
    if given.ndim < 2:
        if (given < 0).any():
            raise ValueError(f"{problem}, none below 0")
        if size is None:
            return np.zeros((0, 0))
        if given.ndim and len(given) != size:
            raise ValueError(
                f"noise has {len(given)} numbers, the sensor {size}; give one for each"
            )
        return np.diag(np.broadcast_to(given.astype(np.float64), size) ** 2)
    covariance = given.astype(np.float64)
    if covariance.shape[0] != covariance.shape[1] or not np.allclose(covariance, covariance.T):
        raise ValueError(f"noise has shape {given.shape} or is not symmetric; give a covariance")
    least = np.linalg.eigvalsh(covariance)[0] if covariance.size else 0.0
    if least < -1e-12 * np.trace(covariance):
        raise ValueError("noise is no covariance: it has a negative eigenvalue; give one without")
    if size is not None and len(covariance) != size:
        raise ValueError(
            f"noise has shape {given.shape}, the sensor {size} components; give [{size}, {size}]"
        )
    return covariance


def whitened(
    covariance: Float64[np.ndarray, "*n p p"], vectors: Float64[np.ndarray, "*n p m"]
) -> Float64[np.ndarray, "*n p m"]:
    """Vectors, one a column, in coordinates in which the noise is white.

    Raises:
        ValueError: a covariance is singular.
    """
    deviation, factor = _factored(covariance)
    return np.linalg.solve(factor, vectors / deviation[..., None])


def colored(
    covariance: Float64[np.ndarray, "*n p p"], white: Float64[np.ndarray, "*n p m"]
) -> Float64[np.ndarray, "*n p m"]:
    """White noise, one vector a column, with a covariance: the inverse of `whitened`."""
    deviation, factor = _factored(covariance)
    return deviation[..., None] * (factor @ white)


def log_volume(covariance: Float64[np.ndarray, "*n p p"]) -> Float64[np.ndarray, "*n"]:
    """Half the logarithm of the determinant of a covariance, in nats."""
    deviation, factor = _factored(covariance)
    logs = np.log(deviation * np.diagonal(factor, axis1=-2, axis2=-1))
    return np.asarray(logs.sum(axis=-1))


def _factored(
    covariance: Float64[np.ndarray, "*n p p"],
) -> tuple[Float64[np.ndarray, "*n p"], Float64[np.ndarray, "*n p p"]]:
    """Standard deviations, and Cholesky's factor of the correlation matrix."""
    deviation = np.sqrt(np.diagonal(covariance, axis1=-2, axis2=-1))
    if not (deviation > 0).all():
        silent = int(np.argwhere(~(deviation > 0))[0][-1])
        raise ValueError(
            f"the total noise is singular: component {silent} of the sensor has none, which would "
            "make its capacity infinite; give it noise above 0"
        )
    correlation = covariance / (deviation[..., None] * deviation[..., None, :])
    if not (np.linalg.eigvalsh(correlation)[..., 0] > _SINGULAR).all():
        raise ValueError(
            "the total noise is singular: that of some components of the sensor is always the "
            "same, which would make their capacity infinite; give each noise of its own"
        )
    return deviation, np.linalg.cholesky(correlation)
