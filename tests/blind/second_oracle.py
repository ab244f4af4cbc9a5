# SPDX-License-Identifier: Apache-2.0
"""What could be named at best in a campaign of the second laboratory: a likelihood ratio that knows the course of each candidate.

It knows the covariance of the noise, the true temperatures and forces, and for each candidate how it would look in this very
campaign (parameters, weights of the sensors, in which run a step comes and when), but for one factor: the size. It does not know
which candidate is there: candidates that have one course in time for all sensors get the weights of what is hidden, as each could sit
in any sensors, and those that it was drawn for would tell which it is. Of the unit's curves it knows all but the level at each set point: the base is that of the size, a free
level at each set point and an offset per run, for accelerometers a free scale error at each set point and two constant off-axis
terms. It names the candidate of the
largest likelihood ratio, if that is larger than in all but 3 in 1000 campaigns with nothing hidden (Gaussian, so drawn from the
candidates' Gram matrix). No namer that has to find the courses can be expected to do better.
"""
from __future__ import annotations

import numpy as np
from scipy.linalg import solve_triangular

import second_laboratory as lab

FALSE_NAMES = 0.003
DRAWS = 100_000
BLOCK_S = lab.BLOCK_SAMPLES * lab.SAMPLE_S
# A candidate that keeps less than this of its square beside the base is not seen at all.
ABSORBED = 1e-6


def correlation(begin_s: np.ndarray, tau_s: float) -> np.ndarray:
    """Of block means of a Gauss-Markov process of unit variance, whose blocks begin then."""
    within_s = np.arange(lab.BLOCK_SAMPLES) * lab.SAMPLE_S
    apart_s = np.abs(begin_s[:, None] - begin_s)
    later, earlier = np.exp(-within_s / tau_s).mean(), np.exp(within_s / tau_s).mean()
    between = np.exp(-apart_s / tau_s) * later * earlier
    inside = np.exp(-np.abs(within_s[:, None] - within_s) / tau_s).mean()
    return np.where(apart_s < BLOCK_S, inside, between)


def covariance(design: lab.Design, begin_s: np.ndarray, visit: np.ndarray, stay: np.ndarray) -> np.ndarray:
    """Of the blocks of one run, in squares of the white noise of a block; without the run's offset."""
    def same(labels):
        return (labels[:, None] == labels).astype(float)

    found = np.eye(len(begin_s)) + design.placement**2 * same(stay) + design.visit**2 * same(visit)
    if design.slow_kind == "random_walk":
        middle_s = begin_s + 0.5 * BLOCK_S
        return found + design.slow**2 / 3600 * np.minimum(middle_s[:, None], middle_s)
    taus_s = lab.SLOW_TAUS_S[design.slow_kind]
    return found + design.slow**2 / len(taus_s) * sum(correlation(begin_s, tau_s) for tau_s in taus_s)


class Whitening:
    """Blocks of a campaign to rows of unit variance that do not correlate."""

    def __init__(self, campaign: lab.Campaign) -> None:
        log = campaign.log
        first = log.in_blocks[::lab.BLOCK_SAMPLES]
        self.parts = [np.flatnonzero(log.run[first] == run) for run in range(len(log.slices))]
        self.roots = []
        for part in self.parts:
            rows = first[part]
            self.roots.append(np.linalg.cholesky(covariance(campaign.design, log.t_s[rows].astype(float), log.visit[rows], log.stay[rows])))

    def __call__(self, columns: np.ndarray) -> np.ndarray:
        white = np.empty_like(columns)
        for part, root in zip(self.parts, self.roots):
            white[part] = solve_triangular(root, columns[part], lower=True)
        return white


def base_columns(log, axis: int | None) -> np.ndarray:
    """Of a gyro, or of the accelerometer of that axis."""
    first = log.in_blocks[::lab.BLOCK_SAMPLES]
    levels = (log.plateau_c[first][:, None] == np.unique(log.plateau_c)).astype(float)
    runs = (log.run[first][:, None] == np.arange(len(log.slices))).astype(float)
    columns = [runs, levels]
    if axis is not None:
        force_g = lab.block_means(log, log.force_mps2) / lab.GRAVITY_MPS2
        columns += [levels * force_g[:, [axis]], np.delete(force_g, axis, axis=1)]
    return np.hstack(columns)


