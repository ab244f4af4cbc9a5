# SPDX-License-Identifier: Apache-2.0
"""What the second laboratory promises: sizes, noise, hysteresis, repeatability, and a file that the format allows."""
from __future__ import annotations

import contextlib
import importlib.machinery
import importlib.util
import io
import json
import os
import sys
import unittest
from pathlib import Path

import numpy as np

sys.path[:0] = [str(Path(__file__).resolve().parent), str(Path(__file__).resolve().parents[1])]
import second_laboratory as lab  # noqa: E402
from blind_campaign import Programs, report_of, temporary_folder  # noqa: E402
from closed_gap import accepted_and_closed  # noqa: E402
from long_tests import long_test  # noqa: E402

SMALL = lab.Design(spacing_k=20, dwell_min=12)
ALLOWED = {"t_s", "run", "phase", "sweep", "plateau_c", "position", "chamber_c", "temp_c", "gx_dps", "gy_dps", "gz_dps",
           "ax_mps2", "ay_mps2", "az_mps2", "t_since_power_s", "utc_s"}


def cells_of(campaign: lab.Campaign) -> dict[str, np.ndarray]:
    header, *rows = campaign.csv.splitlines()
    return dict(zip(header.split(","), np.array([row.split(",") for row in rows]).T))


def dummies(labels: np.ndarray) -> np.ndarray:
    return (labels[:, None] == np.unique(labels)).astype(float)


def size_from_labels(campaign: lab.Campaign) -> float:
    """The size by the labels in the file, least squares and one block after the other."""
    cells = cells_of(campaign)
    stands = np.flatnonzero((cells["phase"] == "soak") & (cells["position"] != ""))
    starts = stands[::12]
    blocks = np.array([campaign.effect[start:start + 12].mean(axis=0) for start in starts])
    plateau, run, position = (cells[name][starts] for name in ("plateau_c", "run", "position"))
    squares = []
    for name in campaign.truth["sensors"]:
        column = blocks[:, lab.SENSORS.index(name)]
        terms = [dummies(plateau), dummies(run)]
        if name[0] == "a":
            facing = {axis: np.array([(p[1] == axis) * (1.0 if p[0] == "+" else -1.0) for p in position]) for axis in "XYZ"}
            own = facing.pop(name[1].upper())
            terms += [dummies(plateau) * own[:, None], *(other[:, None] for other in facing.values())]
        matrix = np.hstack(terms)
        squares.append(np.mean((column - matrix @ np.linalg.lstsq(matrix, column, rcond=None)[0]) ** 2))
    return float(np.sqrt(np.mean(squares)))


def prove():
    """tools/prove/second-laboratory as a module."""
    path = str(Path(__file__).resolve().parents[2] / "tools" / "prove" / "second-laboratory")
    loader = importlib.machinery.SourceFileLoader("prove_second_laboratory", path)
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader(loader.name, loader))
    loader.exec_module(module)
    return module


class Table(unittest.TestCase):
    """What tools/prove/second-laboratory makes of verdicts."""

    @staticmethod
    def verdict(effect, size, verdict, names=""):
        return {"plan": "10 K", "slow": "white 0.0", "effect": effect, "size": size, "seed": 1, "verdict": verdict, "names": names, "set": names,
                "odds": "", "oracle": "", "suspects": "", "cpu_s": 1.0, "reason": ""}

    def printed(self, records):
        with contextlib.redirect_stdout(io.StringIO()) as out:
            failed = prove().print_table(records)
        return failed, out.getvalue()

    def test_a_group_without_a_campaign_fails(self):
        good = [self.verdict("none", None, "none"), self.verdict("creep", 1.2, "unknown"), self.verdict("sensor_lag", 1.2, "named", "sensor_lag")]
        self.assertFalse(self.printed(good)[0])
        for k in range(3):
            failed, text = self.printed(good[:k] + good[k + 1:])
            self.assertTrue(failed)
            self.assertIn("no campaign was judged", text)

    def test_the_rotation_of_the_earth_as_it_is_counts_apart(self):
        earth = [self.verdict("earth_rate", None, "none") for _ in range(9)]
        good = [self.verdict("none", None, "none"), self.verdict("creep", 1.2, "unknown"), self.verdict("sensor_lag", 1.2, "named", "sensor_lag")]
        failed, text = self.printed(good + earth)
        self.assertFalse(failed)
        self.assertIn("first name right, 0.6 up:   1/1", text)
        self.assertRegex(text, r"earth_rate as it is: +0/9")

    def test_what_was_not_made_is_counted_cell_by_cell(self):
        cell = [self.verdict("moisture", 2.4, "not made"), self.verdict("moisture", 2.4, "not made"), self.verdict("moisture", 2.4, "unknown")]
        self.assertRegex(self.printed(cell)[1], r"not made.*moisture 2.4 10 K, white 0.0: 2 of 3")


