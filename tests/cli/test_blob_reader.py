# SPDX-License-Identifier: Apache-2.0
"""The reader written from docs/blob-format.md over the golden files, and what it refuses."""
import json
import math
import struct
import unittest

from blob_reader import BlobError, Calibration, SensorFlag, crc32c, read_sections
from soak_cli import ROOT

GOLDEN = ROOT / "tests" / "data" / "golden"


def golden(name):
    return (GOLDEN / f"{name}.soakcal").read_bytes()


def sealed(data):
    """With size and CRC made right again."""
    data = bytearray(data)
    struct.pack_into("<I", data, 12, len(data))
    struct.pack_into("<I", data, len(data) - 4, crc32c(bytes(data[:-4])))
    return bytes(data)


def with_section(data, kind, payload):
    count = struct.unpack_from("<I", data, 20)[0] + 1
    body = data[:20] + struct.pack("<I", count) + data[24:-4]
    return sealed(body + struct.pack("<HBBI", kind, 1, 0, len(payload)) + payload + bytes(4))


class Golden(unittest.TestCase):
    def test_values_are_those_computed_elsewhere(self):
        for path in sorted(GOLDEN.glob("*.values.json")):
            name = path.name.removesuffix(".values.json")
            values = json.loads(path.read_text(encoding="utf-8"))
            calibration = Calibration.load(golden(name))
            self.assertEqual(calibration.sensors, list(values["sensors"]), name)
            for sensor, points in values["sensors"].items():
                span = max(p["bias"] for p in points) - min(p["bias"] for p in points)
                for point in points:
                    bias, in_range = calibration.bias(sensor, point["temp_c"])
                    self.assertEqual(in_range, point["in_range"], (name, sensor, point))
                    self.assertAlmostEqual(bias, point["bias"], delta=5e-7 * span)

    def test_couplings_are_those_that_the_file_was_made_from(self):
        stated = Calibration.load(golden("couplings")).couplings
        self.assertEqual(stated.misalignment, ((0.0, 2 ** -13, 2 ** -14), (1.5 * 2 ** -13, 0.0, 2 ** -13), (2 ** -14, 2 ** -13, 0.0)))
        self.assertEqual([row[i] for i, row in enumerate(stated.g_sensitivity)], [2 ** -17] * 3)
        self.assertEqual(stated.even_order, {"accel_x": (-(2 ** -18), 2 ** -20), "accel_z": (2 ** -19, 2 ** -19)})
        self.assertEqual(stated.readings_only, {"g_sensitivity", "accel_z"})
        self.assertIsNone(Calibration.load(golden("mixed")).couplings)

    def test_a_memory_needs_a_width_and_its_mean_in_pairs_that_rise(self):
        def with_memory(lab_only=0, minor_version=7, **parameters):
            payload = struct.pack("<BBBB", lab_only, 1, 18, len(parameters)) + struct.pack(f"<{len(parameters)}f", *parameters.values())
            payload += b"thermal_hysteresis" + b"".join(bytes([len(name)]) + name.encode() for name in parameters)
            file = golden("fis")
            return with_section(file[:10] + bytes([minor_version, 0]) + file[12:], 0x0022, payload + bytes(-len(payload) % 4))
        mean = {"mean_1_c": -20.0, "mean_1": 0.25, "mean_2_c": 40.0, "mean_2": -0.5}
        term = Calibration.load(with_memory(amplitude=0.5, width_c=6.0, **mean)).terms[-1]
        self.assertEqual((term.lab_only, dict(term.parameters)["mean_2"]), (False, -0.5))
        Calibration.load(with_memory(amplitude=0.5, width_c=6.0))
        Calibration.load(with_memory(lab_only=1, amplitude=0.5, width_c=-6.0))
        for broken in ({"width_c": 0.0, **mean}, {"amplitude": 0.5}, {"width_c": 6.0, **mean, "mean_2_c": -20.0},
                       {"width_c": 6.0, "mean_1_c": 0.0}, {**mean, "width_c": 6.0}):
            with self.assertRaises(BlobError, msg=str(broken)):
                Calibration.load(with_memory(**broken))
            # Before 1.7 nothing was asked of it, and nothing is made of it.
            self.assertTrue(Calibration.load(with_memory(minor_version=6, **broken)).terms[-1].lab_only, broken)

    def test_a_memory_to_follow_is_what_the_file_was_made_from(self):
        self.assertEqual(struct.unpack_from("<H", golden("history"), 10)[0], 7)
        term, = Calibration.load(golden("history")).terms
        self.assertEqual((term.name, term.sensors, term.lab_only), ("thermal_hysteresis", ("gyro_x", "gyro_z"), False))
        self.assertEqual(dict(term.parameters), {"amplitude": 2**-9, "amplitude_per_c": 2**-16, "width_c": 8.0, "reference_c": 20.0,
                                                 "mean_1_c": -30.0, "mean_1": -(2**-11), "mean_2_c": 70.0, "mean_2": 2**-10})

    def test_what_is_not_released_says_so_from_version_1_8_on(self):
        self.assertEqual([Calibration.load(golden(name)).unreleased for name in ("unreleased", "history")], [True, False])
        self.assertEqual(struct.unpack_from("<H", golden("unreleased"), 10)[0], 8)

    def test_misalignment_of_the_gyros_is_that_the_file_was_made_from(self):
        stated = Calibration.load(golden("gyros")).gyro_misalignment
        self.assertAlmostEqual(stated.matrix[1][2], 0.005, 9)
        self.assertEqual(stated.uncertainty[1][0], 1.5 * 2**-12)
        self.assertTrue(stated.readings_only)

    def test_one_run_and_one_way_are_those_that_the_file_was_made_from(self):
        calibration = Calibration.load(golden("one_way"))
        self.assertTrue(all(table.one_run for table in calibration.uncertainties.values()))
        self.assertEqual(sorted(calibration.one_way), ["accel_y", "accel_z", "gyro_x"])
        gyro = calibration.one_way["gyro_x"]
        self.assertEqual(gyro.ranges, ((-22.5, 17.5, "up"), (32.5, 62.5, "up")))
        self.assertEqual((gyro.half_gap, gyro.source), (2**-12, "type"))
        self.assertEqual(calibration.one_way["accel_y"].source, "fleet")
        accel = calibration.one_way["accel_z"]
        self.assertEqual((accel.ranges, accel.half_gap, accel.source),
                         (((-30.0, 20.0, "down"), (20.0, 45.0, "up")), 0.0, "none"))
        self.assertEqual(struct.unpack_from("<H", golden("one_way"), 10)[0], 6)
        other = Calibration.load(golden("fis"))
        self.assertEqual((other.one_way, any(t.one_run for t in other.uncertainties.values())), ({}, False))

    def test_sensors_with_thermometers_of_their_own_are_corrected_at_their_temperatures(self):
        calibration = Calibration.load(golden("thermometers"))
        self.assertEqual(calibration.own_thermometers, ["gyro_x", "accel_z"])
        self.assertEqual(Calibration.load(golden("fis")).own_thermometers, [])
        samples = json.loads((GOLDEN / "thermometers.values.json").read_text(encoding="utf-8"))["corrected_temps"]
        for sample in samples:
            temps = dict(zip(calibration.sensors, sample["temps_c"]))
            own = {name: temps[name] for name in calibration.own_thermometers}
            out, flags = calibration.apply(temps["gyro_y"], sample["raw"], own)
            for value, expected in zip(out, sample["out"]):
                self.assertAlmostEqual(value, expected, delta=5e-7)
            self.assertFalse(any(flag & SensorFlag.NO_TEMPERATURE for flag in flags))
        _, flags = calibration.apply(20.0, [0.0] * 6)
        self.assertEqual([bool(flag & SensorFlag.NO_TEMPERATURE) for flag in flags], [True] + [False] * 4 + [True])

    def test_each_table_has_the_bound_of_its_curve(self):
        calibration = Calibration.load(golden("table"))
        self.assertEqual(set(calibration.table_bounds), set(calibration.curves))
        plain = Calibration.load(golden("fis"))
        for key, bound in calibration.table_bounds.items():
            # both files hold their numbers in float32: 2^-23 of the value and of the half range
            curve, table = plain.curves[key], calibration.curves[key]
            rounding = 2 ** -22 * (abs(curve.centre) + curve.half_range)
            for i in range(-300, 701, 7):
                self.assertLessEqual(abs(curve.value(i / 10) - table.value(i / 10)), bound + rounding, (key, i))


