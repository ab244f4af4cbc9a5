# SPDX-License-Identifier: Apache-2.0
"""The first start of a station: what a real `soakd` without a configuration answers to whoever sets it up is as docs/openapi.yaml says;
then it goes on with what was written. On the page: test_setup_page.py."""
import concurrent.futures
import contextlib
import json
import os
import pathlib
import socket
import sqlite3
import subprocess
import sys
import tempfile
import tomllib
import unittest
from unittest import mock

import jsonschema

from new_station import PATIENCE_S, ROOT, NewStation, bin_folder
from test_openapi import EVERY, SETUP, body_of, check, parameters_of, resolved, wrong_values

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "cli"))
from soak_cli import check_schema  # noqa: E402

OBJECTS = {"chamber", "fixture", "power", "purge", "site", "room", "mail", "webhook"}
HOSTILE = 'ttyUSB0"\nlisten = "0.0.0.0:1'


def form(**more):
    """What a station is set up with: devices at which nobody answers."""
    return {"chamber": {"map": "watlow-f4t.toml", "host": "127.0.0.1", "port": 5020}, "unit_type": "mti-300", "decoder": "xsens",
            "slots": [{"name": "1", "host": "127.0.0.1", "port": 4001}, {"name": "2", "device": "/dev/ttyUSB7", "unit": "SN2"}], **more}


