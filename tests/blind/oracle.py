# SPDX-License-Identifier: Apache-2.0
"""What could be named at best: a likelihood ratio that knows how each candidate effect would look in this very campaign.

It knows the standard deviations of blocks, placements and visits, the true positions and temperatures, and for each
candidate the course of its contributions over all blocks and sensors, but for one factor: the size. It does not know
which candidates are there, nor the unit's curves: the base, refitted with every candidate, has a free level, slope and
curvature at each set point, an offset per run, and for accelerometers a scale error per set point and two constant
off-axis terms.

For Gaussian noise of known covariance, twice the logarithm of the likelihood ratio of a set of candidates against none
is what the set takes off the sum of squares of the whitened residual.
"""
import itertools

import numpy as np

from blocks import BLOCKS_PER_STAY, SENSORS, STAYS_PER_VISIT, up_vectors

# A candidate that keeps less than this of its square beside the base, or beside the other of a pair, is not seen at all.
ABSORBED = 1e-6


def whitened(columns, noise):
    """`columns` (blocks, any number) times the inverse root of the covariance of blocks in stays in visits.

    The covariance is block-diagonal; its eigenspaces are differences within a stay, differences of stays within a visit,
    and means of visits, with the variances b, b + 3 p and b + 3 p + 18 v (b, p, v: of blocks, placements, visits).
    """
    by_visit = columns.reshape(-1, STAYS_PER_VISIT, BLOCKS_PER_STAY, columns.shape[1])
    of_stay = by_visit.mean(axis=2, keepdims=True)
    of_visit = by_visit.mean(axis=(1, 2), keepdims=True)
    within = noise["block_sigma"] ** 2
    stays = within + BLOCKS_PER_STAY * noise["placement_sigma"] ** 2
    visits = stays + STAYS_PER_VISIT * BLOCKS_PER_STAY * noise["visit_sigma"] ** 2
    white = (by_visit - of_stay) / within**0.5 + (of_stay - of_visit) / stays**0.5 + of_visit / visits**0.5
    return white.reshape(columns.shape)


def indicators(keys):
    """(n, number of different keys): 1 where a row has the key."""
    return (keys[:, None] == np.unique(keys)[None, :]).astype(float)


def base_columns(blocks, truth, sensor):
    axis, accelerometer = sensor % 3, sensor >= 3
    at = indicators(blocks.plateau_c)
    up = up_vectors([block[2] for block in truth["blocks"]])
    beside_k = (np.array([block[4] for block in truth["blocks"]]) - blocks.plateau_c)[:, None]
    columns = [indicators(blocks.run), at, at * beside_k, at * beside_k**2]
    if accelerometer:
        columns += [at * up[:, [axis]], up[:, [(axis + 1) % 3, (axis + 2) % 3]]]
    return np.hstack(columns)


def orthonormal(columns):
    """An orthonormal basis of what the columns span."""
    basis, sizes, _ = np.linalg.svd(columns / np.linalg.norm(columns, axis=0).clip(1e-300), full_matrices=False)
    return basis[:, sizes > 1e-9 * sizes[0]]


def normal_equations(blocks, truth):
    """Names of the candidates; their Gram matrix and their products with the readings, whitened and beside the base,
    summed over the sensors."""
    candidates = truth["units"][0]["candidates"]
    courses = np.array([candidate["contributions"] for candidate in candidates])  # candidate, block, sensor
    gram, products = np.zeros((len(candidates),) * 2), np.zeros(len(candidates))
    for sensor in range(len(SENSORS)):
        noise = truth["noise"]["gyro" if sensor < 3 else "accel"]
        base = orthonormal(whitened(base_columns(blocks, truth, sensor), noise))
        seen = whitened(np.column_stack([blocks.readings[:, sensor], courses[:, :, sensor].T]), noise)
        left = seen - base @ (base.T @ seen)
        residual, candidate = left[:, 0], left[:, 1:]
        candidate[:, (candidate**2).sum(axis=0) < ABSORBED * (seen[:, 1:] ** 2).sum(axis=0)] = 0.0
        gram += candidate.T @ candidate
        products += candidate.T @ residual
    return [candidate["name"] for candidate in candidates], gram, products


def ratio(gram, products, chosen):
    """Twice the log likelihood ratio of the candidates with these indices; 0 for what is not seen."""
    part, wanted = gram[np.ix_(chosen, chosen)], products[chosen]
    scale = np.sqrt(np.diag(part))
    if np.any(scale == 0.0):
        return 0.0
    correlation = part / np.outer(scale, scale)
    if np.linalg.det(correlation) < ABSORBED:
        return 0.0
    return float(wanted / scale @ np.linalg.solve(correlation, wanted / scale))


def best(names, gram, products, count):
    """The most likely set of `count` candidates: {"names", "ratio"}."""
    sets = itertools.combinations(range(len(names)), count)
    value, chosen = max((ratio(gram, products, list(chosen)), chosen) for chosen in sets)
    return {"names": [names[i] for i in chosen], "ratio": value}


def most_likely(blocks, truth):
    """The most likely candidate and the most likely pair: [{"names", "ratio"}, {"names", "ratio"}]."""
    equations = normal_equations(blocks, truth)
    return [best(*equations, 1), best(*equations, 2)]


def names_beyond(found, threshold, most):
    """The names that the oracle gives: of none and the sets `found` up to `most` names the one that is most likely, each
    name at the price of `threshold`."""
    priced = [(0.0, [])] + [(one["ratio"] - threshold * len(one["names"]), one["names"]) for one in found[:most]]
    return max(priced, key=lambda entry: entry[0])[1]
