# SPDX-License-Identifier: Apache-2.0
"""A campaign's recording as means of one-minute blocks: numpy arrays, a row per block, in order of time."""
import numpy as np

SENSORS = ("gyro_x", "gyro_y", "gyro_z", "accel_x", "accel_y", "accel_z")
READINGS = ("gx_dps", "gy_dps", "gz_dps", "ax_mps2", "ay_mps2", "az_mps2")
ROWS_PER_BLOCK = 6
BLOCKS_PER_STAY = 3
STAYS_PER_VISIT = 6


class Recording:
    """Columns of a CSV of soaksim-campaign's designs, all rows, also those on the way: `number` and `text` by name."""

    def __init__(self, path):
        with open(path, encoding="utf-8") as file:
            self.names = file.readline().rstrip("\n").split(",")
            self.columns = dict(zip(self.names, zip(*(line.rstrip("\n").split(",") for line in file))))

    def text(self, name):
        return np.array(self.columns[name])

    def number(self, name):
        return np.array(self.columns[name], dtype=float)

    def has(self, name):
        return name in self.columns


def up_vectors(labels):
    """(n, 3): the body axis that points up, from position labels ("+X"...)."""
    up = np.zeros((len(labels), 3))
    for label in set(labels):
        up[np.array(labels) == label, "XYZ".index(label[1])] = 1.0 if label[0] == "+" else -1.0
    return up


def ordinals(*keys):
    """0, 1, ... in order of appearance of what `keys` have in common, a new one at each change."""
    changed = np.zeros(len(keys[0]), dtype=bool)
    for key in keys:
        changed[1:] |= key[1:] != key[:-1]
    return np.cumsum(changed)


class Blocks:
    """run, visit, stay: ordinals; plateau_c, temp_c; up (n, 3) as labelled; readings (n, 6) in deg/s and m/s2."""

    def __init__(self, recording):
        self.recording = recording
        self.in_position = recording.text("position") != ""
        stays = np.cumsum(self.in_position & ~np.concatenate(([False], self.in_position[:-1])))
        self.run = np.unique(self.first(recording.text("run")), return_inverse=True)[1]
        self.plateau_c = self.first(recording.number("plateau_c"))
        self.visit = ordinals(self.run, self.plateau_c)
        self.stay = ordinals(self.first(stays))
        self.temp_c = self.mean(recording.number("temp_c"))
        self.up = up_vectors(self.first(recording.text("position")))
        self.readings = np.column_stack([self.mean(recording.number(name)) for name in READINGS])

    def first(self, column):
        """What the first row of each block has."""
        return column[self.in_position][::ROWS_PER_BLOCK]

    def mean(self, column):
        return column[self.in_position].reshape(-1, ROWS_PER_BLOCK).mean(axis=1)
