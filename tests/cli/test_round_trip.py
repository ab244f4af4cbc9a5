# SPDX-License-Identifier: Apache-2.0
"""soak runs export --native gives a file whose import is the same to the last bit."""
import random
import struct
import unittest

from soak_cli import SoakTest, recording


class RoundTrip(SoakTest):
    def round_trip(self, name, text, columns=None, needs_map=None):
        """Imports, exports natively, imports the export into another campaign; the content hashes must agree."""
        extra = ["--columns", self.write("columns.toml", columns)] if columns else []
        run = self.imported(name, text, *extra)
        native = self.folder / "out.csv"
        done = self.soak("runs", "export", run["run_id"], "--native", "-o", native)
        written = self.folder / "out.columns.toml"
        self.assertEqual(written.exists(), str(written) in done.stderr)
        if needs_map is not None:
            self.assertEqual(written.exists(), needs_map)
        extra = ["--columns", written] if written.exists() else []
        document = self.soak_json("import", "import", native, "--unit", "SN1", "--campaign", "again", *extra)
        self.assertEqual(document["runs"][0]["content_sha256"], run["content_sha256"])
        self.assertEqual(document["runs"][0]["run"], run["run"])
        return native.read_text(encoding="utf-8"), run

    def test_of_a_plain_recording_needs_no_map_and_gives_the_file_back(self):
        text = "t_s,run,phase,position,temp_c,gx_dps,ax_mps2\n0,r,soak,+X,25,0.1,9.8\n0.5,r,ramp,,25,-0.2,9.7\n1,r,soak,-X,26,1e-12,-9.9\n"
        exported, _ = self.round_trip("r.csv", text, needs_map=False)
        self.assertEqual(exported, text)

    def test_of_a_whole_campaign_file(self):
        self.round_trip("rec.csv", recording(seconds=20))

    def test_of_counts(self):
        noise = random.Random(3)
        rows = "".join(f"{1000 * i};{noise.randrange(-32768, 32768)};{noise.randrange(0, 1 << 32)};{2000 + i % 7}\n" for i in range(500))
        columns = """
separator = "semicolon"
[columns]
ticks = { as = "t_us", type = "i64", offset = 1.5 }
GX = { as = "gx_dps", type = "i16", scale = 0.0076335877862595 }
AX = { as = "ax_g", type = "u32", scale = 1e-7, offset = -214.7 }
T = { as = "temp_c", type = "i32", scale = 0.01 }
"""
        exported, run = self.round_trip("counts.csv", "ticks;GX;AX;T\n" + rows, columns, needs_map=True)
        self.assertEqual(exported.splitlines()[0], "ticks,run,GX,AX,T")
        self.assertEqual([line.split(",")[2] for line in exported.splitlines()[1:]], [line.split(";")[1] for line in rows.splitlines()])
        types = {c["name"]: c["type"] for c in self.soak_json("runs-show", "runs", "show", run["run_id"])["channels"]}
        self.assertEqual(types, {"t_s": "i64", "gyro_x": "i16", "accel_x": "u32", "temp_c": "i32"})

    def test_of_float32_with_all_bit_patterns(self):
        noise = random.Random(4)
        values = []
        while len(values) < 2000:
            pattern = struct.pack("<I", noise.getrandbits(32))
            value = struct.unpack("<f", pattern)[0]
            if value == value and abs(value) != float("inf"):
                values.append(value)
        rows = "".join(f"{i},25,{v!r}\n" for i, v in enumerate(values))
        columns = "[columns]\ngx_dps = { type = \"f32\" }\n"
        exported, _ = self.round_trip("single.csv", "t_s,temp_c,gx_dps\n" + rows, columns, needs_map=True)
        cells = [line.split(",")[3] for line in exported.splitlines()[1:]]
        single = [struct.unpack("<f", struct.pack("<f", float(c)))[0] for c in cells]
        self.assertEqual(single, values)
        self.assertLess(max(map(len, cells)), 16, "shortest float32 form, not float64's")

    def test_of_float64_that_looks_whole_needs_a_map(self):
        self.round_trip("whole.csv", "t_s,temp_c,gx_dps\n0.0,25.0,1.0\n1.0,26.0,2.0\n", needs_map=True)

    def test_of_floats_of_every_size(self):
        values = [0.1, -0.0, 5e-324, 1.7976931348623157e308, 1 / 3, 123456789.123456789, -1e-7]
        rows = "".join(f"{i + 0.25!r},25.5,{v!r}\n" for i, v in enumerate(values))
        exported, _ = self.round_trip("sizes.csv", "t_s,temp_c,gx_dps\n" + rows, needs_map=False)
        read = [float(line.split(",")[3]) for line in exported.splitlines()[1:]]
        self.assertEqual(struct.pack("<7d", *read), struct.pack("<7d", *values))

    def test_of_empty_cells_labels_and_odd_text(self):
        text = ("t_s,run,temp_c,gx_dps,ay_g,note,\"odd, \"\"name\"\"\",empty\n"
                "0.5,\"a, \"\"b\"\"\",25,,1,\"x, y\", lead,\n1.5,\"a, \"\"b\"\"\",,2,,,\"two\nlines\",\n"
                "2.5,\"a, \"\"b\"\"\",26,-3,,\u00e4\u00f6,z,\n")
        exported, run = self.round_trip("odd.csv", text)
        self.assertEqual(run["run"], "a, \"b\"")
        self.assertEqual(exported, text)

    def test_of_positions_that_the_map_defines(self):
        columns = "[columns]\nattitude = \"position\"\n[positions]\nP1 = [0, 0, 1]\ntilt = [1, 0, 1]\nunused = [0, 1, 1]\n"
        text = "t_s,temp_c,gx_dps,attitude\n" + "".join(f"{i}.5,25,0.5,{p}\n" for i, p in enumerate(["tilt", "", "P1", "+x", "P1"]))
        self.round_trip("positions.csv", text, columns, needs_map=True)
        written = (self.folder / "out.columns.toml").read_text()
        self.assertIn("0.7071067811865", written)
        self.assertNotIn("unused", written)

    def test_of_constants_and_a_foreign_column_named_run(self):
        columns = "[columns]\nrun = { as = \"counter\" }\n[constants]\nposition = \"+Z\"\nplateau_c = 25\n"
        self.round_trip("constants.csv", "t_s,run,temp_c,gx_dps\n0.5,1,25,1\n1.5,2,25,2\n", columns, needs_map=True)

    def test_native_export_to_standard_output_is_refused_where_a_map_is_needed(self):
        self.imported("whole.csv", "t_s,temp_c,gx_dps\n0.0,25.0,1.0\n")
        done = self.soak("runs", "export", "whole", "--native", status=2)
        self.assertEqual(done.stdout, "")
        self.assertIn("-o FILE", done.stderr)


if __name__ == "__main__":
    unittest.main()
