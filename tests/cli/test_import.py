# SPDX-License-Identifier: Apache-2.0
"""soak import: what a good recording becomes."""
import unittest

from soak_cli import SoakTest, recording, shared_data, ROOT


class Import(SoakTest):
    def test_stores_a_run_with_its_segments(self):
        run = self.imported("rec.csv", recording(), "--latitude-deg", "-33.9", "--height-m", "20")
        self.assertEqual((run["status"], run["rows"], run["segments"]), ("imported", 2160, 12))
        self.assertAlmostEqual(run["duration_s"], 1079.5)
        shown = self.soak_json("runs-show", "runs", "show", run["run_id"])
        self.assertEqual(shown["run"]["site"], {"latitude_deg": -33.9, "height_m": 20, "azimuth_deg": None, "gravity_mps2": None})
        first = shown["segments"][0]
        self.assertEqual((first["visit"], first["position"], first["plateau_c"], first["sweep"]), (0, "+X", 0, "up"))
        # 180 samples with noise 0.01 deg/s: the mean is known to 0.00075 deg/s.
        self.assertAlmostEqual(first["sensors"]["gyro_x"]["mean"], 0.1, delta=0.004)
        self.assertAlmostEqual(first["sensors"]["gyro_x"]["se"], 0.01 / 180 ** 0.5, delta=0.0004)
        self.assertAlmostEqual(first["sensors"]["accel_x"]["mean"], 9.80665, delta=0.002)
        self.assertAlmostEqual(shown["segments"][6]["sensors"]["gyro_x"]["mean"], 0.5, delta=0.004)

    def test_each_run_of_a_file_becomes_a_run_file(self):
        two = recording(run="first") + recording(seed=2, run="second").split("\n", 1)[1]
        path = self.write("two.csv", two)
        document = self.soak_json("import", "import", path, "--unit", "SN1")
        self.assertEqual([r["run"] for r in document["runs"]], ["first", "second"])
        self.assertEqual({p.name for p in (self.data / "runs").iterdir()}, {r["run_id"] + ".soakrun" for r in document["runs"]})

    def test_label_is_the_file_stem_where_there_is_no_run_column(self):
        self.assertEqual(self.imported("a b.csv", "t_s,temp_c,gx_dps\n0,25,1\n1,25,2\n")["run"], "a b")

    def test_identical_import_again_does_nothing_and_says_so(self):
        self.imported("rec.csv", recording())
        before = self.state()
        self.assertEqual(self.imported("again.csv", recording())["status"], "unchanged")
        self.assertEqual(self.state(), before)
        self.assertIn("unchanged", self.soak("import", self.folder / "rec.csv", "--unit", "SN1").stdout)

    def test_line_ends_byte_order_mark_and_column_order_do_not_matter_to_the_samples(self):
        plain = self.imported("plain.csv", "t_s,temp_c,gx_dps\n0,25,1.5\n1,26,2.5\n")
        dressed = self.imported("dressed.csv", b"\xef\xbb\xbft_s, temp_c,gx_dps\r\n0,25, 1.5\r\n1,\"26\",2.5\r\n")
        self.assertEqual(plain["content_sha256"], dressed["content_sha256"])
        rows = self.soak("runs", "export", self.imported("turned.csv", "gx_dps,temp_c,t_s\n1.5,25,0\n2.5,26,1\n")["run_id"]).stdout
        self.assertEqual(rows, "t_s,run,temp_c,gx_dps\n0,turned,25,1.5\n1,turned,26,2.5\n")

    def test_units_of_suffixes_become_canonical_ones(self):
        run = self.imported("units.csv", "t_ms,temp_k,gx_rps,gy_degph,ax_g,ay_mg,temp_gx_f\n"
                                         "0,273.15,3.141592653589793,3600,1,1000,212\n"
                                         "1500,300,0,0,0,0,-40\n")
        header, first, second = self.soak("runs", "export", run["run_id"]).stdout.splitlines()
        self.assertEqual(header, "t_s,run,temp_c,gx_dps,gy_dps,ax_mps2,ay_mps2,temp_gx_c")
        self.assertEqual(first, "0,units,0,180,1,9.80665,9.80665,100")
        self.assertEqual(second.split(",")[0], "1.5")
        self.assertAlmostEqual(float(second.split(",")[2]), 26.85, places=12)
        self.assertAlmostEqual(float(second.split(",")[-1]), -40, places=12)

    def test_unknown_columns_are_kept(self):
        run = self.imported("aux.csv", "t_s,temp_c,gx_dps,pressure_hpa,mode\n0,25,1,1013.2,idle\n1,25,1,,\"a, b\"\n")
        channels = {c["name"]: c for c in self.soak_json("runs-show", "runs", "show", run["run_id"])["channels"]}
        self.assertEqual(channels["pressure_hpa"]["type"], "f64")
        self.assertEqual(channels["mode"]["labels"], ["idle", "a, b"])
        self.assertEqual(self.soak("runs", "export", run["run_id"]).stdout.splitlines()[2], "1,aux,25,1,,\"a, b\"")

    def test_skip_bad_leaves_rows_out_and_lists_them(self):
        rows = "".join(f"{t},25,{'nan' if t % 2 else 1}\n" for t in range(60)) + "60,25\n"
        path = self.write("bad.csv", "t_s,temp_c,gx_dps\n" + rows)
        done = self.soak("import", path, "--unit", "SN1", "--skip-bad")
        self.assertIn("31", done.stderr)
        self.assertIn("line 3, column 'gx_dps'", done.stderr)
        self.assertIn("11", done.stderr)
        document = self.soak_json("import", "import", path, "--unit", "SN1", "--campaign", "other", "--skip-bad")
        self.assertEqual(document["runs"][0]["rows"], 30)
        self.assertEqual([r["line"] for r in document["bad_rows"]], [*range(3, 62, 2), 62])
        self.assertIsNone(document["bad_rows"][-1]["column"])

    def test_a_last_line_without_end_is_read_with_a_warning(self):
        path = self.write("cut.csv", "t_s,temp_c,gx_dps\n0,25,1\n1,25,2")
        document = self.soak_json("import", "import", path, "--unit", "SN1")
        self.assertEqual(document["runs"][0]["rows"], 2)
        self.assertTrue(any("line 3" in w and "truncated" in w for w in document["warnings"]), document["warnings"])

    def test_the_same_samples_under_another_label_are_pointed_out(self):
        self.imported("rec.csv", recording())
        path = self.write("copy.csv", recording(run="r2"))
        warnings = self.soak_json("import", "import", path, "--unit", "SN1")["warnings"]
        self.assertTrue(any("same samples as run 'r1'" in w for w in warnings), warnings)