class Size(unittest.TestCase):
    def test_is_what_was_asked(self):
        for effect in ("temperature_rate", "creep", "cross_axis", "fixture_tilt", "sensor_lag"):
            with self.subTest(effect):
                campaign = lab.make(3, SMALL, effect, 0.6)
                self.assertAlmostEqual(campaign.truth["size_reached"], 0.6, places=3)
                self.assertAlmostEqual(size_from_labels(campaign), 0.6, places=3)

    @long_test
    def test_every_effect_is_reached_and_its_truth_is_json(self):
        log, unit = lab.campaign_log(5, SMALL), lab.make_unit(5)
        for effect in lab.EFFECTS[1:]:
            with self.subTest(effect):
                hidden, found = lab.hide(5, log, unit, effect, 0.3)
                self.assertTrue(np.isfinite(hidden).all())
                self.assertAlmostEqual(found["size_reached"], 0.3, places=3)
                json.dumps(found)

    def test_a_size_out_of_reach_is_refused(self):
        with self.assertRaises(lab.OutOfReach):
            lab.make(5, SMALL, "sensor_lag", 100)
        for unheard_of in (("no_such_effect", 1.2), ("creep", 0.0)):
            with self.assertRaises(ValueError) as refused:
                lab.make(5, SMALL, *unheard_of)
            self.assertNotIsInstance(refused.exception, lab.OutOfReach)

    def test_the_effect_is_all_that_differs(self):
        plain, hidden = lab.make(4, SMALL), lab.make(4, SMALL, "creep", 0.6)
        np.testing.assert_allclose(hidden.readings - plain.readings, hidden.effect * lab.BLOCK_SIGMA, atol=1e-12)

    def test_earth_turns_as_it_does(self):
        campaign = lab.make(6, SMALL, "earth_rate")
        rate_dps = (campaign.effect * lab.BLOCK_SIGMA)[:, :3]
        np.testing.assert_allclose(np.linalg.norm(rate_dps, axis=1), 15.041067 / 3600, rtol=1e-6)
        found = campaign.truth["parameters"]
        for number, position in enumerate(lab.POSITIONS):
            axis = "XYZ".index(position[1])
            sign = 1 if position[0] == "+" else -1
            row = rate_dps[(campaign.log.position == number) & (campaign.log.kind == lab.STAY)][0]
            upward_dps = 15.041067 / 3600 * np.sin(np.radians(found["latitude_deg"]))
            heading = np.radians(found["heading_deg"] + lab.AZIMUTHS_DEG[position])
            north_dps = 15.041067 / 3600 * np.cos(np.radians(found["latitude_deg"]))
            self.assertAlmostEqual(row[axis], sign * upward_dps)
            self.assertAlmostEqual(row[(axis + 1) % 3], north_dps * np.cos(heading))