def orthonormal(columns: np.ndarray) -> np.ndarray:
    basis, sizes, _ = np.linalg.svd(columns / np.linalg.norm(columns, axis=0).clip(1e-300), full_matrices=False)
    return basis[:, sizes > 1e-9 * sizes[0]]


def in_sensors_of_hidden(raw: np.ndarray, own: np.ndarray, hidden: np.ndarray) -> np.ndarray:
    """A candidate with the weights of what is hidden in place of its own, if it has one course for all sensors."""
    strongest = int(np.argmax(np.abs(own)))
    course = raw[:, strongest] / own[strongest]
    return np.outer(course, hidden) if np.allclose(raw, np.outer(course, own)) else raw


def courses(campaign: lab.Campaign, seed: int, candidates: tuple[str, ...], size: float) -> np.ndarray:
    """Block means of each candidate as it would be in this campaign, in blocks: (candidate, block, sensor). Only of a lag
    does the course depend on the size."""
    log, found = campaign.log, []
    hidden = campaign.truth.get("parameters", {}).get("weights")
    for name in candidates:
        if name == "sensor_lag":
            raw = lab.sensor_lag(log, lab.make_unit(seed), size)[0]
        else:
            raw, drawn = lab.SHAPES[name](log, lab.stream(seed, "effect " + name))
            if hidden is not None and "weights" in drawn:
                raw = in_sensors_of_hidden(raw, np.array(drawn["weights"]), np.array(hidden))
        found.append(lab.block_means(log, raw))
    return np.array(found)


def readings_in_blocks(campaign: lab.Campaign, seed: int) -> np.ndarray:
    """What the sensors read beyond their curves, in blocks."""
    log = campaign.log
    plain = lab.respond(lab.make_unit(seed), log.unit_c, log.force_mps2, log.rate_dps)
    return lab.block_means(log, campaign.readings - plain) / lab.BLOCK_SIGMA


def normal_equations(campaign: lab.Campaign, seed: int, shapes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Gram matrix of the candidates, and their products with the readings, whitened and beside the base, over all sensors."""
    white = Whitening(campaign)
    readings = readings_in_blocks(campaign, seed)
    gyro_base = orthonormal(white(base_columns(campaign.log, None)))
    gram, products = np.zeros((len(shapes),) * 2), np.zeros(len(shapes))
    for sensor in range(len(lab.SENSORS)):
        base = gyro_base if sensor < 3 else orthonormal(white(base_columns(campaign.log, sensor - 3)))
        seen = white(np.column_stack([readings[:, sensor], shapes[:, :, sensor].T]))
        left = seen - base @ (base.T @ seen)
        candidate = left[:, 1:]
        candidate[:, np.sum(candidate**2, axis=0) <= ABSORBED * np.sum(seen[:, 1:] ** 2, axis=0)] = 0.0
        gram += candidate.T @ candidate
        products += candidate.T @ left[:, 0]
    return gram, products


def ratios(gram: np.ndarray, products: np.ndarray) -> np.ndarray:
    """Twice the log likelihood ratio of each candidate; 0 for what is not seen."""
    squares = np.diag(gram)
    return np.divide(products**2, squares, out=np.zeros(products.shape), where=squares > 0)


def threshold(gram: np.ndarray, seed: int) -> float:
    """What the largest ratio exceeds in FALSE_NAMES of the campaigns with nothing hidden: products of covariance `gram`."""
    values, vectors = np.linalg.eigh(gram)
    drawn = lab.stream(seed, "oracle").standard_normal((DRAWS, len(gram))) @ (vectors * np.sqrt(values.clip(0))).T
    return float(np.quantile(ratios(gram, drawn).max(axis=1), 1 - FALSE_NAMES))


def named(campaign: lab.Campaign, seed: int, candidates: tuple[str, ...], size: float) -> str | None:
    """The candidate that the oracle names; None where it names none."""
    gram, products = normal_equations(campaign, seed, courses(campaign, seed, candidates, size))
    found = ratios(gram, products)
    best = int(np.argmax(found))
    return candidates[best] if found[best] > threshold(gram, seed) else None
