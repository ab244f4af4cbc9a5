# SPDX-License-Identifier: Apache-2.0
"""Recordings of a gyro with thermal hysteresis, from a formula of its own: a lens between heating and cooling."""
import math
import random

HEADER = "t_s,run,phase,sweep,plateau_c,position,temp_c,gx_dps"
STEPS_C = tuple(range(-30, 75, 10))
GAP_DPS = 0.05
RUN_SIGMA_DPS = 0.01
NOISE_DPS = 0.01
SAMPLES = 60  # of a visit, at 1 Hz


class Unit:
    """Its bias over temperature, drawn anew for each seed."""

    def __init__(self, seed):
        self.random = random.Random(seed)
        self.centre, self.width = self.random.uniform(-10, 50), self.random.uniform(20, 40)
        self.span, self.level = self.random.uniform(0.1, 0.3), self.random.uniform(-0.3, 0.3)
        self.sign = self.random.choice((-1, 1))  # whether it reads more or less when it heats

    def middle(self, temp_c):
        return self.level + self.span * math.atan((temp_c - self.centre) / self.width)

    def branch(self, temp_c, way):
        """way: +1 heating, -1 cooling. The loop closes at -30 and 70 °C, where the way turns."""
        z = (temp_c - 20) / 50
        return self.middle(temp_c) + self.sign * way * 0.5 * GAP_DPS * max(0.0, 1 - z * z)

    def power_on(self):
        """The offset of one power-on."""
        return self.random.gauss(0, RUN_SIGMA_DPS)

    def run(self, label, ways=("up",)):
        """One run as CSV: every 10 °C upwards, and back where `ways` says so."""
        path = [(t, "up") for t in STEPS_C]
        if "down" in ways:
            path += [(t, "down") for t in reversed(STEPS_C[:-1])]
        offset, t_s, lines = self.power_on(), 0.0, [HEADER]
        for plateau, sweep in path:
            reads = self.branch(plateau, 1 if sweep == "up" else -1) + offset
            for _ in range(SAMPLES):
                temp_c = plateau + self.random.gauss(0, 0.02)
                lines.append(f"{t_s:.1f},{label},soak,{sweep},{plateau},+Z,{temp_c:.3f},{reads + self.random.gauss(0, NOISE_DPS):.6f}")
                t_s += 1.0
            t_s += 600.0
        return "\n".join(lines) + "\n"


def binomial_interval(inside, count, level=0.95):
    """Exact interval (Clopper and Pearson 1934) of a share, by bisection of the binomial distribution."""
    def at_most(k, p):
        return sum(math.comb(count, i) * p**i * (1 - p)**(count - i) for i in range(k + 1))

    def root(f):
        low, high = 0.0, 1.0
        for _ in range(60):
            middle = (low + high) / 2
            low, high = (middle, high) if f(middle) else (low, middle)
        return low

    tail = (1 - level) / 2
    least = 0.0 if inside == 0 else root(lambda p: 1 - at_most(inside - 1, p) < tail)
    most = 1.0 if inside == count else root(lambda p: at_most(inside, p) > tail)
    return least, most