class SlowNoise(unittest.TestCase):
    def draws(self, kind: str, samples: int, count: int) -> np.ndarray:
        rng = lab.stream(1, "test " + kind)
        return np.stack([lab.slow_noise(rng, samples, kind, 0.75) for _ in range(count)], axis=1).reshape(samples, -1)

    def test_gauss_markov(self):
        drawn = self.draws("gauss_markov", 73, 1500)
        self.assertAlmostEqual(drawn[0].std(), 0.75, delta=0.03)
        self.assertAlmostEqual(drawn[-1].std(), 0.75, delta=0.03)
        expected = np.mean(np.exp(-360 / np.array([360.0, 3600.0, 36000.0])))
        self.assertAlmostEqual(np.corrcoef(drawn[0], drawn[-1])[0, 1], expected, delta=0.03)

    def test_flicker(self):
        drawn = self.draws("flicker", 2, 600)
        self.assertAlmostEqual(drawn[-1].std(), 0.75, delta=0.04)
        frequency_hz = np.geomspace(1 / 36000, 1 / 600, 20)
        corner_hz = 1 / (2 * np.pi * np.array(lab.SLOW_TAUS_S["flicker"]))
        density = np.sum(corner_hz / (corner_hz**2 + frequency_hz[:, None] ** 2), axis=1)
        self.assertAlmostEqual(np.polyfit(np.log(frequency_hz), np.log(density), 1)[0], -1, delta=0.1)

    def test_random_walk(self):
        drawn = self.draws("random_walk", 721, 250)
        self.assertAlmostEqual((drawn[720] - drawn[0]).std(), 0.75, delta=0.05)


class Hysteresis(unittest.TestCase):
    half_width_k = np.array([2.0, 7.0, 20.0])

    def test_loop_closes(self):
        warming, cooling = np.linspace(-30, 70, 401), np.linspace(70, -30, 401)
        twice = lab.play(np.concatenate([warming, cooling, warming, cooling]), self.half_width_k)
        np.testing.assert_allclose(twice[801], twice[-1])
        np.testing.assert_allclose(twice[402:802], twice[-400:])
        self.assertGreater(abs(twice[200] - twice[601])[1], 10)

    def test_rate_does_not_matter(self):
        way = np.array([20, -30, 45, 10, 70, 0.0])
        slow = lab.play(np.interp(np.arange(0, 5001) / 1000, np.arange(6), way), self.half_width_k)
        fast = lab.play(np.interp(np.arange(0, 51) / 10, np.arange(6), way), self.half_width_k)
        np.testing.assert_allclose(slow[::100], fast, atol=1e-12)

    def test_same_as_sample_by_sample(self):
        temp_c = np.cumsum(lab.stream(2, "test play").standard_normal(500))
        state, expected = np.full(3, temp_c[0]), []
        for now_c in temp_c:
            state = np.clip(state, now_c - self.half_width_k, now_c + self.half_width_k)
            expected.append(state)
        np.testing.assert_allclose(lab.play(temp_c, self.half_width_k), expected)


class NothingHidden(unittest.TestCase):
    def test_runs_repeat_but_for_offsets_and_noise(self):
        campaign = lab.make(8, SMALL)
        self.assertEqual(campaign.truth["effect"], "none")
        self.assertFalse(campaign.effect.any())
        log, first = campaign.log, campaign.log.in_blocks[::12]
        blocks, temp_c = lab.block_means(log, campaign.readings), lab.block_means(log, log.unit_c)
        squares = []
        for position in range(6):
            here = log.position[first] == position
            plateau = dummies(log.plateau_c[first][here])
            offset_k = (temp_c[here] - log.plateau_c[first][here])[:, None]
            matrix = np.hstack([plateau, plateau * offset_k, plateau * offset_k**2, dummies(log.run[first][here])[:, 1:]])
            left = blocks[here] - matrix @ np.linalg.lstsq(matrix, blocks[here], rcond=None)[0]
            squares.append(np.sum(left**2, axis=0) / (here.sum() - matrix.shape[1]) / lab.BLOCK_SIGMA**2)
        np.testing.assert_allclose(np.mean(squares, axis=0), 1.0, atol=0.12)

    def test_visits_settle_from_both_sides(self):
        log = lab.make(8, SMALL).log
        rising = log.unit_kpmin[(log.kind == lab.STAY) & (log.sweep > 0)]
        falling = log.unit_kpmin[(log.kind == lab.STAY) & (log.sweep < 0)]
        self.assertGreater(rising.mean(), 0)
        self.assertLess(falling.mean(), 0)


