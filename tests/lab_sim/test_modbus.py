# SPDX-License-Identifier: Apache-2.0
"""Chamber, fixture and relay of soaksim as other people's Modbus programs see them: mbpoll and pymodbus."""
import re
import socket
import struct
import subprocess
import unittest

from pymodbus.client import ModbusTcpClient
from pymodbus.constants import Endian
from pymodbus.payload import BinaryPayloadBuilder, BinaryPayloadDecoder

from laboratory import PATIENCE_S, LaboratoryTest, modbus_request, wait_for

ILLEGAL_FUNCTION, ILLEGAL_ADDRESS, ILLEGAL_VALUE = 1, 2, 3

# Watlow F4T, data map 1.
ALARM_HIGH, ALARM_STATE, MODE, SET_POINT, RAMP_ACTION = 1334, 1356, 2730, 2782, 2794
POWER, WORKING_SET_POINT, ACTUAL_MODE, PROCESS_VALUE, UNITS, STATUS = 2808, 2810, 2814, 2820, 6730, 90
OFF, AUTO, NONE = 62, 10, 61


class ModbusTest(LaboratoryTest):
    def client(self, device="chamber"):
        client = ModbusTcpClient("127.0.0.1", port=self.lab.addresses[device], timeout=PATIENCE_S)
        self.assertTrue(client.connect())
        self.addCleanup(client.close)
        return client

    def value(self, client, address):
        answer = client.read_holding_registers(address, 2, slave=1)
        self.assertFalse(answer.isError(), answer)
        return BinaryPayloadDecoder.fromRegisters(answer.registers, Endian.Big, Endian.Little).decode_32bit_float()

    def number(self, client, address):
        answer = client.read_holding_registers(address, 1, slave=1)
        self.assertFalse(answer.isError(), answer)
        return answer.registers[0]

    @staticmethod
    def set_value(client, address, value):
        builder = BinaryPayloadBuilder(byteorder=Endian.Big, wordorder=Endian.Little)
        builder.add_32bit_float(value)
        return client.write_registers(address, builder.to_registers(), slave=1)

    def write(self, client, address, value):
        answer = client.write_register(address, value, slave=1)
        self.assertFalse(answer.isError(), answer)

    def assert_exception(self, answer, code):
        self.assertTrue(answer.isError(), answer)
        self.assertEqual(answer.exception_code, code)