class ThermalChamberCycle(SoakTest):
    def test_imports_by_its_committed_columns_map(self):
        folder = shared_data("thermal_chamber_cycle")
        if folder is None:
            self.skipTest("recording thermal_chamber_cycle is absent (SOAK_TEST_DATA)")
        columns = ROOT / "procedures" / "columns" / "thermal-chamber-cycle.toml"
        run = self.soak_json("import", "import", folder / "imu_raw_data.csv", "--unit", "MPU", "--columns", columns)["runs"][0]
        self.assertEqual(run["rows"], 8399)
        # PROVENANCE.md: 4244.9 s from the first row, which is dropped, at about 0.505 s a row.
        self.assertAlmostEqual(run["duration_s"], 4244.4, delta=0.1)
        channels = {c["name"]: c for c in self.soak_json("runs-show", "runs", "show", run["run_id"])["channels"]}
        self.assertEqual((channels["t_s"]["type"], channels["status"]["type"]), ("i64", "i8"))
        source = [line.split("\t") for line in (folder / "imu_raw_data.csv").read_text().splitlines()[2:]]
        native = self.folder / "native.csv"
        self.soak("runs", "export", run["run_id"], "--native", "-o", native)
        rows = [line.split(",") for line in native.read_text().splitlines()[1:]]
        self.assertEqual([r[0] for r in rows], [r[0] for r in source])
        self.assertEqual([float(r[2]) for r in rows], [float(r[1]) for r in source])
        # Canonical export: rad/s become deg/s, time starts at 0.
        first = self.soak("runs", "export", run["run_id"]).stdout.splitlines()[1].split(",")
        self.assertEqual(float(first[0]), 0)
        self.assertAlmostEqual(float(first[3]), float(source[0][1]) * 57.29577951308232, places=9)


if __name__ == "__main__":
    unittest.main()
