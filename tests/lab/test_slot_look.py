# SPDX-License-Identifier: Apache-2.0
"""A station without a campaign looks into its slots: which unit each holds, and what is said of those that do not tell."""
import functools
import json
import operator
import re
import socket
import sys
import unittest
import urllib.error
import urllib.request
from concurrent.futures import ThreadPoolExecutor

import bench
from bench import ROOT, WAIT_S, LabTest, long_test, short_procedure
from fault_proxy import FaultProxy

sys.path.insert(0, str(ROOT / "tests" / "web"))
from browser import BROWSER, DRIVER, Browser  # noqa: E402

# As the units of three families tell it: the device identifications 0380A001, 0380A002, 0380A003.
SERIALS = ("0380A001", "58761218", "0058761219")
# What a unit that is broken, or meant to do harm, may send for one; a line of its protocol has 256 bytes.
MARKUP = "<img src=x onerror=document.title=1>"
LONG = "8" * 220
CONTACTS = 16  # register of the relay card that shows the first one


class WithSlots(LabTest):
    def give_power(self, *outputs):
        """As somebody at a switch of the laboratory's own would: soakd has no part in it."""
        relays = self.modbus("relay")
        for number, state in enumerate(outputs):
            self.assertFalse(relays.write_register(number, state, 1).isError())

    def outputs(self, count):
        return self.modbus("relay").read_holding_registers(CONTACTS, count, 1).registers

    def post(self, command, **body):
        request = urllib.request.Request(f"{self.lab.page}api/v1/campaign/{command}", json.dumps(body).encode(),
                                         {"Content-Type": "application/json"})
        with urllib.request.urlopen(request, timeout=60) as answer:
            return json.load(answer)

    def look(self):
        document = self.post("look", user="Eva")
        self.check_schema(document, "http-campaign-look")
        return document["slots"]

    def refusal(self, command, **body):
        """(status, where, message) of a command that must be refused."""
        with self.assertRaises(urllib.error.HTTPError) as refused:
            self.post(command, **body)
        error = json.load(refused.exception)["error"]
        return refused.exception.code, error["where"], error["message"]

    def turn(self):
        """How often the engine has turned so far, as far as it shows."""
        with urllib.request.urlopen(self.lab.page + "api/v1/alive", timeout=30) as answer:
            return json.load(answer)["turn"]


class Impostor(FaultProxy):
    """A wire to a VectorNav unit that hands on another serial number (register 3; the check is the exclusive or of the line's bytes)."""

    def __init__(self, target, serial):
        self.serial = serial
        super().__init__(target)

    def _line(self, _):
        line = b"VNRRG,03," + self.serial
        return b"$%s*%02X\r\n" % (line, functools.reduce(operator.xor, line))

    def change(self, data):
        return re.sub(rb"\$VNRRG,03,[^\n]*\n", self._line, data)


class WithImpostors(WithSlots):
    def start_lab_with(self, *serials):
        """A laboratory of VectorNav units that say they have those serial numbers."""
        def put_impostors(text):
            for port, serial in zip(self.lab.ports["units"], serials, strict=True):
                proxy = Impostor(port, serial)
                self.addCleanup(proxy.close)
                text = re.sub(rf"^port = {port}$", f"port = {proxy.port}", text, flags=re.M)
            return text
        self.start_lab(units=len(serials), soaksim_options=["--decoder", *["vectornav"] * len(serials)], edit=put_impostors)
        self.give_power(*[1] * len(serials))


