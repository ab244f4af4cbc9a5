# SPDX-License-Identifier: Apache-2.0
"""Campaigns of six positions whose every parameter is known: what stated intervals are counted against.

Written from docs/csv-format.md and docs/fit.md alone, apart from the library and its simulator. A campaign draws anew what
the laboratory does not know: the lean of each face of the fixture and of its base within what the certificates state,
the heading of each face, and local gravity. A unit draws a curve per sensor (a quadratic, a wave and a soft step), offsets
of each power-on, misalignment and g-sensitivity; mounting, scale and g-sensitivity scatter a little from run to run. The
Earth rotates.

    accelerometer i: b(T) + o + (1 + S(T) + s) f_i + sum over j of (M + m)_ij f_j + K (f_i^2 - g^2)
    gyro i:          b(T) + o + w_i + sum over j of (G + q)_ij f_j / g

with f = g up, up and w as the leaning fixture turns them into the axes of the body; o, s, m and q are those of the run.
"""
import io

import numpy as np

SENSORS = ("gyro_x", "gyro_y", "gyro_z", "accel_x", "accel_y", "accel_z")
FACES = ("+X", "-X", "+Y", "-Y", "+Z", "-Z")
UP = np.array([(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)], float)
PLATEAUS_C = np.arange(-20.0, 61.0, 10.0)
LATITUDE_DEG = 48.1
EARTH_DPS = 15.041067 / 3600
GRAVITY_U_MPS2 = 5e-4
FACE_U_DEG = 0.02
LEVEL_U_DEG = 0.01

POWER_ON = np.array([0.02] * 3 + [0.01] * 3)  # deg/s, m/s2: standard deviation between power-ons
WHITE = np.array([0.02] * 3 + [0.01] * 3)  # of one sample
SCALE_SCATTER = 2e-5  # between runs
MOUNTING_SCATTER_RAD = 5e-5  # between runs
G_SCATTER_DPS_PER_G = 1e-3  # between runs


def smooth(rng, amplitude):
    """A curve over temperature, as a function."""
    bend, slope, wave, step = amplitude * rng.normal(size=4) * (0.4, 0.6, 0.2, 0.3)
    phase, middle_c, width_c = rng.uniform(0, 2 * np.pi), rng.uniform(0, 40), rng.uniform(12, 25)

    def curve(temp_c):
        x = (np.asarray(temp_c) - 20.0) / 40.0
        return (bend * x**2 + slope * x + wave * np.sin(3.0 * x + phase)
                + step * np.tanh((np.asarray(temp_c) - middle_c) / width_c))

    return curve


def leaning(rng, count, u_deg):
    """(count, 3) rotation vectors of small leans about each axis, standard deviation `u_deg`."""
    return np.radians(rng.normal(0.0, u_deg, (count, 3)))


class Fixture:
    """What is the same for all runs of a campaign: true up and the Earth's rotation, in the body, of each face."""

    def __init__(self, rng, stated_gravity_mps2):
        self.gravity_mps2 = stated_gravity_mps2 + rng.normal(0.0, GRAVITY_U_MPS2)
        faces = UP + np.cross(leaning(rng, 6, FACE_U_DEG), UP)
        across = np.cross(UP, np.roll(UP, 1, axis=1))
        heading = rng.uniform(0, 2 * np.pi, 6)[:, None]
        north = np.cos(heading) * across + np.sin(heading) * np.cross(UP, across)
        lean_north, lean_east = np.radians(rng.normal(0.0, LEVEL_U_DEG, 2))
        self.up = faces + lean_north * north + lean_east * np.cross(north, UP)
        self.up /= np.linalg.norm(self.up, axis=1)[:, None]
        latitude = np.radians(LATITUDE_DEG)
        self.earth_dps = EARTH_DPS * (np.sin(latitude) * self.up + np.cos(latitude) * north)


