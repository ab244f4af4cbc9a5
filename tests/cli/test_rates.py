# SPDX-License-Identifier: Apache-2.0
"""Recordings in which the fixture turns: rates in a column or in the columns map, to the scale curve of a gyro."""
import datetime
import math
import random
import unittest

from soak_cli import SoakTest

UPS = {"+X": (1, 0, 0), "-X": (-1, 0, 0), "+Y": (0, 1, 0), "-Y": (0, -1, 0), "+Z": (0, 0, 1), "-Z": (0, 0, -1)}
STOPS = [(face, 0) for face in UPS] + [(face, rate) for face in ("+X", "+Y", "+Z") for rate in (100, -100)]
PLATEAUS = (-30, -15, 0, 15, 30, 45, 60)
GYROS = ("gyro_x", "gyro_y", "gyro_z")
LABELS = {(face, rate): face if rate == 0 else f"table {face} {'left' if rate > 0 else 'right'}" for face, rate in STOPS}
MAP = "[positions]\n" + "".join(f"\"{label}\" = {{ up = {list(UPS[face])}, rate_dps = {rate} }}\n"
                                for (face, rate), label in LABELS.items() if rate != 0)


def scale_ppm(axis, temp_c):
    return (-1500, 800, 200)[axis] + (40, -25, 10)[axis] * temp_c


def recording(seed, run, rate_header="rate_dps", plateaus=PLATEAUS, per_dps=1.0):
    """Twelve stops of 30 s at each plateau, 2 Hz. Without `rate_header` the labels of the map name the rates."""
    noise = random.Random(seed)
    header = ["t_s", "run", "plateau_c", "position", "temp_c", "gx_dps", "gy_dps", "gz_dps", "ax_mps2", "ay_mps2", "az_mps2"]
    lines = [",".join(header + ([rate_header] if rate_header else []))]
    offset = [noise.gauss(0, 0.02) for _ in range(3)]
    t = 0.0
    for plateau in plateaus:
        for face, rate in STOPS:
            for _ in range(60):
                gyro = [0.1 + offset[a] + 0.001 * plateau + (1 + 1e-6 * scale_ppm(a, plateau)) * rate * UPS[face][a] + noise.gauss(0, 0.01)
                        for a in range(3)]
                # The accelerometers sit 5 cm from the axis of rotation.
                outward = 0.05 * (rate * math.pi / 180) ** 2
                force = [9.80665 * u + (0 if u else outward) + noise.gauss(0, 0.005) for u in UPS[face]]
                label = face if rate_header else LABELS[face, rate]
                cells = [f"{t:.1f}", run, str(plateau), label, f"{plateau + noise.gauss(0, 0.02):.3f}", *(f"{x:.6f}" for x in gyro + force)]
                lines.append(",".join(cells + ([repr(rate * per_dps)] if rate_header else [])))
                t += 0.5
    return "\n".join(lines) + "\n"


def day(offset):
    return (datetime.datetime.now(datetime.timezone.utc) + datetime.timedelta(days=offset)).strftime("%Y-%m-%d")


