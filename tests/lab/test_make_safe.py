# SPDX-License-Identifier: Apache-2.0
"""soak chamber make-safe, from a process of its own, where soakd is dead, hangs, or is well. The chamber's registers are
judged, read beside it."""
import json
import re
import signal
import ssl
import struct
import subprocess
import time
import unittest
import urllib.request

import bench
from bench import AUTO, OFF, LabTest, long_test, short_procedure
from lab_session import bin_folder
from modbus_proxy import forgets, refuses

SET_POINT, MODE, AIR = 2782, 2730, 2820
SAFE_C = 25.0


def reads_nan(register):
    """Changes the answer to a block of registers so that the one at `register` holds NaN."""
    def change(request, answer):
        if request[0] != 3:
            return answer
        first, count = struct.unpack(">HH", request[1:5])
        at = 2 + 2 * (register - first)
        if not first <= register < first + count - 1:
            return answer
        low, high = struct.unpack(">HH", struct.pack(">f", float("nan"))[2:] + struct.pack(">f", float("nan"))[:2])
        return answer[:at] + struct.pack(">HH", low, high) + answer[at + 4:]
    return change


class MakeSafe(LabTest):
    def start(self, set_point_c=60, rate=400, through_proxy=False, position_s=100000):
        """A campaign that records at that temperature for ever."""
        self.start_lab(rate=rate, edit=self.with_chamber_proxy if through_proxy else None)
        self.start_campaign(short_procedure(set_points=(set_point_c,), positions=("+Z",), dwell_s=position_s))
        self.wait_for_step("record")
        self.assertEqual(self.chamber()[0], AUTO)

    def kill_soakd(self):
        self.lab.soakd.send_signal(signal.SIGKILL)
        self.lab.soakd.wait()

    def make_safe(self):
        done = self.lab.soak_json("chamber", "make-safe", "--config", self.config, "--data", self.lab.data)
        self.check_schema(done, "chamber-make-safe")
        return done

    def wait_for_air(self, near_c):
        client = self.modbus("chamber")
        end_s = time.monotonic() + bench.WAIT_S
        while abs((air_c := self.read_f32(client, AIR)) - near_c) > 0.8:
            self.assertLess(time.monotonic(), end_s, air_c)
            time.sleep(0.05)

    def test_a_chamber_whose_soakd_was_killed_is_driven_to_room_temperature_then_switched_off(self):
        self.start(60)
        self.kill_soakd()
        mode, _, set_point_c, air_c = self.chamber()
        self.assertEqual((mode, set_point_c), (AUTO, 60.0), "nobody drives it: it stays where it was")
        self.assertGreater(air_c, 50.0)
        done = self.make_safe()
        self.assertEqual((done["action"], done["safe_temp_c"], done["running"], done["set_point_c"]), ("driven", SAFE_C, True, SAFE_C))
        self.assertFalse(done["beside_soakd"])
        self.assertEqual((self.chamber()[0], self.chamber()[2]), (AUTO, SAFE_C))
        # The air goes past the set point once or twice before it stays: where it is away again, it is driven again.
        end_s = time.monotonic() + bench.WAIT_S
        while done["action"] == "driven":
            self.assertLess(time.monotonic(), end_s, done)
            self.wait_for_air(SAFE_C)
            done = self.make_safe()
        self.assertEqual(done["action"], "switched_off")
        self.assertEqual(self.chamber()[:2], (OFF, 0.0))
        done = self.make_safe()
        self.assertEqual((done["action"], done["running"]), ("left_off", False))
        self.assertEqual(self.chamber()[0], OFF)
        self.assert_event("chamber", "make-safe", "25")
        # The next soakd finds a campaign that nobody ended, and ends it as ever.
        self.lab.soakd.stdout.close()
        self.lab.start_soakd()
        self.assertEqual(self.wait_for_end()["state"], "interrupted")
        self.assert_safe()

    @long_test
    def test_a_cold_chamber_is_warmed_above_the_dew_point_of_the_room(self):
        self.start(-20)
        self.kill_soakd()
        text = re.sub(r"(?m)^(dew_point_c|temp_c) = .*$", "", self.config.read_text(encoding="utf-8")).replace("[room]", "")
        self.config.write_text(text + "\n[room]\ntemp_c = 28\ndew_point_c = 23\n", encoding="utf-8")
        done = self.make_safe()
        self.assertEqual((done["action"], done["safe_temp_c"], done["set_point_c"]), ("driven", 27.0, 27.0))
        self.wait_for_air(27.0)

    def test_a_soakd_that_is_well_is_not_disturbed(self):
        self.start(60)
        message = self.soak_fails(2, "chamber", "make-safe", "--config", self.config, "--data", self.lab.data)
        self.assertIn(str(self.lab.soakd.pid), message)
        self.assertEqual((self.chamber()[0], self.chamber()[2]), (AUTO, 60.0))
        self.assertEqual(self.status()["state"], "running")

    def test_a_soakd_that_speaks_tls_and_asks_who_it_is_is_not_disturbed(self):
        def for_others(text):
            subprocess.run([bin_folder() + "/soak", "user", "add", "eva", "--role", "engineer", "--data", self.lab.data], check=True,
                           input="a long password\n", text=True, capture_output=True)
            return 'allowed_hosts = ["soak.lab.example"]\n' + text
        self.start_lab(edit=for_others)
        context = ssl.create_default_context(cafile=self.lab.data + "/soakd.crt")

        def is_connected():
            with urllib.request.urlopen(self.lab.page + "api/v1/alive", timeout=30, context=context) as answer:
                return json.load(answer)["chamber_connected"]
        end_s = time.monotonic() + bench.WAIT_S
        while not is_connected():
            self.assertLess(time.monotonic(), end_s, self.lab.log())
            time.sleep(0.05)
        message = self.soak_fails(2, "chamber", "make-safe", "--config", self.config, "--data", self.lab.data)
        self.assertIn(str(self.lab.soakd.pid), message)
        # Its certificate file is replaced: soakd goes on with that of its start.
        subprocess.run(["openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-subj", "/CN=another", "-keyout", "/dev/null", "-out",
                        self.lab.data + "/soakd.crt"], check=True, capture_output=True)
        message = self.soak_fails(2, "chamber", "make-safe", "--config", self.config, "--data", self.lab.data)
        self.assertIn(str(self.lab.soakd.pid), message)

    @long_test
    def test_a_soakd_that_hangs_is_gone_round(self):
        self.start(60)
        self.lab.soakd.send_signal(signal.SIGSTOP)
        self.addCleanup(self.lab.soakd.send_signal, signal.SIGCONT)
        done = self.make_safe()
        self.assertEqual((done["action"], done["beside_soakd"]), ("driven", True))
        self.assertEqual((self.chamber()[0], self.chamber()[2]), (AUTO, SAFE_C))

    @long_test
    def test_a_soakd_that_the_chamber_does_not_answer_is_gone_round(self):
        """The wire of soakd is dead; that of make-safe is another one."""
        self.start_lab(cut=["chamber"])
        straight = self.folder / "straight.toml"
        straight.write_text(re.sub(rf"(?m)^port = {self.proxies['chamber'].port}$", f"port = {self.lab.ports['chamber']}",
                                   self.config.read_text(encoding="utf-8")), encoding="utf-8")
        self.start_campaign(short_procedure(set_points=(60,), positions=("+Z",), dwell_s=100000))
        self.wait_for_step("record")
        self.proxies["chamber"].cut()
        self.wait("the loss", lambda s: not s["chamber"]["connected"])
        self.config = straight
        done = self.make_safe()
        self.assertEqual((done["action"], done["beside_soakd"]), ("driven", True))
        self.assertEqual((self.chamber()[0], self.chamber()[2]), (AUTO, SAFE_C))

    def expect_off_where_the_set_point(self, answer):
        self.start(60, through_proxy=True)
        self.kill_soakd()
        self.proxy.answer = answer
        self.proxy.writes.clear()
        done = self.make_safe()
        self.assertEqual((done["action"], done["running"]), ("switched_off", False))
        self.assertIn("+25", done["why_off"])
        self.assertEqual(self.chamber()[:3], (OFF, 0.0, 60.0))
        self.assertLessEqual(len(self.proxy.writes_to(SET_POINT)), 5)

    def test_a_chamber_that_refuses_the_set_point_is_switched_off(self):
        self.expect_off_where_the_set_point(refuses(SET_POINT))

    @long_test
    def test_a_chamber_that_forgets_the_set_point_is_switched_off(self):
        self.expect_off_where_the_set_point(forgets(SET_POINT))

    def test_a_chamber_with_an_alarm_is_switched_off_at_once(self):
        self.start(60)
        self.kill_soakd()
        client = self.modbus("chamber")
        client.write_registers(1334, self.words_f32(40.0), 1)  # high set point of the first alarm
        time.sleep(0.1)
        done = self.make_safe()
        self.assertEqual(done["action"], "switched_off")
        self.assertIn("alarm 1", done["why_off"])
        self.assertIn("alarm 1", done["alarms"])
        self.assertEqual(self.chamber()[:3], (OFF, 0.0, 60.0))

    @long_test
    def test_a_chamber_that_reads_nonsense_is_switched_off(self):
        self.start(60, through_proxy=True)
        self.kill_soakd()
        self.proxy.change_answer = reads_nan(AIR)
        done = self.make_safe()
        self.assertEqual((done["action"], done["air_c"], done["running"]), ("switched_off", None, None))
        self.assertEqual(self.chamber()[:2], (OFF, 0.0))

    @long_test
    def test_what_cannot_be_made_safe_is_a_device_that_failed(self):
        self.start(60, through_proxy=True)
        self.kill_soakd()
        self.proxy.answer = lambda request: refuses(MODE)(request) or refuses(SET_POINT)(request)
        self.assertIn(str(self.proxy.port), self.soak_fails(3, "chamber", "make-safe", "--config", self.config, "--data", self.lab.data))
        self.assertEqual(self.chamber()[0], AUTO)
        self.proxy.close()
        self.lab.soaksim.kill()
        self.soak_fails(3, "chamber", "make-safe", "--config", self.config, "--data", self.lab.data)

    def test_it_says_in_a_sentence_what_the_chamber_does_and_needs_no_data_folder(self):
        self.start(60)
        self.kill_soakd()
        missing = self.folder / "none"
        done = subprocess.run([bin_folder() + "/soak", "chamber", "make-safe", "--config", str(self.config), "--data", str(missing)],
                              env=self.lab.env, capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn(f"127.0.0.1:{self.lab.ports['chamber']}", done.stdout)
        self.assertRegex(done.stdout, r"\+25\.0 °C")
        self.assertFalse(missing.exists())
        self.soak_fails(2, "chamber", "make-safe", "--config", self.folder / "absent.toml")


if __name__ == "__main__":
    bench.main(first=("test_what_cannot_be_made_safe_is_a_device_that_failed", "test_a_chamber_that_reads_nonsense_is_switched_off"))
