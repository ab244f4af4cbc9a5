# SPDX-License-Identifier: Apache-2.0
"""A session on a bench as CSV: a unit that is put down in attitude after attitude by hand, with known truth.

Rotations are products of closed forms, rates their derivatives; nothing is shared with the project's own code.
"""
import math
import random

GRAVITY = 9.80665
ACCEL_GAIN = ((1.004, 0.006, -0.004), (0.0, 0.997, 0.008), (0.0, 0.0, 1.002))
ACCEL_BIAS = (0.15, -0.08, 0.21)
GYRO_GAIN = ((1.012, 0.004, -0.007), (-0.005, 0.991, 0.003), (0.006, -0.002, 1.005))
GYRO_BIAS_DPS = (0.7, -1.1, 0.4)
FACES = {"+X": (1, 0, 0), "-X": (-1, 0, 0), "+Y": (0, 1, 0), "-Y": (0, -1, 0), "+Z": (0, 0, 1), "-Z": (0, 0, -1)}
HEADER = "t_s,temp_c,gx_dps,gy_dps,gz_dps,ax_mps2,ay_mps2,az_mps2"


def times(m, v):
    return [sum(a * b for a, b in zip(row, v)) for row in m]


def transposed(m):
    return [list(column) for column in zip(*m)]


def product(a, b):
    return [[sum(a[i][k] * b[k][j] for k in range(3)) for j in range(3)] for i in range(3)]


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def unit(v):
    length = math.sqrt(sum(x * x for x in v))
    return [x / length for x in v]


def rotation(n, angle):
    c, s = math.cos(angle), math.sin(angle)
    skew = ((0, -n[2], n[1]), (n[2], 0, -n[0]), (-n[1], n[0], 0))
    return [[(c if i == j else 0.0) + (1 - c) * n[i] * n[j] + s * skew[i][j] for j in range(3)] for i in range(3)]


class Session:
    def __init__(self, seed=1, rate_hz=50, temp_c=24.0, labels=False, turns=False):
        self.noise = random.Random(seed)
        self.rate_hz, self.temp_c, self.labels, self.with_turns = rate_hz, temp_c, labels, turns
        self.attitude = rotation(unit([1, 2, 3]), 0.7)
        self.lines = [HEADER + (",position" if labels else "") + (",turn_deg" if turns else "")]
        self.rows = 0

    def up(self):
        return times(transposed(self.attitude), (0, 0, 1))

    def rest(self, seconds=4.0, label=""):
        for _ in range(int(seconds * self.rate_hz)):
            self.row(self.attitude, (0, 0, 0), label, None)

    def turn(self, axis, angle, seconds, stated=None):
        n = int(seconds * self.rate_hz)
        for i in range(n):
            x = i / n
            share = x - math.sin(2 * math.pi * x) / (2 * math.pi)
            rate = angle * (1 - math.cos(2 * math.pi * x)) / seconds
            self.row(product(self.attitude, rotation(axis, angle * share)), [rate * a for a in axis], "", stated)
        self.attitude = product(self.attitude, rotation(axis, angle))

    def tilt_to(self, target):
        now, target = self.up(), unit(target)
        axis = cross(target, now)
        angle = math.atan2(math.sqrt(sum(a * a for a in axis)), sum(a * b for a, b in zip(now, target)))
        if angle > 3.1:
            axis = cross(now, (now[1], now[2], now[0]))
        self.turn(unit(axis), angle, 2.0)

    def whole_turn(self, sign=1):
        self.turn(self.up(), sign * 2 * math.pi, 4.0, 360)

    def row(self, attitude, rate_rps, label, stated):
        force = times(ACCEL_GAIN, times(transposed(attitude), (0, 0, GRAVITY)))
        gyro = times(GYRO_GAIN, [math.degrees(x) for x in rate_rps])
        values = [g + b + self.noise.gauss(0, 0.05) for g, b in zip(gyro, GYRO_BIAS_DPS)]
        values += [f + b + self.noise.gauss(0, 0.01) for f, b in zip(force, ACCEL_BIAS)]
        cells = [f"{self.rows / self.rate_hz:.3f}", f"{self.temp_c + self.noise.gauss(0, 0.02):.3f}", *(f"{v:.6f}" for v in values)]
        if self.labels:
            cells.append(label)
        if self.with_turns:
            cells.append("" if stated is None else str(stated))
        self.lines.append(",".join(cells))
        self.rows += 1

    def csv(self):
        return "\n".join(self.lines) + "\n"


def attitudes(count=22, seed=1, **options):
    """Attitudes that nobody names."""
    session = Session(seed, **options)
    spread = random.Random(seed + 100)
    session.rest()
    for _ in range(count - 1):
        session.tilt_to([spread.gauss(0, 1) for _ in range(3)])
        session.rest()
    return session.csv()


def ferraris(seed=1, turns=True):
    """The six faces, named; four whole turns on three of them."""
    session = Session(seed, labels=True, turns=turns)
    for label, up in FACES.items():
        session.tilt_to(up)
        session.rest(label=label)
        for sign in (1, -1, 1, -1) if label[0] == "+" else ():
            session.whole_turn(sign)
            session.rest(label=label)
    return session.csv()
