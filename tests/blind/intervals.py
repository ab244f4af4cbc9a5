# SPDX-License-Identifier: Apache-2.0
"""Exact (Clopper-Pearson) 95 % intervals of a binomial share, from quantiles of beta distributions."""
from scipy import stats


def lower(k, n):
    """The share at which k or more of n have probability 0.025."""
    return float(stats.beta.ppf(0.025, k, n - k + 1)) if k > 0 else 0.0


def upper(k, n):
    """The share at which k or fewer of n have probability 0.025."""
    return float(stats.beta.ppf(0.975, k + 1, n - k)) if k < n else 1.0


def share(k, n):
    """"k/n = x % (low..high)" as text."""
    if n == 0:
        return "-"
    return f"{k}/{n} = {100 * k / n:.1f} % ({100 * lower(k, n):.1f}..{100 * upper(k, n):.1f})"
