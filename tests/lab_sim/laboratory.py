# SPDX-License-Identifier: Apache-2.0
"""What the tests of soaksim share: a running laboratory ($SOAKSIM), and a unit's Xbus protocol, written from the
maker's description and not from the simulator's code."""
import json
import os
import pathlib
import select
import shutil
import signal
import socket
import struct
import subprocess
import tempfile
import time
import tty
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
PATIENCE_S = 60  # for what a free machine does at once

GOTO_MEASUREMENT, GOTO_CONFIG, REQ_DEVICE_ID, WAKE_UP, WAKE_UP_ACK = 0x10, 0x30, 0x00, 0x3E, 0x3F
MT_DATA_2, SET_OUTPUT, ERROR = 0x36, 0xC0, 0x42
# Counter and fine time with each packet, acceleration and rate of turn at 100 Hz, temperature at 10 Hz.
OUTPUT_100_HZ = bytes.fromhex("1020FFFF 1060FFFF 40200064 80200064 0810000A")


def wait_for(condition, what):
    """Waits until `condition` gives something true, and returns it."""
    end = time.monotonic() + PATIENCE_S
    while time.monotonic() < end:
        result = condition()
        if result:
            return result
        time.sleep(0.01)
    raise AssertionError(f"{PATIENCE_S} s have passed without this: {what}")


class Soaksim:
    """A running soaksim with a folder of its own. `start` waits for its line of JSON."""

    def __init__(self, *options):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="soaksim-test-"))
        command = [os.environ["SOAKSIM"], "--out", str(self.folder), *map(str, options)]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        line = self.process.stdout.readline()
        if not line:
            raise AssertionError(self.process.communicate()[1])
        self.addresses = json.loads(line)

    def powered_unit(self, slot):
        """A reader of a unit that gets its power now."""
        unit = Unit(self.addresses["units"][slot - 1])
        write_register(self.addresses["relay"], slot - 1, 0)
        write_register(self.addresses["relay"], slot - 1, 1)
        return unit

    def end(self, how=signal.SIGTERM):
        """Ends it; its exit status and what it still printed."""
        if self.process.poll() is None:
            self.process.send_signal(how)
        output, errors = self.process.communicate(timeout=PATIENCE_S)
        shutil.rmtree(self.folder, ignore_errors=True)
        return self.process.returncode, output + errors


class LaboratoryTest(unittest.TestCase):
    """Tests before one laboratory with the options of the class."""

    OPTIONS = ()

    @classmethod
    def setUpClass(cls):
        cls.lab = Soaksim(*cls.OPTIONS)

    @classmethod
    def tearDownClass(cls):
        status, text = cls.lab.end()
        if status != 0 or text:
            raise AssertionError(f"soaksim ended with status {status}: {text}")

    def relay(self, output, on):
        write_register(self.lab.addresses["relay"], output - 1, 1 if on else 0)


def _exactly(connection, count):
    data = b""
    while len(data) < count:
        part = connection.recv(count - len(data))
        if not part:
            raise AssertionError("the server closed the connection")
        data += part
    return data


def modbus_request(port, pdu):
    """One request on a connection of its own, made by hand; the PDU of the answer."""
    with socket.create_connection(("127.0.0.1", port), timeout=PATIENCE_S) as connection:
        connection.sendall(struct.pack(">HHHB", 7, 0, len(pdu) + 1, 1) + pdu)
        transaction, protocol, length, unit = struct.unpack(">HHHB", _exactly(connection, 7))
        if (transaction, protocol, unit) != (7, 0, 1):
            raise AssertionError("the header of the answer is not that of the request")
        return _exactly(connection, length - 1)


def write_register(port, address, value):
    pdu = struct.pack(">BHH", 6, address, value)
    answer = modbus_request(port, pdu)
    if answer != pdu:
        raise AssertionError(f"register {address} did not take {value}: {answer.hex()}")