class Unit:
    """One unit's truth."""

    def __init__(self, rng):
        self.bias = [smooth(rng, size) for size in (0.3,) * 3 + (0.15,) * 3]
        self.level = rng.normal(0.0, 10 * POWER_ON)
        self.scale = [smooth(rng, 1e-3) for _ in range(3)]
        self.misalignment_rad = rng.normal(0.0, 2e-3, (3, 3)) * (1 - np.eye(3))
        self.even_per_mps2 = rng.normal(0.0, 5e-6, 3)
        self.g_sensitivity_dps_per_g = rng.normal(0.0, 0.02, (3, 3))

    def bias_at(self, sensor, temp_c):
        return self.level[sensor] + self.bias[sensor](temp_c)

    def respond(self, fixture, face, temp_c, power_on):
        """(n, 6) readings without noise, at rest on the faces with these indices."""
        force = fixture.gravity_mps2 * fixture.up[face]
        gyro = fixture.earth_dps[face] + fixture.up[face] @ (self.g_sensitivity_dps_per_g + power_on.g_sensitivity_dps_per_g).T
        accel = (force * (1 + power_on.scale + np.column_stack([curve(temp_c) for curve in self.scale]))
                 + force @ (self.misalignment_rad + power_on.mounting_rad).T
                 + self.even_per_mps2 * (force**2 - fixture.gravity_mps2**2))
        bias = np.column_stack([self.bias_at(i, temp_c) for i in range(6)])
        return bias + power_on.offset + np.column_stack([gyro, accel])


class PowerOn:
    """What differs from one run to the next."""

    def __init__(self, rng):
        self.offset = rng.normal(0.0, POWER_ON)
        self.scale = rng.normal(0.0, SCALE_SCATTER, 3)
        self.mounting_rad = rng.normal(0.0, MOUNTING_SCATTER_RAD, (3, 3)) * (1 - np.eye(3))
        self.g_sensitivity_dps_per_g = rng.normal(0.0, G_SCATTER_DPS_PER_G, (3, 3))


def run_rows(rng, unit, fixture, label, rows, t_s):
    """CSV of one run, the chamber both ways: `rows` seconds in each position at each plateau."""
    out = io.StringIO()
    power_on = PowerOn(rng)
    for sweep, plateaus in (("up", PLATEAUS_C), ("down", PLATEAUS_C[-2::-1])):
        for plateau_c in plateaus:
            t_s += 1800
            time = t_s + np.concatenate([np.arange(rows) + k * (rows + 12) for k in range(6)])
            behind_k = (-0.4 if sweep == "up" else 0.4) * np.exp(-(time - t_s) / 300.0)
            temp_c = plateau_c + rng.normal(0.0, 0.05) + behind_k
            face = np.repeat(rng.permutation(6), rows)
            values = unit.respond(fixture, face, temp_c, power_on) + rng.normal(0.0, WHITE, (len(time), 6))
            seen_c = temp_c + rng.normal(0.0, 0.01, len(time))
            for i, at in enumerate(time):
                readings = ",".join(f"{value:.6f}" for value in values[i])
                out.write(f"{at},{label},soak,{sweep},{plateau_c:g},{FACES[face[i]]},{seen_c[i]:.4f},{readings}\n")
                if i + 1 < len(time) and time[i + 1] > at + 1:  # it moves
                    out.write(f"{at + 1},{label},soak,{sweep},{plateau_c:g},,{seen_c[i]:.4f},{readings}\n")
            t_s = int(time[-1])
    return out.getvalue()


def campaign(seed, runs, units, rows):
    """Truth (gravity as stated, one entry per unit) and the CSV text of each unit, by serial number."""
    rng = np.random.default_rng(seed)
    stated = 9.8082
    fixture = Fixture(rng, stated)
    truth = {"gravity_mps2": stated, "temp_c": list(PLATEAUS_C[0] + np.arange(321) * 0.25), "units": []}
    texts = {}
    for number in range(1, units + 1):
        unit, serial = Unit(rng), f"SIX-{number:04d}"
        header = "t_s,run,phase,sweep,plateau_c,position,temp_c,gx_dps,gy_dps,gz_dps,ax_mps2,ay_mps2,az_mps2\n"
        texts[serial] = header + "".join(run_rows(rng, unit, fixture, f"R{k + 1:02d}", rows, 0) for k in range(runs))
        sensors = {}
        for i, name in enumerate(SENSORS):
            accel = i >= 3
            sensors[name] = {
                "bias": list(unit.bias_at(i, truth["temp_c"])),
                "verification_power_on_offset": rng.normal(0.0, POWER_ON[i]),
                "scale_ppm": list(1e6 * unit.scale[i - 3](truth["temp_c"])) if accel else None,
                "misalignment_rad": list(unit.misalignment_rad[i - 3]) if accel else None,
                "g_sensitivity_dps_per_g": None if accel else list(unit.g_sensitivity_dps_per_g[i]),
            }
        truth["units"].append({"unit": serial, "sensors": sensors})
    return truth, texts