class Refusals(unittest.TestCase):
    def refused(self, data, words):
        with self.assertRaisesRegex(BlobError, words):
            Calibration.load(data)

    def test_bounds_of_tables(self):
        bound = struct.pack("<BBHf", 0, 0, 0, 1e-6)
        self.refused(with_section(golden("table"), 0x0031, bound), "two table bounds")
        self.refused(with_section(golden("fis"), 0x0031, bound), "before it, or of none")
        self.refused(with_section(golden("fis"), 0x0031, struct.pack("<BBHf", 0, 0, 0, math.nan)), "not finite|of none")

    def test_thermometers(self):
        one_way = struct.pack("<BBHfffI", 1, 0, 1, 0.0, -10.0, 10.0, 1)
        Calibration.load(with_section(golden("fis"), 0x0015, one_way))
        self.refused(with_section(golden("mixed"), 0x0015, one_way), "before its own section")
        self.refused(with_section(with_section(golden("fis"), 0x0015, one_way), 0x0015, one_way), "two sections of one-way")
        self.refused(with_section(golden("fis"), 0x0015, one_way[:-4]), "too short")
        self.refused(with_section(golden("thermometers"), 0x0024, bytes([1, 0, 0, 0])), "two sections of thermometers")
        self.refused(with_section(golden("fis"), 0x0024, b""), "too short")
        self.refused(with_section(golden("fis"), 0x0024, bytes(8)), "too long")

    def test_couplings(self):
        (payload,) = [s.payload for s in read_sections(golden("couplings")) if s.kind == 0x0023]
        self.refused(with_section(golden("couplings"), 0x0023, payload), "two sections of couplings")
        self.refused(with_section(golden("fis"), 0x0023, payload), "of no misalignment")
        self.refused(with_section(golden("mixed"), 0x0023, payload[:-8]), "too short")
        negative = payload[:8] + struct.pack("<f", -1.0) + payload[12:]
        self.refused(with_section(golden("mixed"), 0x0023, negative), "negative")
        Calibration.load(with_section(golden("mixed"), 0x0023, payload))


if __name__ == "__main__":
    unittest.main()