class Look(WithImpostors):
    def test_units_of_three_families_say_who_they_are_and_nothing_is_switched(self):
        self.start_lab(units=3, soaksim_options=["--decoder", "xsens", "ahrs400", "vectornav"])
        self.give_power(1, 1, 1)
        slots = self.look()
        self.assertEqual([(slot["slot"], slot["answer"], slot["serial"]) for slot in slots],
                         [(str(n), "identified", serial) for n, serial in enumerate(SERIALS, 1)])
        for slot in slots:
            self.assertIn("SIMULATED", slot["product"])
        self.assertEqual(self.outputs(3), [1, 1, 1])
        self.assert_event("unit", "slots", "slot 1", *SERIALS)
        self.assertEqual(self.query("SELECT DISTINCT user FROM event WHERE subject = 'slots'"), [("Eva",)])
        # The links are free again.
        self.assertEqual(self.look(), slots)

    def test_slots_that_do_not_tell_say_why(self):
        def speak_otherwise(text):
            before, third = text.split('name = "3"')
            return before + 'name = "3"' + third.replace('decoder = "xsens"', 'decoder = "vectornav"', 1)
        self.start_lab(units=4, cut=["unit4"], edit=speak_otherwise)
        self.proxies["unit4"].cut()
        self.give_power(1, 0, 1, 1)
        one, off, other, gone = self.look()
        self.assertEqual((one["answer"], one["serial"]), ("identified", "0380A001"))
        self.assertEqual((off["answer"], off["power_output"], off["trouble"]), ("silent", 2, None))
        self.assertEqual((other["answer"], other["serial"]), ("anonymous", None))
        self.assertEqual(gone["answer"], "failed")
        self.assertIn("127.0.0.1", gone["trouble"])
        self.assertEqual(self.outputs(4), [1, 0, 1, 1])

    def test_a_serial_number_that_no_record_can_carry_is_none(self):
        self.start_lab_with(MARKUP.encode(), b"a\x07\x1b[2Jb", b"\xff\xfe", LONG.encode())
        markup, control, bytes_, long = self.look()
        self.assertEqual((markup["answer"], markup["serial"]), ("identified", MARKUP))
        self.assertEqual((long["answer"], long["serial"]), ("identified", LONG))
        for slot in (control, bytes_):
            self.assertEqual((slot["answer"], slot["serial"]), ("anonymous", None))
            self.assertIn("serial number", slot["trouble"])
        log = json.dumps([text for _, subject, text in self.events() if subject == "slots"])
        self.assertNotRegex(log, r"\\u00[01]")

    @long_test
    def test_while_it_looks_the_engine_turns_and_no_campaign_begins(self):
        with socket.create_server(("127.0.0.1", 0)) as mute:
            port = mute.getsockname()[1]
            self.start_lab(edit=lambda text: text.replace(f"port = {self.lab.ports['units'][0]}\n", f"port = {port}\n"))
            mute.settimeout(WAIT_S)
            with ThreadPoolExecutor(1) as beside:
                found = beside.submit(self.look)
                wire, _ = mute.accept()  # the look is under way, and lasts until it gives this unit up
                with wire:
                    before = self.turn()
                    while self.turn() == before:
                        self.assertFalse(found.done(), "the engine stood still as long as the look lasted")
                    for command, body in (("look", {}), ("start", {"procedure_text": short_procedure(), "campaign": "c"})):
                        status, where, message = self.refusal(command, **body)
                        self.assertEqual((status, where), (409, "state"))
                        self.assertIn("looking into the slots", message)
                    self.assertFalse(found.done())
                    self.assertEqual([slot["answer"] for slot in found.result()], ["silent"])
        self.assertEqual(self.status()["state"], "idle")

    def test_it_is_refused_while_a_campaign_is_under_way_and_works_after_it(self):
        self.start_lab(cut=["chamber"])
        self.start_campaign(short_procedure(set_points=(20,)))
        self.wait_for_step("record")
        status, where, message = self.refusal("look")
        self.assertEqual((status, where), (409, "state"))
        self.assertIn("'c'", message)
        self.post("pause")
        self.assertEqual(self.refusal("look")[:2], (409, "state"))
        self.proxies["chamber"].cut()
        self.post("abort", reason="test")
        self.assertEqual(self.status()["state"], "stopping", "a chamber that does not answer is not safe yet")
        status, where, message = self.refusal("look")
        self.assertEqual((status, where), (409, "state"))
        self.assertIn("'c' is stopping", message)
        self.proxies["chamber"].mend()
        self.assertEqual(self.wait_for_end()["state"], "aborted")
        self.give_power(1)
        self.assertEqual([slot["serial"] for slot in self.look()], ["0380A001"])


    @long_test
    def test_it_is_refused_before_a_campaign_begins_by_itself_and_works_while_the_queue_waits_for_somebody(self):
        self.start_lab(rate=100)  # the notice before the next campaign takes three seconds
        self.post("queue", procedure_text=short_procedure(set_points=(20,)), campaign="next", user="Eva")
        self.give_power(1)
        self.assertEqual([slot["answer"] for slot in self.look()], ["identified"])
        self.start_campaign(short_procedure(set_points=(20,)))
        status = self.wait("its end", lambda s: s["state"] == "finished" and s["queue"]["waits_for"] == "time", lab_s=1.0)
        self.assertEqual(status["queue"]["campaigns"][0]["name"], "next")
        status, where, message = self.refusal("look")
        self.assertEqual((status, where), (409, "state"))
        self.assertIn("about to begin by itself", message)
        self.post("abort", reason="the units are to be changed")
        self.assertEqual(self.status()["queue"]["waits_for"], "somebody")
        self.give_power(1)
        self.assertEqual([slot["serial"] for slot in self.look()], ["0380A001"])


