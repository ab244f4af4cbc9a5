#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Values of the golden calibrations, by the formulas of docs/blob-format.md from their parameters (README.md)."""
import json
import math
import os

SENSORS = ["gyro_x", "gyro_y", "gyro_z", "accel_x", "accel_y", "accel_z"]
HERE = os.path.dirname(os.path.abspath(__file__))


def fis(i, bell, centre, half_range, slopes=(1.5, 0.25)):
    """Six rules over u = (T - 20) / 50; the parameters are those of calibration_file_samples.h."""
    def value(t):
        u = (t - 20.0) / 50.0
        top = bottom = 0.0
        for k in range(6):
            width, slope, c = 0.15 + 0.02 * k, slopes[0] + slopes[1] * k, -1.0 + 0.4 * k
            z = abs(u - c) / width
            mu = 1.0 / (1.0 + z ** (2.0 * slope)) if bell else math.exp(-z * z / 2.0)
            top += mu * (0.3 * (k - i) * u + 0.8 - 0.1 * k * k + 0.05 * i)
            bottom += mu
        return centre + half_range * top / bottom
    return value


def spline(amplitude):
    knots = [-30.0, -5.0, 20.0, 45.0]
    pieces = [(1.0, 0.01, -0.002, 0.00004), (0.625, -0.015, 0.001, -0.00002),
              (0.5625, -0.0025, -0.0005, 0.00001), (0.34375, -0.00875, 0.00025, 0.0)]

    def value(t):
        j = max(k for k in range(4) if k == 0 or knots[k] <= t)
        d = t - knots[j]
        return amplitude * sum(c * d ** p for p, c in enumerate(pieces[j]))
    return value


def table(amplitude):
    points = [amplitude * (1.0 + 0.02 * k - 0.001 * k * k) for k in range(41)]

    def value(t):
        j = min(int((t + 30.0) / 2.5), 39)
        return points[j] + (points[j + 1] - points[j]) * ((t + 30.0) / 2.5 - j)
    return value


def whole_degrees(curve):
    """Linear between the whole degrees."""
    def value(t):
        j = min(math.floor(t), 69)
        return curve(j) + (curve(j + 1) - curve(j)) * (t - j)
    return value


def fis_calibration(slopes=(1.5, 0.25), form=lambda curve: curve, own=()):
    """own: sensors over thermometers of their own."""
    curves = {}
    for i, name in enumerate(SENSORS):
        if i < 3:
            curves[name] = (form(fis(i, True, 0.01, 0.004, slopes)), None)
        else:
            curves[name] = (form(fis(i, False, -0.2, 0.1)), form(fis(i, False, 1500.0, 400.0)))
    return curves, (-30.0, 70.0), None, None, own, None


GYRO_MISALIGNMENT = [[0.0, 0.004, -0.003], [0.002, 0.0, 0.005], [-0.001, 0.0035, 0.0]]


def mixed_calibration(gyro_misalignment=None):
    curves = {}
    for i, name in enumerate(SENSORS):
        if name == "gyro_y":
            continue
        curves[name] = (spline(0.01 * (1 + i)), None) if i < 3 else (table(0.1 * (i - 2)), spline(1000.0 * (i - 2)))
    misalignment = [[0.0, 0.002, -0.001], [0.003, 0.0, 0.0015], [-0.0025, 0.001, 0.0]]
    g_sensitivity = [[1e-4, 2e-5, 0.0], [0.0, 1e-4, 3e-5], [-2e-5, 0.0, 1.5e-4]]
    return curves, (-25.0, 65.0), misalignment, g_sensitivity, (), gyro_misalignment


def solve3(k, y):
    """Gaussian elimination with pivoting."""
    rows = [row[:] + [value] for row, value in zip(k, y)]
    for c in range(3):
        best = max(range(c, 3), key=lambda r: abs(rows[r][c]))
        rows[c], rows[best] = rows[best], rows[c]
        for r in range(3):
            if r != c:
                factor = rows[r][c] / rows[c][c]
                rows[r] = [a - factor * b for a, b in zip(rows[r], rows[c])]
    return [rows[r][3] / rows[r][r] for r in range(3)]


def corrected(calibration, temps_c, raw):
    """temps_c: of each sensor's thermometer, None where it is not known (in files without couplings only)."""
    curves, (low, high), misalignment, g_sensitivity, _, gyro_misalignment = calibration
    t = [None if temp_c is None else min(max(temp_c, low), high) for temp_c in temps_c]
    k, y = [], []
    for i in range(3):
        bias, scale = curves[SENSORS[3 + i]]
        row = list(misalignment[i]) if misalignment else [0.0, 0.0, 0.0]
        row[i] = 1.0 if t[3 + i] is None else 1.0 + 1e-6 * scale(t[3 + i])
        k.append(row)
        y.append(raw[3 + i] - (0.0 if t[3 + i] is None else bias(t[3 + i])))
    force = solve3(k, y)
    rates = []
    for i in range(3):
        rate = raw[i]
        if SENSORS[i] in curves and t[i] is not None:
            rate -= curves[SENSORS[i]][0](t[i])
            if g_sensitivity:
                rate -= sum(g * f for g, f in zip(g_sensitivity[i], force))
        rates.append(rate)
    if gyro_misalignment:
        # the gyros have no scale curve; one that is not in the file is as it reads
        rows = [[1.0 if i == j else gyro_misalignment[i][j] if SENSORS[i] in curves else 0.0 for j in range(3)]
                for i in range(3)]
        rates = solve3(rows, rates)
    return rates + force


def document(calibration):
    curves, (low, high) = calibration[0], calibration[1]
    # multiples of 1/8: exact in float32
    temps = [low - 20.0, low] + [low + 1.125 + 3.375 * n for n in range(26)] + [high, high + 5.5]
    sensors = {}
    for name, (bias, scale) in curves.items():
        sensors[name] = []
        for temp_c in temps:
            t = min(max(temp_c, low), high)
            sensors[name].append({"temp_c": temp_c, "in_range": t == temp_c, "bias": bias(t),
                                  "scale_ppm": scale(t) if scale else None})
    raw = [0.5, -0.25, 0.125, 1.5, -2.25, 9.75]
    own = calibration[4]
    # with the temperature of the unit's thermometer alone
    samples = [{"temp_c": t, "raw": raw, "out": corrected(calibration, [None if s in own else t for s in SENSORS], raw)}
               for t in temps]
    result = {"sensors": sensors, "corrected": samples}
    if own:
        each = [[t + 4.5 if s in own else t for s in SENSORS] for t in temps if low <= t <= high - 4.5]
        result["corrected_temps"] = [{"temps_c": t, "raw": raw, "out": corrected(calibration, t, raw)} for t in each]
    return result


def main():
    for name, calibration in (("fis", fis_calibration()), ("mixed", mixed_calibration()),
                              ("whole", fis_calibration(slopes=(1.0, 0.5))),
                              ("table", fis_calibration(form=whole_degrees)),
                              ("referenced", fis_calibration()), ("couplings", mixed_calibration()),
                              ("thermometers", fis_calibration(own=("gyro_x", "accel_z"))),
                              ("gyros", mixed_calibration(GYRO_MISALIGNMENT)),
                              ("one_way", fis_calibration()), ("history", fis_calibration()),
                              ("unreleased", fis_calibration())):
        with open(os.path.join(HERE, name + ".values.json"), "w", encoding="utf-8") as f:
            json.dump(document(calibration), f, indent=1)
            f.write("\n")


if __name__ == "__main__":
    main()