class PymodbusTest(ModbusTest):
    OPTIONS = ("--units", 1, "--rate", 200)

    def setUp(self):
        client = self.client()
        self.write(client, MODE, OFF)
        self.assertFalse(self.set_value(client, ALARM_HIGH, 90.0).isError())
        wait_for(lambda: self.number(client, ALARM_STATE) == NONE, "the alarm is cleared")

    def test_chamber_identifies_itself(self):
        client = self.client()
        self.assertEqual(self.number(client, UNITS), 15)
        self.assertEqual(self.number(client, STATUS), 138)
        part = client.read_holding_registers(16, 15, slave=1).registers
        self.assertTrue("".join(map(chr, part)).startswith("F4T"))

    def test_chamber_goes_where_it_is_sent_and_shows_no_power_when_off(self):
        client = self.client()
        self.assertFalse(self.set_value(client, SET_POINT, 60.0).isError())
        self.assertEqual(self.value(client, SET_POINT), 60.0)
        self.write(client, MODE, AUTO)
        self.assertEqual(self.number(client, ACTUAL_MODE), AUTO)
        self.assertEqual(self.value(client, WORKING_SET_POINT), 60.0)
        wait_for(lambda: self.value(client, PROCESS_VALUE) > 50.0, "the air is above 50 °C")
        self.assertGreater(self.value(client, POWER), 0.0)
        self.write(client, MODE, OFF)
        self.assertEqual(self.number(client, ACTUAL_MODE), OFF)
        self.assertEqual(self.value(client, POWER), 0.0)
        self.assertEqual(self.value(client, SET_POINT), 60.0)
        warm = self.value(client, PROCESS_VALUE)
        wait_for(lambda: self.value(client, PROCESS_VALUE) < warm - 5.0, "the air cools")
        self.assertEqual(self.value(client, POWER), 0.0)

    def test_alarm_is_latched(self):
        client = self.client()
        self.write(client, MODE, AUTO)
        self.assertFalse(self.set_value(client, ALARM_HIGH, 5.0).isError())
        wait_for(lambda: self.number(client, ALARM_STATE) not in (NONE, 88, 12), "the alarm is raised")
        self.assertFalse(self.set_value(client, ALARM_HIGH, 90.0).isError())
        before = self.value(client, PROCESS_VALUE)
        wait_for(lambda: self.value(client, PROCESS_VALUE) != before, "device time passes")
        self.assertNotIn(self.number(client, ALARM_STATE), (NONE, 88, 12))
        self.write(client, MODE, OFF)
        wait_for(lambda: self.number(client, ALARM_STATE) == NONE, "the alarm is cleared")

    def test_chamber_refuses_what_it_does_not_have(self):
        client = self.client()
        self.assert_exception(client.read_holding_registers(2000, 1, slave=1), ILLEGAL_ADDRESS)
        self.assert_exception(client.read_holding_registers(SET_POINT, 40, slave=1), ILLEGAL_ADDRESS)
        self.assert_exception(client.read_holding_registers(65535, 2, slave=1), ILLEGAL_ADDRESS)
        self.assert_exception(client.write_register(2000, 1, slave=1), ILLEGAL_ADDRESS)
        self.assert_exception(self.set_value(client, PROCESS_VALUE, 20.0), ILLEGAL_ADDRESS)
        self.assert_exception(self.set_value(client, SET_POINT, 500.0), ILLEGAL_VALUE)
        self.assert_exception(self.set_value(client, SET_POINT, float("nan")), ILLEGAL_VALUE)
        self.assert_exception(client.write_register(SET_POINT, 0, slave=1), ILLEGAL_VALUE)
        self.assert_exception(client.write_register(MODE, 3, slave=1), ILLEGAL_VALUE)
        self.assert_exception(client.read_input_registers(PROCESS_VALUE, 2, slave=1), ILLEGAL_FUNCTION)
        self.assert_exception(client.read_coils(0, 1, slave=1), ILLEGAL_FUNCTION)
        self.assert_exception(client.write_coil(0, True, slave=1), ILLEGAL_FUNCTION)
        self.assertEqual(self.number(client, MODE), OFF, "the connection serves on")

    def test_fixture_turns(self):
        client = self.client("fixture")
        self.assertEqual(self.number(client, 32), 0x5046)
        for position in (1, 2, 6, 5):
            self.write(client, 0, position)
            self.assertEqual(self.number(client, 0), position)
            wait_for(lambda p=position: client.read_holding_registers(1, 2, slave=1).registers == [p, 0], "it stands")
        self.assert_exception(client.write_register(0, 7, slave=1), ILLEGAL_VALUE)
        self.assert_exception(client.write_register(1, 3, slave=1), ILLEGAL_ADDRESS)

    def test_relay_switches(self):
        client = self.client("relay")
        self.assertEqual(self.number(client, 32), 0x5052)
        self.assertFalse(client.write_registers(3, [1, 0, 1], slave=1).isError())
        self.assertEqual(client.read_holding_registers(16 + 3, 3, slave=1).registers, [1, 0, 1])
        self.assert_exception(client.write_registers(3, [0, 0, 2], slave=1), ILLEGAL_VALUE)
        self.assertEqual(client.read_holding_registers(16 + 3, 3, slave=1).registers, [1, 0, 1], "all or none")
        self.assert_exception(client.write_register(16, 1, slave=1), ILLEGAL_ADDRESS)

    def test_many_clients_are_served_side_by_side(self):
        clients = [self.client() for _ in range(10)]
        for _ in range(20):
            for client in clients:
                self.assertEqual(self.number(client, UNITS), 15)

    def test_a_client_that_stops_in_the_middle_of_a_request_holds_up_nobody(self):
        with socket.create_connection(("127.0.0.1", self.lab.addresses["chamber"])) as halted:
            halted.sendall(bytes.fromhex("0001 0000 0006 01 03"))
            client = self.client()
            for _ in range(20):
                self.assertEqual(self.number(client, UNITS), 15)
            halted.sendall(struct.pack(">HH", UNITS, 1))
            halted.settimeout(PATIENCE_S)
            self.assertEqual(halted.recv(64), bytes.fromhex("0001 0000 0005 01 03 02 000F"))

    def test_a_client_that_speaks_something_else_is_disconnected(self):
        with socket.create_connection(("127.0.0.1", self.lab.addresses["chamber"]), timeout=PATIENCE_S) as stranger:
            stranger.sendall(b"GET / HTTP/1.1\r\n\r\n")
            try:
                self.assertEqual(stranger.recv(64), b"")
            except ConnectionResetError:
                pass
        self.assertEqual(self.number(self.client(), UNITS), 15)

    def test_exceptions_have_the_form_of_the_standard(self):
        answer = modbus_request(self.lab.addresses["chamber"], struct.pack(">BHH", 3, 2000, 1))
        self.assertEqual(answer, bytes([0x83, ILLEGAL_ADDRESS]))