@unittest.skipUnless(BROWSER and DRIVER, "skipped: chromium and chromedriver are not installed")
class OnThePage(WithImpostors):
    def setUp(self):
        super().setUp()
        self.browser = Browser()
        self.addCleanup(self.browser.close)

    def below(self, slot):
        return f"#start-slots > :nth-child({slot}) .found"

    def value(self, slot):
        return self.browser.run("return document.querySelector(`#start-slots [data-slot='${arguments[0]}']`).value", slot)

    def test_what_was_found_stands_below_each_field_and_a_click_takes_it(self):
        self.start_lab(units=3, edit=lambda text: text.replace('unit = "0380A002"', 'unit = "SN0099"'))
        self.give_power(1, 1, 0)
        self.browser.go(self.lab.page)
        self.browser.wait("return document.querySelectorAll('#start-slots input').length === 3")
        self.browser.click("#start-look")
        self.browser.wait_for_text(self.below(1), "✓ 0380A001")
        self.browser.wait_for_text(self.below(2), "✗ Holds 0380A002")
        self.browser.wait_for_text(self.below(3), "Output 3 feeds it, and is switched on only when a campaign starts.")
        self.assertIn("firmware", self.browser.text(self.below(1)))
        self.browser.run("document.querySelector(arguments[0]).scrollIntoView({block: 'center'})", self.below(2))
        self.browser.click(self.below(2) + " button")
        self.browser.wait_for_text(self.below(2), "✓ 0380A002")
        self.assertEqual(self.value(2), "0380A002")
        # What is typed afterwards is judged by what was found.
        self.browser.type("#start-slots [data-slot='1']", "X")
        self.browser.wait_for_text(self.below(1), "✗ Holds 0380A001")
        for width in (320, 390, 1280):
            self.browser.resize(width, 900)
            self.assertLessEqual(self.browser.run("return document.documentElement.scrollWidth"), width)
        self.assertEqual(self.browser.console(), [])

    def test_a_serial_number_that_is_meant_to_do_harm_is_text(self):
        self.start_lab_with(MARKUP.encode(), LONG.encode(), b"a\x07b")
        self.browser.go(self.lab.page)
        self.browser.wait("return document.querySelectorAll('#start-slots input').length === 3")
        for slot in (1, 2, 3):
            self.browser.run("const field = document.querySelector(`#start-slots [data-slot='${arguments[0]}']`); field.value = '';", slot)
        self.browser.click("#start-look")
        self.browser.wait_for_text(self.below(1), MARKUP)
        self.browser.wait_for_text(self.below(3), "does not say who it is")
        for slot, serial in ((1, MARKUP), (2, LONG)):
            self.browser.run("document.querySelector(arguments[0]).click()", self.below(slot) + " button")
            self.browser.wait_for_text(self.below(slot), f"✓ {serial}")
            self.assertEqual(self.value(slot), serial)
        self.assertEqual(self.browser.run("return [document.title, document.querySelectorAll('main img').length]"), ["Soak", 0])
        for width in (320, 390, 1280):
            self.browser.resize(width, 900)
            self.assertLessEqual(self.browser.run("return document.documentElement.scrollWidth"), width)
        self.assertEqual(self.browser.console(), [])


if __name__ == "__main__":
    bench.main()