class File(unittest.TestCase):
    def test_is_what_the_format_allows(self):
        campaign = lab.make(9, lab.Design(spacing_k=20, dwell_min=12, positions="permuted", ramps="two", down="half"))
        cells = cells_of(campaign)
        self.assertLessEqual(set(cells), ALLOWED)
        self.assertEqual(set(cells["phase"]), {"ramp", "soak"})
        self.assertEqual(set(cells["sweep"]), {"up", "down"})
        self.assertEqual(set(cells["position"]), {"", *lab.POSITIONS})
        self.assertEqual(set(cells["plateau_c"]), {"-30", "-10", "10", "30", "50", "70"})
        changes = np.count_nonzero(cells["run"][1:] != cells["run"][:-1])
        self.assertEqual(changes, 5)
        for run in set(cells["run"]):
            spacing_s = np.diff(cells["t_s"][cells["run"] == run].astype(float))
            self.assertTrue((spacing_s == 5).all())
        stands = (cells["phase"] == "soak") & (cells["position"] != "")
        self.assertEqual(stands.sum(), 6 * len(lab.visits_c(campaign.design)) * 6 * 36)

    def test_same_seed_same_file(self):
        self.assertEqual(lab.make(10, SMALL, "step", 0.6).csv, lab.make(10, SMALL, "step", 0.6).csv)


@unittest.skipUnless("SOAK_BIN" in os.environ, "skipped: SOAK_BIN does not name a program")
class Judged(unittest.TestCase):
    """A sample of `./run prove second-laboratory`."""
    def report(self, seed, effect="none", size=None, **design):
        with temporary_folder() as folder:
            recording = Path(folder) / "unit.csv"
            recording.write_text(lab.make(seed, lab.Design(**design), effect, size).csv, encoding="utf-8")
            root = Path(__file__).resolve().parents[2]
            return report_of(Programs(Path(os.environ["SOAK_BIN"]).parent, root / "hal" / "sim" / "lab.toml"), folder, recording, rules=2)

    def test_a_bias_that_wanders_is_noise(self):
        report = self.report(501, slow=1.25)
        self.assertEqual(report["verdict"], "none", report["reason"])
        self.assertIn("wandering_bias", [note["code"] for note in report["notes"]])

    def test_an_effect_is_named_beside_it(self):
        report = self.report(502, "g_sensitivity", 1.2, slow=1.25)
        self.assertEqual([effect["name"] for effect in report["effects"]], ["g_sensitivity"], report["reason"])

    @long_test
    def test_a_thermal_effect_is_named_at_plateaus_25_k_apart(self):
        for effect in ("thermal_hysteresis", "temperature_rate"):
            report = self.report(504, effect, 1.2, spacing_k=25.0, dwell_min=30.0)
            self.assertEqual([found["name"] for found in report["effects"]], [effect], report["reason"])

    @long_test
    def test_jumps_are_no_noise_of_that_kind(self):
        report = self.report(503, "telegraph", 2.4)
        self.assertEqual(report["verdict"], "unknown", report["reason"])

    @long_test
    def test_of_two_twins_the_likelier_is_named_first(self):
        report = self.report(30001, "gradient", 0.6)
        effect = report["effects"][0]
        self.assertEqual((effect["name"], list(effect["odds"])), ("temperature_gradient", ["temperature_rate"]), report["reason"])
        self.assertLess(effect["odds"]["temperature_rate"], 1.0)

    @long_test
    def test_what_cannot_be_told_apart_has_odds(self):
        effect = self.report(502, "g_sensitivity", 1.2)["effects"][0]
        self.assertEqual(sorted(effect["odds"]), sorted(effect["confusable_with"]))
        self.assertEqual(list(effect["odds"]), ["position_memory"])
        self.assertGreater(effect["odds"]["position_memory"], 0.0)

    def test_an_accepted_effect_closes_the_gap_on_fresh_runs(self):
        """A sample of `./run prove closed-gaps`."""
        names, closed = accepted_and_closed(Path(os.environ["SOAK_BIN"]).parent, 505, "temperature_rate", 1.2)
        self.assertEqual(names, ["temperature_rate"])
        self.assertGreater(min(closed.values()), 0.7)


if __name__ == "__main__":
    unittest.main()
