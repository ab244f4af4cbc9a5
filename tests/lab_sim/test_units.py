# SPDX-License-Identifier: Apache-2.0
"""Units of soaksim over TCP and a pseudo-terminal, read with a decoder of the tests' own."""
import json
import math
import socket
import statistics
import tempfile
import unittest

from laboratory import (ERROR, GOTO_CONFIG, GOTO_MEASUREMENT, OUTPUT_100_HZ, PATIENCE_S, REQ_DEVICE_ID, ROOT,
                        SET_OUTPUT, WAKE_UP, WAKE_UP_ACK, LaboratoryTest, Soaksim, Unit, read_register, truth, wait_for)

GRAVITY = 9.80665
QUIET_S = 1.0  # 20 s of device time


class UnitsTest(LaboratoryTest):
    """Slot 1 has a TCP port, slot 2 a terminal."""

    OPTIONS = ("--units", 2, "--rate", 20, "--seed", 7, "--pty", 2)

    def address(self, slot):
        return self.lab.addresses["units"][slot - 1]

    def setUp(self):
        for output in (1, 2):
            self.relay(output, False)

    def configured(self, unit, output=OUTPUT_100_HZ):
        unit.ask(GOTO_CONFIG)
        self.assertEqual(unit.ask(SET_OUTPUT, output), output)
        unit.ask(GOTO_MEASUREMENT)

    def woken(self, slot):
        """A reader of a unit that has just been given power and has said so. While it is open it must be read: the
        laboratory waits for it."""
        unit = Unit(self.address(slot))
        self.relay(slot, True)
        self.assertEqual(unit.next(), (WAKE_UP, b""))
        return unit

    def test_a_unit_is_identified_and_configured(self):
        for slot, device_id in ((1, "0380A001"), (2, "0380A002")):
            with self.subTest(slot=slot):
                with self.woken(slot) as unit:
                    unit.ask(GOTO_CONFIG)
                    self.assertEqual(unit.ask(REQ_DEVICE_ID).hex().upper(), device_id)
                    self.assertIn(b"SIMULATED", unit.ask(0x1C))
                    only_rates = bytes.fromhex("1020FFFF 80200032")
                    self.configured(unit, only_rates)
                    for values in unit.measurements(20):
                        self.assertEqual(sorted(values), ["counter", "gyro"])
                    unit.ask(GOTO_CONFIG)
                    self.assertEqual(unit.ask(SET_OUTPUT, OUTPUT_100_HZ), OUTPUT_100_HZ)
                    unit.send(SET_OUTPUT, bytes.fromhex("20100064"))
                    self.assertEqual(unit.wait_for(ERROR), b"\x21")

    def test_measurements_follow_each_other_without_a_gap(self):
        for slot in (1, 2):
            with self.subTest(slot=slot):
                with self.woken(slot) as unit:
                    self.configured(unit)
                    values = unit.measurements(2000)
                    for previous, current in zip(values, values[1:]):
                        self.assertEqual(current["counter"], previous["counter"] + 1)
                        self.assertEqual(current["time"], previous["time"] + 100)
                    temperatures = [v["temp"] for v in values if "temp" in v]
                    self.assertAlmostEqual(len(temperatures), 200, delta=1)
                    for temp in temperatures:
                        self.assertAlmostEqual(temp, 23.6, delta=0.8)
                    force = [statistics.fmean(v["accel"][axis] for v in values) for axis in range(3)]
                    self.assertAlmostEqual(math.hypot(*force), GRAVITY, delta=0.5)
                    self.assertGreater(force[2], 9.0, "the fixture stands in +Z, which both mountings keep")

    def test_the_stream_ends_with_the_power_and_begins_anew_with_it(self):
        for slot in (1, 2):
            with self.subTest(slot=slot):
                with self.woken(slot) as unit:
                    self.configured(unit)
                    self.assertGreater(unit.measurements(300)[-1]["counter"], 290)
                    self.relay(slot, False)
                    while unit.next(QUIET_S):
                        pass
                    self.assertIsNone(unit.next(QUIET_S))
                    unit.send(GOTO_CONFIG)
                    self.assertIsNone(unit.next(QUIET_S), "there is nobody to answer")
                    self.relay(slot, True)
                    self.assertEqual(unit.next(), (WAKE_UP, b""))
                    first = unit.measurements(1)[0]
                    self.assertEqual(first["counter"], 0)
                    self.assertLess(first["time"], 20000, "two seconds since the power came")

    def test_a_unit_that_is_answered_waits_to_be_configured(self):
        text = (ROOT / "hal" / "sim" / "lab.toml").read_text(encoding="utf-8")
        patient = text.replace("wake_up_s = 0.5 ", "wake_up_s = 100.0 ")
        self.assertNotEqual(patient, text)
        with tempfile.NamedTemporaryFile("w", suffix=".toml", encoding="utf-8") as config:
            config.write(patient)
            config.flush()
            lab = Soaksim("--units", 1, "--config", config.name)
        self.addCleanup(lab.end)
        with lab.powered_unit(1) as unit:
            self.assertEqual(unit.next(), (WAKE_UP, b""))
            unit.send(WAKE_UP_ACK)
            self.assertEqual(unit.ask(REQ_DEVICE_ID).hex().upper(), "0380A001")

    def test_a_second_reader_is_turned_away(self):
        with self.woken(1) as unit:
            with socket.create_connection(("127.0.0.1", self.address(1)), timeout=PATIENCE_S) as second:
                try:
                    self.assertEqual(second.recv(1), b"")
                except ConnectionResetError:
                    pass
            self.assertTrue(unit.measurements(1))

    def test_a_reader_can_come_back(self):
        for slot in (1, 2):
            with self.subTest(slot=slot):
                self.relay(slot, True)
                for _ in range(3):
                    with Unit(self.address(slot)) as unit:
                        self.assertTrue(unit.measurements(50))