class Rates(SoakTest):
    def check_scale(self):
        fit = self.soak_json("fit", "fit", "--unit", "SN1")
        for axis, name in enumerate(GYROS):
            sensor = fit["sensors"][name]
            self.assertIsNotNone(sensor["scale_deployed"])
            for point in sensor["curve"]:
                # Noise of a segment mean: 0.01/sqrt(60) deg/s, of a pair of rates 9 ppm. A curve over seven plateaus of
                # three runs knows each point better than one row; four of the rows' errors are plenty.
                self.assertAlmostEqual(point["scale_ppm"], scale_ppm(axis, point["temp_c"]), delta=37, msg=(name, point["temp_c"]))
        self.assertIn("rate_positions", [warning["code"] for warning in fit["warnings"]])
        return fit

    def test_a_column_of_rates_gives_the_gyros_a_scale_curve(self):
        for n in (1, 2, 3):
            run = self.imported(f"r{n}.csv", recording(n, f"r{n}"), "--gravity-mps2", "9.80665")
            self.assertEqual(run["segments"], len(PLATEAUS) * len(STOPS))
        self.check_scale()
        positions = {s["position"] for s in self.soak_json("runs-show", "runs", "show", "r1")["segments"]}
        self.assertEqual(positions, set(UPS) | {f"{face} at {rate} deg/s" for face, rate in STOPS if rate})

    def test_the_fixtures_certificate_corrects_its_rates(self):
        """A fixture that turns 400 ppm faster than it says: without its certificate that is 400 ppm of scale."""
        entry = ("reference", "add", "--kind", "rate", "--name", "table", "--issued", day(-100), "--due", day(200))
        self.soak(*entry, "--certificate", "A", "--uncertainty", 40, "--correction", 400)
        for n in (1, 2, 3):
            self.imported(f"r{n}.csv", recording(n, f"r{n}", per_dps=1 / 1.0004), "--gravity-mps2", "9.80665", "--references")
        fit = self.check_scale()
        for name in GYROS:
            line = next(part for part in fit["sensors"][name]["scale_uncertainty"] if part["name"] == "fixture")
            self.assertAlmostEqual(line["curve"]["max"], 20.0, places=9)
        self.soak("report", "--unit", "SN1", "-o", self.folder / "page.html")
        self.assertRegex((self.folder / "page.html").read_text(encoding="utf-8"), '<data value="400(.0)?">[^<]*</data> ppm')

    def test_positions_of_a_columns_map_may_turn(self):
        columns = self.write("columns.toml", MAP)
        for n in (1, 2, 3):
            self.imported(f"r{n}.csv", recording(n, f"r{n}", None), "--columns", columns, "--gravity-mps2", "9.80665")
        self.check_scale()

    def test_rates_in_radians_are_the_same_rates(self):
        short = {"plateaus": (0, 20, 40)}
        self.imported("a.csv", recording(1, "a", **short))
        self.imported("b.csv", recording(1, "b", "rate_rps", per_dps=math.pi / 180, **short))
        shown = [self.soak_json("runs-show", "runs", "show", run)["segments"] for run in ("a", "b")]
        self.assertEqual(*[[(s["position"], s["t_start_s"], s["t_end_s"]) for s in segments] for segments in shown])

    def round_trip(self, run):
        native = self.folder / "out.csv"
        self.soak("runs", "export", run["run_id"], "--native", "-o", native)
        written = self.folder / "out.columns.toml"
        extra = ["--columns", written] if written.exists() else []
        again = self.soak_json("import", "import", native, "--unit", "SN1", "--campaign", "again", *extra)["runs"][0]
        self.assertEqual(again["content_sha256"], run["content_sha256"])
        self.assertEqual(again["segments"], run["segments"])
        return written

    def test_exports_come_back_to_the_last_bit(self):
        short = {"plateaus": (0, 20, 40)}
        self.assertFalse(self.round_trip(self.imported("a.csv", recording(1, "a", per_dps=1.005, **short))).exists())
        columns = self.write("columns.toml", MAP)
        written = self.round_trip(self.imported("b.csv", recording(1, "b", None, **short), "--columns", columns))
        self.assertIn('"table +X left" = { up = [1.0, 0.0, 0.0], rate_dps = 100.0 }', written.read_text(encoding="utf-8"))

    def test_leaning_faces_come_back_to_the_last_bit(self):
        columns = self.write("columns.toml", '[positions]\n"+X" = [1, 0.004, -0.0021]\n'
                             '"-z" = { up = [0.001, 0, -1], azimuth_deg = 33.3 }\n[azimuths_deg]\n"-X" = 12\n')
        run = self.imported("a.csv", recording(1, "a", plateaus=(0, 20, 40)), "--columns", columns)
        self.assertIn('"+X" = [0.99', self.round_trip(run).read_text(encoding="utf-8"))

    def test_the_canonical_export_keeps_the_rates(self):
        self.imported("a.csv", recording(1, "a", "rate_rps", per_dps=math.pi / 180, plateaus=(0, 20, 40)))
        path = self.folder / "out.csv"
        self.soak("runs", "export", "a", "-o", path)
        header, *rows = [line.split(",") for line in path.read_text(encoding="utf-8").splitlines()]
        rates = {round(float(row[header.index("rate_dps")]), 9) for row in rows}
        self.assertEqual(rates, {0.0, 100.0, -100.0})

    def test_a_row_without_a_rate_belongs_to_no_position(self):
        lines = recording(1, "a", plateaus=(0, 20)).splitlines()
        # From the 30th second of the first stop on nothing is said of the rate: slow channels hold for 2 s.
        head, body = lines[0], lines[1:]
        body = body[:30] + [line.rsplit(",", 1)[0] + "," for line in body[30:60]] + body[60:]
        self.imported("a.csv", "\n".join([head, *body]) + "\n")
        first = self.soak_json("runs-show", "runs", "show", "a")["segments"][0]
        self.assertLess(first["t_end_s"] - first["t_start_s"], 17.5)

    def refused(self, text, columns=None):
        extra = ["--columns", self.write("columns.toml", columns)] if columns else []
        error = self.refusal("import", self.write("bad.csv", text), "--unit", "SN1", *extra)
        self.assertEqual(list((self.data / "runs").glob("*")) if self.data.exists() else [], [])
        return error

    def test_the_fastest_fixture_is_taken(self):
        self.imported("fast.csv", "t_s,temp_c,gx_dps,position,rate_dps\n" + "".join(f"{i},25,{i % 7},+X,-20000\n" for i in range(60)))

    def test_what_cannot_be_meant_is_refused(self):
        self.assertIn("'position'", self.refused("t_s,temp_c,gx_dps,rate_dps\n0,25,1,30\n")["message"])
        text = "t_s,temp_c,gx_dps,position,rate_dps\n" + "".join(f"{i},25,{i % 7}.5,+X,{100 + i * 0.01:.2f}\n" for i in range(300))
        self.refused(text)
        self.refused(text, MAP)
        for header, value in (("rate_dps", "20000.1"), ("rate_dps", "-1e300"), ("rate_rps", "349.1")):
            text = f"t_s,temp_c,gx_dps,position,{header}\n0,25,1,+X,30\n1,25,1,+X,{value}\n"
            error = self.refusal("import", self.write("bad.csv", text), "--unit", "SN1")
            self.assertIn(f"bad.csv, line 3, column '{header}'", error["where"])
        for value in ("{ up = [1, 0, 0], rate_dps = 20000.1 }", "{ up = [1, 0, 0], rate_dps = \"fast\" }",
                      "{ up = [1, 0, 0], speed = 3 }", "{ rate_dps = 3 }"):
            error = self.refused("t_s,temp_c,gx_dps\n0,25,1\n", f"[positions]\nP = {value}\n")
            self.assertTrue(error["where"].startswith(str(self.folder / "columns.toml")), error)


if __name__ == "__main__":
    unittest.main()
