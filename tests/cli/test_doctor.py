# SPDX-License-Identifier: Apache-2.0
"""soak doctor: what it says of ports, permissions, USB devices, disk, database and clock."""
import grp
import json
import os
import pty
import pwd
import re
import shutil
import subprocess
import unittest

from soak_cli import ROOT, SoakTest, check_schema

CHAMBER = f'[chamber]\nmap = "{ROOT}/procedures/chambers/watlow-f4t.toml"\nhost = "127.0.0.1"\n'

USB_DEVICE = """P: /devices/pci0000:00/0000:00:14.0/usb1/1-4
N: bus/usb/001/002
E: SUBSYSTEM=usb
E: DEVTYPE=usb_device
E: DEVNAME=/dev/bus/usb/001/002
A: busnum=1\\n
A: devnum=2\\n
A: idVendor=2639\\n
A: idProduct=0013\\n
A: product=MTi-30\\n
A: serial=03800001\\n

"""


class DoctorTest(SoakTest):
    def config(self, *slots):
        text = CHAMBER + "".join(f'[[slot]]\nname = "{i + 1}"\n{slot}\n' for i, slot in enumerate(slots))
        return self.write("station.toml", text)

    def doctor(self, *arguments, status=0, before=(), **options):
        """The document that is printed, as a mapping from subject to check."""
        command = [*map(str, before), *self.command("doctor", "--json", *arguments)]
        done = subprocess.run(command, capture_output=True, text=True, **options)
        self.assertEqual(done.returncode, status, done.stdout + done.stderr)
        document = json.loads(done.stdout)
        check_schema(document, "doctor")
        self.assertEqual(document["ok"], status == 0)
        return {check["subject"]: check for check in document["checks"]}

    def setUp(self):
        super().setUp()
        self.soak("unit", "add", "SN1", "--type", "mti-300")  # makes the data folder

    def test_a_folder_without_a_catalog_is_no_data_folder(self):
        for data in (self.folder / "missing", self.folder):
            with self.subTest(data):
                self.data = data
                self.assertEqual(self.doctor(status=2)["database"]["finding"], "failed")

    def test_the_folder_of_a_station_that_was_never_started_is_new(self):
        _, slave = pty.openpty()
        port = os.ttyname(slave)
        for folder, finding, status in (("missing", "warning", 0), ("empty", "warning", 0), ("full", "failed", 2)):
            with self.subTest(folder):
                data = self.folder / folder
                if folder != "missing":
                    data.mkdir()
                if folder == "full":
                    (data / "letter.txt").write_text("x", encoding="utf-8")
                config = self.config(f'device = "{port}"')
                config.write_text(f'data = "{data}"\n{config.read_text(encoding="utf-8")}', encoding="utf-8")
                command = [os.environ["SOAK_BIN"], "doctor", "--json", "--config", str(config)]
                done = subprocess.run(command, capture_output=True, text=True, env={**os.environ, "SOAK_DATA": ""})
                self.assertEqual(done.returncode, status, done.stdout + done.stderr)
                checks = {check["subject"]: check for check in json.loads(done.stdout)["checks"]}
                self.assertEqual(checks["database"]["finding"], finding)

    def test_without_a_configuration_the_computer_is_looked_at(self):
        checks = self.doctor()
        self.assertEqual(set(checks), {"disk", "database", "clock"})
        self.assertIn("GB", checks["disk"]["text"])
        self.assertEqual(checks["database"]["finding"], "ok")
        self.assertNotEqual(checks["clock"]["finding"], "failed")

    def test_a_port_that_is_there_is_ok_and_one_that_is_not_is_named(self):
        _, slave = pty.openpty()
        port = os.ttyname(slave)
        checks = self.doctor("--config", self.config(f'device = "{port}"', 'device = "/dev/no-such-port"'), status=3)
        self.assertEqual(checks["slot 1"]["finding"], "ok")
        self.assertEqual(checks["slot 2"]["finding"], "failed")
        self.assertIn("/dev/no-such-port", checks["slot 2"]["text"])
        self.assertEqual(checks["chamber"]["finding"], "ok")

    def test_a_file_is_no_port(self):
        file = self.write("not-a-port", "")
        checks = self.doctor("--config", self.config(f'device = "{file}"'), status=3)
        self.assertEqual(checks["slot 1"]["finding"], "failed")
        self.assertIn(str(file), checks["slot 1"]["text"])

    @unittest.skipIf(os.geteuid() != 0, "needs root to become somebody else")
    def test_a_missing_group_is_named_with_the_command_that_adds_it(self):
        _, slave = pty.openpty()
        port = os.ttyname(slave)
        dialout = grp.getgrnam("dialout").gr_gid
        os.chown(port, 0, dialout)
        os.chmod(port, 0o660)
        nobody = pwd.getpwnam("nobody")
        # Program and map where anybody may read them: the project may lie in a home that is closed to others.
        program = shutil.copy(os.environ["SOAK_BIN"], self.folder / "soak")
        chamber = shutil.copy(ROOT / "procedures" / "chambers" / "watlow-f4t.toml", self.folder)
        config = self.config(f'device = "{port}"')
        config.write_text(re.sub('^map = .*', f'map = "{chamber}"', config.read_text(), flags=re.M))
        for path in [self.folder, config, program, chamber, self.data, *self.data.rglob("*")]:
            shutil.chown(path, nobody.pw_uid)
        somebody = {"user": nobody.pw_uid, "group": nobody.pw_gid, "executable": program, "cwd": self.folder}
        checks = self.doctor("--config", config, status=3, extra_groups=[], **somebody)
        self.assertIn(port, checks["slot 1"]["text"])
        self.assertIn("sudo usermod -aG dialout nobody", checks["slot 1"]["text"])
        checks = self.doctor("--config", config, extra_groups=[dialout], **somebody)
        self.assertEqual(checks["slot 1"]["finding"], "ok")

    def test_usb_devices_are_found_by_what_they_are(self):
        bus = self.write("bus.umockdev", USB_DEVICE)
        before = ["umockdev-run", "-d", bus, "--"]
        environment = dict(os.environ, ASAN_OPTIONS="verify_asan_link_order=0")
        config = self.config('usb = "2639:0013"\nusb_path = "1-4"', 'usb = "0403:6001"\ndecoder = "ahrs400"')
        checks = self.doctor("--config", config, status=3, before=before, env=environment)
        self.assertEqual(checks["slot 1"]["finding"], "ok")
        self.assertIn("MTi-30, serial 03800001", checks["slot 1"]["text"])
        self.assertEqual(checks["slot 2"]["finding"], "failed")
        self.assertIn("0403:6001", checks["slot 2"]["text"])

    def test_a_configuration_that_is_wrong_is_bad_input(self):
        checks = self.doctor("--config", self.config('usb = "2639"'), status=2)
        self.assertIn("'usb'", checks["configuration"]["text"])

    def test_a_damaged_database_is_the_gravest_of_failures(self):
        self.assertEqual(self.doctor()["database"]["finding"], "ok")
        database = self.data / "station.db"
        damaged = bytearray(database.read_bytes())
        damaged[4096:8192] = b"\xA5" * 4096
        database.write_bytes(damaged)
        checks = self.doctor("--config", self.config('device = "/dev/no-such-port"'), status=4)
        self.assertEqual(checks["database"]["finding"], "failed")

    def test_text_has_a_line_for_each_check(self):
        done = self.soak("doctor")
        self.assertRegex(done.stdout, r"(?m)^ok +database: ")


if __name__ == "__main__":
    unittest.main()
