#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Draws docs/images/demo.svg from the files that ./run demo left in build/demo: one gyro's thermal curve as it stands in the
calibration file, the simulator's noise-free truth, and the shape error between them."""
import json
import os
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
DEMO = os.path.join(ROOT, "build", "demo")
WIDTH, LEFT, RIGHT = 860, 76, 20
PANELS = ((46, 250), (350, 130))  # top, height


class Panel:
    """A plot area with linear axes."""

    def __init__(self, place, x_range, y_range):
        self.top, self.height = place
        self.x_range, self.y_range = x_range, y_range

    def x(self, value):
        low, high = self.x_range
        return LEFT + (value - low) / (high - low) * (WIDTH - LEFT - RIGHT)

    def y(self, value):
        low, high = self.y_range
        return self.top + (high - value) / (high - low) * self.height

    def line(self, points, style):
        path = " ".join(f"{self.x(a):.1f},{self.y(b):.1f}" for a, b in points)
        return f'<polyline points="{path}" fill="none" {style}/>'

    def area(self, upper, lower, style):
        path = " ".join(f"{self.x(a):.1f},{self.y(b):.1f}" for a, b in upper + lower[::-1])
        return f'<polygon points="{path}" {style}/>'

    def axes(self, ticks_y, label):
        parts = [f'<rect x="{LEFT}" y="{self.top}" width="{WIDTH - LEFT - RIGHT}" height="{self.height}" fill="none" stroke="#999"/>']
        for t in range(-30, 71, 10):
            parts.append(f'<line x1="{self.x(t):.1f}" x2="{self.x(t):.1f}" y1="{self.top}" y2="{self.top + self.height}" stroke="#eee"/>')
            parts.append(f'<text x="{self.x(t):.1f}" y="{self.top + self.height + 18}" text-anchor="middle">{t}</text>')
        for v in ticks_y:
            parts.append(f'<line x1="{LEFT}" x2="{WIDTH - RIGHT}" y1="{self.y(v):.1f}" y2="{self.y(v):.1f}" stroke="#eee"/>')
            parts.append(f'<text x="{LEFT - 8}" y="{self.y(v) + 4:.1f}" text-anchor="end">{v:g}</text>')
        parts.append(f'<text x="16" y="{self.top + self.height / 2}" text-anchor="middle" '
                     f'transform="rotate(-90 16 {self.top + self.height / 2})">{label}</text>')
        return parts


def read(serial, sensor):
    with open(os.path.join(DEMO, f"{serial}.json"), encoding="utf-8") as f:
        calibration = json.load(f)["sensors"][sensor]
    with open(os.path.join(DEMO, "truth.json"), encoding="utf-8") as f:
        truth = json.load(f)
    unit = next(u for u in truth["units"] if u["unit"] == serial)
    return calibration, list(zip(truth["temp_c"], unit["sensors"][sensor]["bias"]))


def interpolation(points):
    """Linear between rising points, clamped at their ends."""
    def value(t):
        t = min(max(t, points[0][0]), points[-1][0])
        i = max(1, next(k for k, p in enumerate(points) if p[0] >= t))
        (t0, v0), (t1, v1) = points[i - 1], points[i]
        return v0 + (v1 - v0) * (t - t0) / (t1 - t0)
    return value


def main(serial="0380A002", sensor="gyro_y"):
    calibration, truth = read(serial, sensor)
    curve = [(p["temp_c"], p["bias"]) for p in calibration["curve"]]
    band = [(p["temp_c"], p["ci95"]) for p in calibration["bias_uncertainty"]]
    at_truth = interpolation(truth)
    errors = [(t, v - at_truth(t)) for t, v in curve]
    mean = sum(e for _, e in errors) / len(errors)
    errors = [(t, e - mean) for t, e in errors]
    upper = Panel(PANELS[0], (-32, 72), (min(v for _, v in truth) - 0.08, max(v for _, v in truth) + 0.08))
    lower = Panel(PANELS[1], (-32, 72), (-0.0075, 0.0075))
    half = dict(band)
    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} 520" font-family="sans-serif" font-size="13">',
             f'<rect width="{WIDTH}" height="520" fill="white"/>',
             f'<text x="{LEFT}" y="26" font-size="16">{sensor} of unit {serial}, simulated: {calibration["model"]} curve of the calibration file</text>']
    low, high = upper.y_range
    parts += upper.axes([round(0.1 * k, 1) for k in range(-9, 10) if low < 0.1 * k < high], "bias, deg/s")
    parts.append(upper.area([(t, v + half[t]) for t, v in curve], [(t, v - half[t]) for t, v in curve],
                            'fill="#2b6cb0" fill-opacity="0.18"'))
    parts.append(upper.line(truth, 'stroke="#111" stroke-width="1.2" stroke-dasharray="5 4"'))
    parts.append(upper.line(curve, 'stroke="#2b6cb0" stroke-width="2"'))
    parts.append(f'<text x="{LEFT + 14}" y="{PANELS[0][0] + 20}">line: calibration file; band: 95 % for the mean over runs; dashed: truth</text>')
    parts += lower.axes([-0.005, 0, 0.005], "shape error, deg/s")
    parts.append(lower.line(errors, 'stroke="#c05621" stroke-width="1.6"'))
    parts.append(f'<text x="{LEFT + 14}" y="{PANELS[1][0] + 18}">curve minus truth, mean removed; ±0.005 is one hundredth of a drift of 0.5</text>')
    parts.append(f'<text x="{(LEFT + WIDTH) / 2}" y="514" text-anchor="middle">temperature of the unit, °C</text></svg>')
    os.makedirs(os.path.join(ROOT, "docs", "images"), exist_ok=True)
    with open(os.path.join(ROOT, "docs", "images", "demo.svg"), "w", encoding="utf-8") as f:
        f.write("\n".join(parts) + "\n")


if __name__ == "__main__":
    main(*sys.argv[1:])