class TwoAxisTest(ModbusTest):
    OPTIONS = ("--units", 1, "--rate", 200, "--fixture", "two-axis")
    OUTER_REQUEST, INNER_REQUEST, RATE_REQUEST, COMMAND, OUTER, INNER, RATE, STANDS = 0, 2, 4, 6, 10, 12, 14, 16

    def told(self, address):
        """A float, high word first."""
        answer = self.client("fixture").read_holding_registers(address, 2, slave=1)
        return BinaryPayloadDecoder.fromRegisters(answer.registers, Endian.Big, Endian.Big).decode_32bit_float()

    def ask(self, address, value):
        builder = BinaryPayloadBuilder(byteorder=Endian.Big, wordorder=Endian.Big)
        builder.add_32bit_float(value)
        return self.client("fixture").write_registers(address, builder.to_registers(), slave=1)

    def wait_until_it_stands(self):
        client = self.client("fixture")
        wait_for(lambda: self.number(client, self.STANDS) == 0, "it stands")

    def test_it_goes_to_angles_when_it_is_told_and_turns_at_a_rate(self):
        client = self.client("fixture")
        self.assertEqual(self.number(client, 32), 0x5441)
        self.assertFalse(self.ask(self.OUTER_REQUEST, 90.0).isError())
        self.assertFalse(self.ask(self.INNER_REQUEST, -45.5).isError())
        self.assertEqual((self.told(self.OUTER), self.told(self.INNER)), (0.0, 0.0))
        self.write(client, self.COMMAND, 1)
        self.wait_until_it_stands()
        self.assertEqual((self.told(self.OUTER), self.told(self.INNER)), (90.0, -45.5))
        self.assertFalse(self.ask(self.RATE_REQUEST, -30.0).isError())
        self.write(client, self.COMMAND, 2)
        self.wait_until_it_stands()
        self.assertEqual(self.told(self.RATE), -30.0)
        before = self.told(self.INNER)
        wait_for(lambda: self.told(self.INNER) != before, "the angle goes on")
        self.assert_exception(self.ask(self.OUTER_REQUEST, 200.0), ILLEGAL_VALUE)
        self.assert_exception(self.ask(self.OUTER, 0.0), ILLEGAL_ADDRESS)


class MbpollTest(ModbusTest):
    OPTIONS = ("--units", 1, "--rate", 50)

    def mbpoll(self, device, *words, status=0):
        port = str(self.lab.addresses[device])
        command = ["mbpoll", "-m", "tcp", "-p", port, "-a", "1", "-0", "-1", "-q", "-o", "10", *map(str, words)]
        done = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE_S, check=False)
        self.assertEqual(done.returncode, status, f"{command}\n{done.stdout}{done.stderr}")
        return done.stdout + done.stderr

    def polled(self, device, address, kind):
        text = self.mbpoll(device, "-r", address, "-c", 1, "-t", kind, "127.0.0.1")
        return float(re.search(rf"\[{address}\]:\s+(\S+)", text).group(1))

    def test_reads_and_writes_floats_low_word_first(self):
        self.assertAlmostEqual(self.polled("chamber", PROCESS_VALUE, "4:float"), 23.0, delta=0.3)
        self.mbpoll("chamber", "-r", SET_POINT, "-t", "4:float", "127.0.0.1", "--", "-40.25")
        self.assertEqual(self.polled("chamber", SET_POINT, "4:float"), -40.25)

    def test_sees_the_heater_go_on_and_off(self):
        self.mbpoll("chamber", "-r", SET_POINT, "-t", "4:float", "127.0.0.1", "--", "70")
        self.mbpoll("chamber", "-r", MODE, "-t", "4", "127.0.0.1", "--", AUTO)
        wait_for(lambda: self.polled("chamber", POWER, "4:float") == 100.0, "full power")
        self.mbpoll("chamber", "-r", MODE, "-t", "4", "127.0.0.1", "--", OFF)
        self.assertEqual(self.polled("chamber", POWER, "4:float"), 0.0)
        self.assertEqual(self.polled("chamber", ACTUAL_MODE, "4"), OFF)

    def test_turns_the_fixture_and_switches_the_relay(self):
        self.mbpoll("fixture", "-r", 0, "-t", "4", "127.0.0.1", "--", "3")
        wait_for(lambda: self.polled("fixture", 1, "4") == 3, "the fixture stands in position 3")
        self.mbpoll("relay", "-r", 0, "-t", "4", "127.0.0.1", "--", "1")
        self.assertEqual(self.polled("relay", 16, "4"), 1)

    def test_is_told_what_is_wrong(self):
        unknown = self.mbpoll("chamber", "-r", 2000, "-c", 1, "-t", "4", "127.0.0.1", status=1)
        self.assertIn("Illegal data address", unknown)
        refused = self.mbpoll("chamber", "-r", SET_POINT, "-t", "4:float", "127.0.0.1", "--", "500", status=1)
        self.assertIn("Illegal data value", refused)


if __name__ == "__main__":
    unittest.main()
