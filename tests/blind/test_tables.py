# SPDX-License-Identifier: Apache-2.0
"""The tables, from records whose counts are known."""
import contextlib
import io
import unittest

import tables


def record(table, effects, names, *, design="identical", magnitude=0.3, ratio=50.0, oracle=None, quick=None, verdict=None, seed=1):
    return {"cell": f"{table}/{design}", "table": table, "design": design, "effects": effects, "magnitude": magnitude, "seed": seed,
            "verdict": verdict or ("named" if names else "none"), "names": names, "suspects": [], "residual_structure": None, "closed": {},
            "oracle": [{"names": [name], "ratio": ratio} for name in (oracle or effects or ["sensor_lag"])[:1]]
            + [{"names": oracle or effects, "ratio": 2.0 * ratio}], "naive": {"name": quick, "log_p": -1.0}, "cpu_s": {"find": 0.5}}


def printed(records):
    with contextlib.redirect_stdout(io.StringIO()) as text:
        tables.print_tables(records)
    return " ".join(text.getvalue().split())


class Tables(unittest.TestCase):
    def test_oracle_may_be_wrong_on_as_many_nulls_as_ours(self):
        nulls = [record("null", [], [], ratio=ratio) for ratio in (3.0, 9.0, 7.0, 8.0)]
        self.assertEqual(tables.thresholds(nulls), {"identical": 9.0})
        nulls.append(record("null", [], ["sensor_lag"], ratio=1.0))
        self.assertEqual(tables.thresholds(nulls), {"identical": 8.0})

    def test_oracle_stands_aside_where_a_design_has_no_nulls(self):
        self.assertIn("1/1 = 100.0 % (2.5..100.0) - - 1/1", printed([record("named", ["sensor_lag"], ["sensor_lag"])]))

    def test_first_name_counts_and_a_second_one_is_told(self):
        found = [record("null", [], [], ratio=9.0)]
        found += [record("named", ["sensor_lag"], names, seed=seed) for seed, names in
                  enumerate((["sensor_lag"], ["sensor_lag", "cross_axis"], ["temperature_rate"], []))]
        text = printed(found)
        # Two of four; the oracle all four; two of the three that ours names; one second name; quick statistics named nothing.
        self.assertIn("identical 0.3 2/4 = 50.0 % (6.8..93.2) 4/4 0.50 2/3 = 66.7 % (9.4..99.2) 1 0/0", text)
        self.assertIn("sensor_lag 0.3 2/4 4/4 0.50 1 temperature_rate, 1 none", text)

    def test_pairs_count_as_sets(self):
        pair = ["sensor_lag", "cross_axis"]
        found = [record("null", [], [], ratio=9.0)]
        found += [record("pair", pair, names, seed=seed) for seed, names in
                  enumerate((pair, pair[::-1], pair[:1], ["sensor_lag", "earth_rate"], []))]
        self.assertIn("identical 0.3 2/5 = 40.0 % (5.3..85.3) 5/5 0.40 1 1 1 0", printed(found))

    def test_unknown_effects_and_single_runs_count_by_verdict(self):
        found = [record("unknown", ["moisture"], [], verdict="unknown", magnitude=1.2),
                 record("unknown", ["moisture"], ["sensor_lag"], magnitude=1.2, seed=2),
                 record("unknown", ["moisture"], ["moisture"], magnitude=1.2, seed=3),
                 record("unknown", ["moisture"], ["moisture", "sensor_lag"], magnitude=1.2, seed=4),
                 record("one", [], [], design="one", verdict="cannot_judge")]
        text = printed(found)
        self.assertIn("moisture 1.2 2/4 = 50.0 % (6.8..93.2) 1 1 0 1 sensor_lag, 1 moisture+sensor_lag", text)
        self.assertIn("One run: cannot_judge 1/1", text)

    def test_an_effect_without_its_log_counts_by_the_names_that_it_is_given(self):
        hidden = ["supply_sensitivity"]
        found = [record("unlogged", hidden, [], verdict="none", design="missing_logs"),
                 record("unlogged", hidden, ["cross_axis"], design="missing_logs", seed=2)]
        self.assertIn("supply_sensitivity 0.3 1/2 = 50.0 % (1.3..98.7) 0 1", printed(found))

    def test_failed_campaigns_are_told_and_not_counted(self):
        failed = {"cell": "null/mixed", "table": "null", "design": "mixed", "effects": [], "magnitude": 0.0, "seed": 7,
                  "error": "soak fit: status 2\nno rows", "cpu_s": {}}
        text = printed([record("null", [], []), failed])
        self.assertIn("1 campaigns, seeds 1 to 7; 1 more failed null/mixed seed 7: no rows", text)


if __name__ == "__main__":
    unittest.main()