@contextlib.contextmanager
def peers():
    """A mail server and a webhook: (ports, lines of what they got)."""
    with subprocess.Popen([sys.executable, "-B", pathlib.Path(__file__).with_name("alarm_peers.py")], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
        yield json.loads(process.stdout.readline()), process.stdout
        process.stdin.close()


class WithStation(unittest.TestCase):
    def setUp(self):
        self.station = NewStation()
        self.addCleanup(self.station.close)

    def checked(self, body):
        """(text, {field: message}) of a form."""
        status, document = self.station.ask("setup/check", body)
        self.assertEqual(status, 200, document)
        check_schema(document, "http-setup-check")
        fields = [mistake["field"] for mistake in document["mistakes"]]
        self.assertEqual(len(fields), len(set(fields)), document)
        return document["text"], {mistake["field"]: mistake["message"] for mistake in document["mistakes"]}

    def refused(self, path, body):
        """(status, where, message)"""
        status, document = self.station.ask(path, body)
        self.assertGreaterEqual(status, 400, document)
        return status, document["error"]["where"], document["error"]["message"]


class Interface(WithStation):
    def test_it_offers_what_soak_comes_with(self):
        status, document = self.station.ask("setup")
        self.assertEqual(status, 200)
        check_schema(document, "http-setup")
        self.assertEqual(document["file"], str(self.station.file))
        for kind in ("chambers", "fixtures"):
            self.assertEqual([one["file"] for one in document[kind]], sorted(path.name for path in (ROOT / "procedures" / kind).glob("*.toml")))
        self.assertIn("mti-300", [one["name"] for one in document["types"]])
        ports = {one["file"]: (one["protocol"], one["port"]) for one in document["chambers"]}
        self.assertEqual((ports["watlow-f4t.toml"], ports["thermotron-8800.toml"]), (("modbus", 502), ("text", 8888)))

    def test_a_form_without_a_mistake_is_the_configuration(self):
        fixture = {"map": "modbus-positioner.toml", "device": "/dev/ttyS9", "baud": 19200, "parity": "E", "stop_bits": 2, "unit": 7}
        mail = {"host": "smtp.lab.example", "security": "none", "from": "soak@lab.example", "to": ["eva@lab.example", "otto@lab.example"]}
        site = {"latitude_deg": 48.14, "height_m": 520, "gravity_mps2": 9.8073}
        room = {"temp_c": 22.5, "dew_point_c": 11}
        power = {"map": "modbus-relay.toml", "host": "127.0.0.1", "port": 5021}
        slots = form()["slots"]
        slots[0] |= {"power_output": 1, "supply_v": 12.5, "supply_limit_a": 0.5}
        text, mistakes = self.checked(form(fixture=fixture, mail=mail, site=site, room=room, power=power, purge={"below_c": 5}, slots=slots))
        self.assertEqual(mistakes, {})
        config = tomllib.loads(text)
        maps = ROOT / "procedures"
        self.assertEqual(config, {
            "chamber": {"map": str(maps / "chambers/watlow-f4t.toml"), "host": "127.0.0.1", "port": 5020},
            "fixture": {**fixture, "map": str(maps / "fixtures/modbus-positioner.toml")}, "power": {**power, "map": str(maps / "power/modbus-relay.toml")}, "purge": {"below_c": 5}, "site": site, "room": room, "alarms": {"mail": mail},
            "slot": [{"name": "1", "host": "127.0.0.1", "port": 4001, "decoder": "xsens", "unit_type": "mti-300", "power_output": 1, "supply_v": 12.5, "supply_limit_a": 0.5},
                     {"name": "2", "device": "/dev/ttyUSB7", "decoder": "xsens", "unit": "SN2", "unit_type": "mti-300"}]})
        for switch in ({"from": "chamber"}, {"usb_hubs": ["1-4", "1-4.3"]}):
            text, mistakes = self.checked(form(power=switch))
            self.assertEqual((mistakes, tomllib.loads(text)["power"]), ({}, switch))

    def test_what_switches_the_units_is_checked_like_the_rest(self):
        for power, field in (({}, "power.map"), ({"from": "here"}, "power.from"), ({"usb_hubs": []}, "power.usb_hubs"), ({"usb_hubs": ["left"]}, "power.usb_hubs")):
            self.assertIn(field, self.checked(form(power=power))[1])
        slots = [{"name": "1", "host": "127.0.0.1", "port": 4001, "power_output": 1}]
        self.assertIn("[power]", self.checked(form(slots=slots))[1]["slots.0.power_output"])
        self.assertEqual(self.refused("setup/look", form(slots=[{"name": "1", "host": "127.0.0.1", "port": 5021}], power={"map": "modbus-relay.toml", "host": "127.0.0.1", "port": 5021}))[:2],
                         (400, "slots.0.port"))

    def test_secrets_go_to_files_of_their_own_and_nowhere_else(self):
        secrets = {"mail.password": "correct horse", "webhook.url": "https://127.0.0.1:9/hooks/s3cret", "webhook.token": "t0ken"}
        mail = {"host": "127.0.0.1", "security": "tls", "port": 9, "from": "soak@lab.example", "to": ["eva@lab.example"], "user": "soak", "password": secrets["mail.password"]}
        webhook = {"url": secrets["webhook.url"], "token": secrets["webhook.token"]}
        said = []
        for path in ("setup/check", "setup/tell", "setup/write"):
            parts = {"mail": mail, "webhook": webhook, "user": "Eva"}
            status, document = self.station.ask(path, parts if path == "setup/tell" else form(**parts))
            self.assertEqual(status, 200, document)
            said.append(str(document))
        self.station.process.stdout.readline()
        config = tomllib.loads(self.station.file.read_text(encoding="utf-8"))["alarms"]
        self.assertEqual((config["mail"]["password_file"], config["webhook"]), ("mail.password", {"url_file": "webhook.url", "token_file": "webhook.token"}))
        self.assertEqual([(way["way"], way["to"]) for way in self.station.ask("alarms")[1]["ways"]], [("mail", "eva@lab.example"), ("webhook", "127.0.0.1")])
        for file, secret in secrets.items():
            path = self.station.data / file
            self.assertEqual((path.read_text(encoding="utf-8"), path.stat().st_mode & 0o777), (secret + "\n", 0o600))
            for where in (*said, self.station.said(), self.station.file.read_text(encoding="utf-8"), str(self.station.events())):
                self.assertNotIn(secret, where)

    def test_a_secret_that_lacks_its_other_half_is_told_at_its_field(self):
        mail = {"host": "smtp.lab.example", "security": "none", "from": "soak@lab.example", "to": ["eva@lab.example"]}
        for more, fields in (({"user": "soak"}, {"mail.password", "mail.security"}), ({"password": "x"}, {"mail.user"}), ({"user": "soak", "password": "x"}, {"mail.security"})):
            self.assertLessEqual(fields, set(self.checked(form(mail=mail | more))[1]), more)
        for webhook, message in (({}, "nothing is entered"), ({"url": "chat.example"}, "must be an address"), ({"url": "http://chat.example/", "token": "t"}, "https://")):
            self.assertIn(message, self.checked(form(webhook=webhook))[1]["webhook.url"])
        status, where, message = self.refused("setup/check", form(mail=mail | {"password": "pass\nword"}))
        self.assertEqual((status, where, "word" in message.replace("a password", "")), (400, "mail.password", False))

    def test_a_test_says_what_became_of_each_way(self):
        self.assertEqual(self.refused("setup/tell", {})[:2], (400, "mail"))
        with peers() as (ports, lines):
            mail = {"host": "127.0.0.1", "security": "none", "port": ports["mail"], "from": "soak@lab.example", "to": ["eva@lab.example"]}
            for path, trouble in (("hook", None), ("refuses", "the server answers 404")):
                status, document = self.station.ask("setup/tell", {"mail": mail, "webhook": {"url": f"http://127.0.0.1:{ports['webhook']}/{path}", "token": "t0ken"}, "user": "Eva"})
                self.assertEqual(status, 200, document)
                check_schema(document, "alarm-send")
                self.assertEqual(document["ways"], [{"way": "mail", "to": "eva@lab.example", "trouble": None}, {"way": "webhook", "to": "127.0.0.1", "trouble": trouble}])
            told = json.loads(lines.readline()), json.loads(lines.readline())
        self.assertEqual({one["kind"] for one in told}, {"mail", "webhook"})
        self.assertIn("A test by Eva", str(told))

    def test_each_mistake_is_told_at_its_field_once(self):
        _, mistakes = self.checked({})
        self.assertLessEqual({"chamber.map", "chamber.host", "unit_type"}, set(mistakes))
        slots = [{"name": "", "host": "", "unit": "SN1"}, {"name": "2", "host": "127.0.0.1", "port": 99999}, {"name": "3", "device": "/dev/ttyUSB7", "baud": 1},
                 {"name": "2", "device": "/dev/ttyUSB8"}]
        _, mistakes = self.checked(form(slots=slots, decoder="morse", unit_type="no such", chamber={"map": "watlow-f4t.toml", "device": "/dev/ttyUSB9", "baud": 1234, "parity": "X"},
                                        mail={"host": "a b", "security": "none", "from": "nobody", "to": []}))
        self.assertEqual(set(mistakes), {"chamber.baud", "chamber.parity", "slots.0.name", "slots.0.host", "slots.0.port", "slots.1.port", "slots.2.baud", "slots.3.name",
                                         "decoder", "unit_type", "mail.host", "mail.from", "mail.to"})
        self.assertIn("9600", mistakes["chamber.baud"])
        _, mistakes = self.checked(form(slots=[{"name": "1", "device": "/dev/ttyUSB7"}], chamber={"map": "watlow-f4t.toml", "device": "/dev/ttyUSB7"}))
        self.assertIn("chamber", mistakes["slots.0"])
        _, mistakes = self.checked(form(slots=[{"name": "1", "host": "127.0.0.1", "port": 1502}], chamber={"map": "watlow-f4t.toml", "host": "127.0.0.1", "port": 1502}))
        self.assertIn("chamber", mistakes["slots.0"])

    def test_a_hostile_value_makes_no_key(self):
        for path in ("setup/check", "setup/write"):
            for field, body in (("slots.0.device", form(slots=[{"name": "1", "device": HOSTILE}])), ("chamber.host", form(chamber={"map": "watlow-f4t.toml", "host": HOSTILE})),
                                ("slots.0.unit", form(slots=[{"name": "1", "device": "/dev/a", "unit": HOSTILE}])), ("mail.to", form(mail={"to": [HOSTILE]}))):
                self.assertEqual(self.refused(path, body)[:2], (400, field))
        name = 'a" ]\\ # [tls] \\u0022 = \'x\''
        text, mistakes = self.checked(form(slots=[{"name": name, "device": f"/dev/{name}"}]))
        self.assertEqual(mistakes, {})
        config = tomllib.loads(text)
        self.assertEqual((set(config), config["slot"][0]["name"], config["slot"][0]["device"]), ({"chamber", "slot"}, name, f"/dev/{name}"))
        for outside in ("../units/mti-300.toml", "/etc/passwd", "chambers/watlow-f4t.toml", "."):
            self.assertEqual(self.refused("setup/check", form(chamber={"map": outside, "host": "a"}))[:2], (400, "chamber.map"))
        self.assertFalse(self.station.file.exists())

    def test_a_wrong_form_is_not_written(self):
        self.assertEqual(self.refused("setup/write", form(unit_type=""))[:2], (400, "unit_type"))
        self.assertFalse(self.station.file.exists())

    def test_a_file_that_is_there_by_then_is_not_written_over(self):
        self.station.file.write_text("# of somebody else\n", encoding="utf-8")
        status, where, message = self.refused("setup/write", form(user="Eva"))
        self.assertEqual((status, where), (409, "state"))
        self.assertIn(str(self.station.file), message)
        self.assertEqual(self.station.file.read_text(encoding="utf-8"), "# of somebody else\n")
        self.assertEqual(sorted(path.name for path in self.station.data.iterdir() if "station.toml" in path.name), ["station.toml"])
        self.assertEqual(self.station.events(), [])

    def test_it_goes_on_with_a_file_that_is_there_by_then_if_it_is_sound(self):
        self.assertEqual(self.refused("setup/use", {})[:2], (409, "state"))
        text, _ = self.checked(form())
        self.station.file.write_text("[chamber]\n", encoding="utf-8")
        status, where, message = self.refused("setup/use", {})
        self.assertEqual((status, where), (400, str(self.station.file)), message)
        self.station.file.write_text(text, encoding="utf-8")
        status, document = self.station.ask("setup/use", {"user": "Eva"})
        self.assertEqual(status, 200, document)
        check_schema(document, "http-setup-write")
        self.station.process.stdout.readline()
        self.assertEqual([slot["name"] for slot in self.station.ask("stored")[1]["slots"]], ["1", "2"])
        self.assertEqual([(event["kind"], event["user"]) for event in self.station.events()], [("station_set_up", "Eva")])

    def test_no_unit_is_looked_for_at_the_port_of_chamber_or_fixture(self):
        port = self.station.folder / "port"
        other = self.station.folder / "by-id"
        port.touch()
        other.symlink_to(port)
        devices = {"chamber": {"map": "watlow-f4t.toml", "device": str(port)}, "fixture": {"map": "modbus-positioner.toml", "device": str(port)}}
        for section, controller in devices.items():
            body = form(**{section: controller}, slots=[{"name": "1", "host": "127.0.0.1", "port": 4001}, {"name": "2", "device": str(other)}])
            status, where, message = self.refused("setup/look", body)
            self.assertEqual((status, where), (400, "slots.1.device"))
            self.assertIn(section, message)
        devices = {"chamber": {"map": "watlow-f4t.toml", "host": "127.0.0.1"}, "fixture": {"map": "modbus-positioner.toml", "host": "127.0.0.1", "port": 502}}
        for section, controller in devices.items():
            status, where, message = self.refused("setup/look", form(**{section: controller}, slots=[{"name": "1", "host": "127.0.0.1", "port": 502}]))
            self.assertEqual((status, where), (400, "slots.0.port"))
            self.assertIn(section, message)

    def test_while_a_device_is_asked_no_other_question_waits_for_it(self):
        with socket.socket() as silent:
            silent.bind(("127.0.0.1", 0))
            silent.listen()
            slots = [{"name": "1", "host": "127.0.0.1", "port": silent.getsockname()[1]}]
            with concurrent.futures.ThreadPoolExecutor() as pool:
                look = pool.submit(self.station.ask, "setup/look", form(slots=slots))
                silent.settimeout(60)
                wire, _ = silent.accept()
                with wire:
                    for path, body in (("setup/look", form(slots=slots)), ("setup/try", {"section": "chamber", "chamber": form()["chamber"]})):
                        self.assertEqual(self.refused(path, body)[:2], (409, "state"))
                    self.assertEqual(look.result()[0], 200)

    def test_maps_come_from_the_procedures_wherever_the_types_are(self):
        self.station.stop()
        with mock.patch.dict(os.environ, {"SOAK_UNIT_TYPES": str(self.station.folder)}):
            self.station.start()
        names = [one["file"] for one in self.station.ask("setup")[1]["chambers"]]
        self.assertIn("watlow-f4t.toml", names)

    def test_pages_of_others_are_kept_out_and_nothing_else_of_the_interface_is_there(self):
        for headers in ({"Host": "evil.example"}, {"Origin": "https://evil.example"}):
            for path, body in (("setup", None), ("setup/write", form())):
                status, _ = self.station.ask(path, body, **headers)
                self.assertEqual(status, 403, headers)
        self.assertEqual(self.station.ask("setup/write", form(), **{"Content-Type": "text/plain"})[0], 415)
        for method, path in EVERY:
            if path.startswith("/api/") and (method, path) not in SETUP:
                self.assertEqual(self.station.ask(path.removeprefix("/api/v1/"), {} if method == "POST" else None)[0], 404, path)
        self.assertFalse(self.station.file.exists())

    def test_what_the_document_of_the_interface_does_not_allow_is_refused_by_name(self):
        for method, path in SETUP:
            operation = EVERY[method, path]
            if method == "GET":
                self.assertEqual(parameters_of(operation), {})
                self.assertEqual(self.station.ask("setup?no_such=1")[0], 400)
                continue
            schema = resolved(body_of(operation))
            parts = {"": schema, **{name: resolved(schema["properties"][name]) for name in OBJECTS & set(schema["properties"])}}
            for place, part in parts.items():
                for name, member in [*part["properties"].items(), ("no_such", {})]:
                    wrong = ["x"] if name in OBJECTS else [1] if name == "no_such" else wrong_values(resolved(member))
                    for value in wrong:
                        section = next((one for one in (place, name) if one in ("chamber", "fixture", "power")), "chamber")
                        body = {"section": section, section: {"host": "a"}} if path.endswith("try") else {}
                        body |= {place: {**({} if place in ("site", "room", "purge", "webhook") else {"host": "a"}), name: value}} if place else {name: value}
                        where = f"{place}.{name}" if place else name
                        with self.subTest(path=path, where=where, value=value):
                            self.assertRaises(jsonschema.ValidationError, check, body, schema)
                            self.assertEqual(self.refused(path.removeprefix("/api/v1/"), body)[:2], (400, where))


class Start(unittest.TestCase):
    def test_it_goes_on_with_what_was_written_and_so_does_the_next_start(self):
        station = NewStation()
        self.addCleanup(station.close)
        self.assertIn(str(station.file), station.said())
        status, document = station.ask("setup/write", form(user="Eva"))
        self.assertEqual(status, 200, document)
        check_schema(document, "http-setup-write")
        self.assertEqual(station.process.stdout.readline().strip(), station.url)
        self.assertEqual([slot["name"] for slot in station.ask("stored")[1]["slots"]], ["1", "2"])
        [event] = station.events()
        self.assertEqual((event["kind"], event["subject"], event["user"]), ("station_set_up", str(station.file), "Eva"))
        self.assertEqual(station.stop(), 0)
        station.start()
        self.assertEqual(station.ask("status")[0], 200)

    def test_the_manager_of_services_is_told_that_it_waits_to_be_set_up(self):
        with tempfile.TemporaryDirectory() as folder, socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as manager:
            manager.bind(f"{folder}/notify")
            manager.settimeout(60)
            with mock.patch.dict(os.environ, {"NOTIFY_SOCKET": f"{folder}/notify"}):
                station = NewStation()
            self.addCleanup(station.close)
            message = manager.recv(4096).decode()
            self.assertIn("READY=1", message)
            self.assertIn(f"not set up yet: {station.url}", message)
            self.assertEqual(station.ask("setup/write", form())[0], 200)
            self.assertIn("STATUS=serving", manager.recv(4096).decode())

    def test_it_ends_when_it_is_asked_to(self):
        station = NewStation()
        self.addCleanup(station.close)
        self.assertEqual(station.stop(), 0)
        self.assertFalse(station.file.exists())

    def test_an_end_that_is_asked_for_while_the_file_is_written_is_not_lost(self):
        station = NewStation()
        self.addCleanup(station.close)
        station.process.terminate()
        with contextlib.suppress(OSError):  # it may have ended by then
            station.ask("setup/write", form())
        self.assertEqual(station.process.wait(PATIENCE_S), 0)
        station.process.stdout.close()

    def test_the_template_of_the_package_counts_as_none_and_stays_as_it_is(self):
        soakd = pathlib.Path(bin_folder()) / "soakd"
        text = subprocess.run([soakd, "--write-config"], capture_output=True, text=True, check=True).stdout
        station = NewStation()
        self.addCleanup(station.close)
        station.stop()
        template = station.folder / "etc-station.toml"
        template.write_text(text, encoding="utf-8")
        station.start("--config", template)
        self.assertEqual(station.ask("setup")[1]["file"], str(station.file))
        self.assertEqual(station.ask("setup/write", form())[0], 200)
        station.process.stdout.readline()
        station.stop()
        self.assertEqual(template.read_text(encoding="utf-8"), text)
        station.start("--config", template)
        self.assertEqual(station.ask("status")[0], 200)
        # Once somebody has edited it, it is the configuration.
        station.stop()
        template.write_text(text.replace("[[slot]]", "[[slots]]"), encoding="utf-8")
        done = subprocess.run([soakd, "--config", template, "--data", station.data], capture_output=True, text=True, timeout=60)
        self.assertEqual(done.returncode, 2)
        self.assertIn("slots", done.stderr)

    def test_the_template_is_known_whatever_its_comments_and_the_folder_of_its_maps(self):
        soakd = pathlib.Path(bin_folder()) / "soakd"
        station = NewStation()
        self.addCleanup(station.close)
        station.stop()
        template = station.folder / "etc-station.toml"
        for variable, value in (("SOAK_PROCEDURES", str(station.folder)), ("SOAK_UNIT_TYPES", "/elsewhere/units")):
            with mock.patch.dict(os.environ, {variable: value}):
                text = subprocess.run([soakd, "--write-config"], capture_output=True, text=True, check=True).stdout
            template.write_text("# of an older version\n" + text.replace("# listen", "# once listen"), encoding="utf-8")
            station.start("--config", template)
            self.assertEqual(station.ask("setup")[1]["file"], str(station.file))
            station.stop()
        for before, after in (("# listen", "listen"), ('"192.168.7.20"', '"192.168.7.21"'), ("watlow-f4t", "no-such")):
            edited = text.replace(before, after, 1)
            self.assertNotEqual(edited, text)
            # No controller answers there, whatever stands in the laboratory's network.
            template.write_text(edited.replace("192.168.7.2", "127.0.0.2"), encoding="utf-8")
            done = subprocess.run([pathlib.Path(bin_folder()) / "soak", "chamber", "make-safe", "--config", template, "--data", station.data], capture_output=True, text=True, timeout=120)
            self.assertNotIn("template", done.stderr)

    def test_a_command_with_the_template_says_so_and_where_it_has_looked(self):
        station = NewStation()
        self.addCleanup(station.close)
        template = station.folder / "etc-station.toml"
        template.write_text(subprocess.run([pathlib.Path(bin_folder()) / "soakd", "--write-config"], capture_output=True, text=True, check=True).stdout, encoding="utf-8")
        if os.path.lexists("/var/lib/soak/station.toml"):
            self.skipTest("skipped: this machine has a station of its own, which the commands would find")
        with mock.patch.dict(os.environ, {"SOAK_DATA": str(station.data)}):
            for command in (["chamber", "make-safe"], ["alarm", "send", "a test"]):
                done = subprocess.run([pathlib.Path(bin_folder()) / "soak", *command, "--config", template], capture_output=True, text=True, timeout=60)
                self.assertEqual(done.returncode, 2)
                for part in (f"{template} is still the template", f"{station.data} and /var/lib/soak"):
                    self.assertIn(part, done.stderr)

    def test_a_station_with_an_open_campaign_that_has_lost_its_file_is_not_set_up_anew(self):
        station = NewStation()
        self.addCleanup(station.close)
        station.stop()
        with contextlib.closing(sqlite3.connect(station.data / "station.db")) as catalog, catalog:
            catalog.create_function("soak_seal", -1, lambda seal, *_: seal)
            catalog.execute("INSERT INTO campaign (name, procedure) VALUES ('hot', 'p')")
            catalog.execute("INSERT INTO journal (campaign, document, state, reason, created_utc_s, updated_utc_s) VALUES ('hot', '{}', 'running', '', 1, 1)")
        for state in ("running", "interrupted"):
            with contextlib.closing(sqlite3.connect(station.data / "station.db")) as catalog, catalog:
                catalog.create_function("soak_seal", -1, lambda seal, *_: seal)
                catalog.execute("UPDATE journal SET state = ?", (state,))
            done = subprocess.run([pathlib.Path(bin_folder()) / "soakd", "--data", station.data, "--listen", "127.0.0.1:0"], capture_output=True, text=True, timeout=60)
            self.assertEqual((done.returncode, done.stdout), (2, ""), state)
            self.assertIn("'hot'", done.stderr)
            self.assertIn(str(station.file), done.stderr)

    def test_others_than_this_machine_cannot_set_it_up(self):
        station = NewStation()
        self.addCleanup(station.close)
        station.stop()
        done = subprocess.run([pathlib.Path(bin_folder()) / "soakd", "--data", station.data, "--listen", "0.0.0.0:0"], capture_output=True, text=True, timeout=60)
        self.assertEqual((done.returncode, done.stdout), (2, ""))
        self.assertIn("not set up", done.stderr)


if __name__ == "__main__":
    unittest.main()