def resting_means(unit, count):
    """Means of gyros in deg/s and accelerometers in m/s², and the mean temperature."""
    values = unit.measurements(count)
    gyro = [math.degrees(statistics.fmean(v["gyro"][axis] for v in values)) for axis in range(3)]
    accel = [statistics.fmean(v["accel"][axis] for v in values) for axis in range(3)]
    return gyro, accel, statistics.fmean(v["temp"] for v in values if "temp" in v)


class TruthOfTheStreamsTest(unittest.TestCase):
    SEED = 11

    def expected(self, sensor, temp, power_on, axis):
        """Reading of a resting sensor with the unit's z axis up, from the numbers of the truth."""
        grid = self.grid
        at = min(range(len(grid)), key=lambda i: abs(grid[i] - temp))
        bias = sensor["bias"][at] + sensor["power_on_offset"][power_on]
        if sensor["unit"] == "deg/s":
            return bias + sensor["g_sensitivity_dps_per_g"][2]
        own = (1.0 + sensor["scale_ppm"][at] * 1e-6) * GRAVITY if axis == 2 else 0.0
        return bias + own + sensor["misalignment_rad"][2] * GRAVITY

    # 3000 samples of 0.375 deg/s and 0.0167 m/s²: standard errors 0.007 and 0.0003. A grid step of 0.25 °C is worth
    # 0.005 deg/s at the steepest, slow noise 0.003. The offset of another power-on is off by 0.03 deg/s as a rule.
    def test_units_read_what_soaksim_truth_prints(self):
        document = json.loads(truth("--seed", self.SEED, "--units", 2))
        self.grid = document["temp_c"]
        lab = Soaksim("--seed", self.SEED, "--units", 2, "--rate", 100)
        self.addCleanup(lab.end)
        sensors = document["units"][1]["sensors"]
        self.assertEqual(document["units"][1]["unit"], "0380A002")
        errors = []
        for power_on in range(3):
            with lab.powered_unit(2) as unit:
                gyro, accel, temp = resting_means(unit, 3000)
            for axis, letter in enumerate("xyz"):
                gyro_error = gyro[axis] - self.expected(sensors[f"gyro_{letter}"], temp, power_on, axis)
                errors.append(gyro_error)
                self.assertAlmostEqual(gyro_error, 0.0, delta=0.045)
                accel_error = accel[axis] - self.expected(sensors[f"accel_{letter}"], temp, power_on, axis)
                self.assertAlmostEqual(accel_error, 0.0, delta=0.006)
        self.assertLess(math.sqrt(statistics.fmean(e * e for e in errors)), 0.02)


class RepeatabilityTest(unittest.TestCase):
    def samples(self, seed):
        lab = Soaksim("--seed", seed, "--units", 1, "--rate", 100)
        self.addCleanup(lab.end)
        with lab.powered_unit(1) as unit:
            return [(v["gyro"], v["accel"]) for v in unit.measurements(1000)]

    # Units stand at room temperature, so that they differ only by self-heating: by how the steps of the chamber's
    # physics lie to the moment of power-on. Rarely a value falls to the other side of a step of the converter.
    def test_the_same_seed_gives_the_same_samples(self):
        first = self.samples(3)
        same = sum(a == b for a, b in zip(first, self.samples(3)))
        self.assertGreater(same, 950)
        other = sum(a == b for a, b in zip(first, self.samples(4)))
        self.assertLess(other, 10)


class SlowReaderTest(unittest.TestCase):
    def test_the_clock_waits_for_a_reader_and_no_measurement_is_lost(self):
        lab = Soaksim("--units", 1, "--rate", "max")
        self.addCleanup(lab.end)
        with lab.powered_unit(1) as unit:
            last = unit.measurements(1)[0]["counter"]
            # Unread, the stream stops; the registers are still served.
            wait_for(lambda: self.stands_still(lab), "the clock stands still")
            for values in unit.measurements(20000):
                self.assertEqual(values["counter"], (last + 1) % 65536)
                last = values["counter"]

    @staticmethod
    def stands_still(lab):
        """The process value has new noise with each 0.1 s of device time, 0.02 ms of host time at this rate."""
        readings = {read_register(lab.addresses["chamber"], 2820) for _ in range(10)}
        return len(readings) == 1


if __name__ == "__main__":
    unittest.main()