def read_register(port, address):
    answer = modbus_request(port, struct.pack(">BHH", 3, address, 1))
    if answer[:2] != b"\x03\x02":
        raise AssertionError(f"register {address} cannot be read: {answer.hex()}")
    return struct.unpack(">H", answer[2:])[0]


def frame(message, data=b""):
    body = bytes([0xFF, message, len(data)]) + data
    return b"\xFA" + body + bytes([-sum(body) & 0xFF])


class Unit:
    """A reader of a unit, on a TCP port or on a terminal."""

    def __init__(self, address):
        self.received = b""
        self.in_step = isinstance(address, int)  # on a terminal a reader comes in at any place of the stream
        self.socket = None
        if isinstance(address, int):
            self.socket = socket.create_connection(("127.0.0.1", address), timeout=PATIENCE_S)
            self.fd = self.socket.fileno()
        else:
            self.fd = os.open(address, os.O_RDWR | os.O_NOCTTY)
            tty.setraw(self.fd)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.socket:
            self.socket.close()
        else:
            os.close(self.fd)

    def send(self, message, data=b""):
        os.write(self.fd, frame(message, data))

    def _take_frame(self):
        """The first whole frame of what was received. Between two frames there is nothing, and each is intact."""
        data = self.received
        if len(data) < 5 or len(data) < 5 + data[3]:
            return None if self.in_step else self._find_step()
        size = 5 + data[3]
        if data[:2] != b"\xFA\xFF" or data[3] == 0xFF or sum(data[1:size]) % 256 != 0:
            if not self.in_step:
                return self._find_step()
            raise AssertionError(f"this is no frame: {data[:size].hex()}")
        self.in_step = True
        self.received = data[size:]
        return data[2], data[4:size - 1]

    def _find_step(self):
        """Looks for the first frame after bytes that belong to none."""
        for start in range(1, len(self.received) - 4):
            data = self.received[start:]
            if data[:2] == b"\xFA\xFF" and 5 + data[3] <= len(data) and sum(data[1:5 + data[3]]) % 256 == 0:
                self.received = data
                return self._take_frame()
        return None

    def next(self, patience_s=PATIENCE_S):
        """The next message and its data; None where none comes."""
        end = time.monotonic() + patience_s
        while True:
            message = self._take_frame()
            if message:
                return message
            rest = end - time.monotonic()
            if rest <= 0 or not select.select([self.fd], [], [], rest)[0]:
                return None
            part = os.read(self.fd, 65536)
            if not part:
                raise AssertionError("the unit closed the connection")
            self.received += part

    def wait_for(self, wanted):
        """Data of the next message of a kind; others are passed over."""
        while True:
            message = self.next()
            if message is None:
                raise AssertionError(f"message {wanted:02X} did not come")
            if message[0] == wanted:
                return message[1]

    def ask(self, message, data=b""):
        """The answer to a message; measurements that are on their way are passed over."""
        self.send(message, data)
        return self.wait_for(message + 1)

    def measurements(self, count):
        """The next measurements."""
        return [measurement(self.wait_for(MT_DATA_2)) for _ in range(count)]


def measurement(data):
    """The values in the data of an MTData2 message by name."""
    formats = {0x1020: ("counter", ">H"), 0x1060: ("time", ">I"), 0x4020: ("accel", ">fff"), 0x8020: ("gyro", ">fff"),
               0x0810: ("temp", ">f"), 0xE020: ("status", ">I")}
    values = {}
    while data:
        identifier, size = struct.unpack(">HB", data[:3])
        name, layout = formats[identifier]
        value = struct.unpack(layout, data[3:3 + size])
        values[name] = value if len(value) > 1 else value[0]
        data = data[3 + size:]
    return values


def truth(*options):
    """What soaksim-truth prints."""
    return subprocess.run([os.environ["SOAKSIM_TRUTH"], *map(str, options)], capture_output=True, text=True, check=True,
                          timeout=PATIENCE_S).stdout
