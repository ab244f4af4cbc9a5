# SPDX-License-Identifier: Apache-2.0
"""A laboratory supply of three outputs after SCPI-99 and IEEE 488.2, as a peer for tests. Shares nothing with the driver.

usage: scpi_supply.py PORT    (0 = any)

Strict: a mnemonic in its short or its long form and no other, the path that a header leaves for the next one of the same
message, channel lists, numbers as NRf, an error queue of ten, only queries answer, a command error ends its message.
Outputs are chosen by a channel list or by INSTrument:NSELect. One client at a time, lines end in LF.

Prints "PORT n", then obeys lines on standard input and answers each by "OK":
  load N OHM          what hangs on output N (at the start nothing)
  ocp N               over-current protection of output N switches it off; without it the current is held at the limit
  off N, trip N       somebody switches output N off at the front; its over-voltage protection trips
  error CODE TEXT     an error of before in the queue
  stuck               settings are accepted and change nothing
  nan                 measurements are not numbers
  fault KIND COUNT    the next COUNT answers: late (0.6 s), silence, fragments, cut, garbage, twice, close
  then KIND COUNT     after those, the next COUNT
  log                 prints the messages that came since the last time, joined by "|", instead of "OK"
  state N             prints "on" or "off", volts and amps of output N, instead of "OK"
Ends with its standard input.
"""
import math
import os
import re
import socket
import struct
import sys
import threading
import time

MOST_V, MOST_A = 30.0, 5.0
NRF = re.compile(r"[+-]?(\d+(\.\d*)?|\.\d+)([Ee][+-]?\d+)?$")
SHORTEST = re.compile(r"\*?[A-Z]+")


class ScpiError(Exception):
    def __init__(self, code, text):
        super().__init__(text)
        self.code, self.text = code, text


class Output:
    def __init__(self):
        self.set_v, self.limit_a, self.ohm = 0.0, 1.0, math.inf
        self.on = self.protects_current = self.current_trip = self.voltage_trip = False

    def deliver(self):
        """Volts and amps now; the protection acts."""
        if not self.on:
            return 0.0, 0.0
        amps = self.set_v / self.ohm
        if amps <= self.limit_a:
            return self.set_v, amps
        if self.protects_current:
            self.on, self.current_trip = False, True
            return 0.0, 0.0
        return self.limit_a * self.ohm, self.limit_a


def nr3(value):
    return f"{value:+.6E}"


def number(text, low, high):
    if text.upper() in ("MIN", "MINIMUM"):
        return low
    if text.upper() in ("MAX", "MAXIMUM"):
        return high
    if not NRF.match(text):
        raise ScpiError(-104, "Data type error")
    value = float(text)
    if not low <= value <= high:
        raise ScpiError(-222, "Data out of range")
    return value


def boolean(text):
    if text.upper() in ("ON", "OFF"):
        return text.upper() == "ON"
    if not NRF.match(text):
        raise ScpiError(-104, "Data type error")
    return round(float(text)) != 0


def is_mnemonic(text, long_form):
    return text.upper() in (long_form.upper(), SHORTEST.match(long_form).group())


def matches(nodes, pattern):
    """Whether header nodes spell a pattern of (long form, optional)."""
    if not pattern:
        return not nodes
    (form, optional), rest = pattern[0], pattern[1:]
    if nodes and is_mnemonic(nodes[0], form) and matches(nodes[1:], rest):
        return True
    return optional and matches(nodes, rest)


def pattern_of(text):
    """"OUTPut[:STATe]" as a list of (long form, optional)."""
    return [(name, bool(bracket)) for bracket, name in re.findall(r"(\[?):?(\*?[A-Za-z]+):?\]?", text)]


class Supply:
    """`switched(output, on)` is told whenever an output goes on or off."""

    def __init__(self, outputs=3, switched=None):
        self.outputs = [Output() for _ in range(outputs)]
        self.was_on = [False] * outputs
        self.switched = switched
        self.selected = 1
        self.errors, self.log, self.faults = [], [], []
        self.stuck = self.not_numbers = False
        self.lock = threading.RLock()
        self.commands = [(pattern_of(text), query, action) for text, query, action in (
            ("*IDN", True, lambda a: "SOAK,PEER 3303,0042,1.0"), ("*OPC", True, lambda a: "1"),
            ("*CLS", False, lambda a: self.errors.clear()),
            ("SYSTem:ERRor[:NEXT]", True, lambda a: self.errors.pop(0) if self.errors else '+0,"No error"'),
            ("INSTrument:NSELect", False, self.select), ("INSTrument:NSELect", True, lambda a: str(self.selected)),
            ("OUTPut[:STATe]", False, self.switch), ("OUTPut[:STATe]", True, self.each(lambda o: str(int(o.on)))),
            ("[SOURce:]VOLTage[:LEVel][:IMMediate][:AMPLitude]", False, self.setter("set_v", MOST_V)),
            ("[SOURce:]VOLTage[:LEVel][:IMMediate][:AMPLitude]", True, self.each(lambda o: nr3(o.set_v))),
            ("[SOURce:]CURRent[:LEVel][:IMMediate][:AMPLitude]", False, self.setter("limit_a", MOST_A)),
            ("[SOURce:]CURRent[:LEVel][:IMMediate][:AMPLitude]", True, self.each(lambda o: nr3(o.limit_a))),
            ("[SOURce:]CURRent:PROTection:TRIPped", True, self.each(lambda o: str(int(o.current_trip)))),
            ("[SOURce:]VOLTage:PROTection:TRIPped", True, self.each(lambda o: str(int(o.voltage_trip)))),
            ("MEASure[:SCALar]:VOLTage[:DC]", True, self.each(lambda o: self.measured(o, 0))),
            ("MEASure[:SCALar]:CURRent[:DC]", True, self.each(lambda o: self.measured(o, 1))))]

    # --- what the commands do ---------------------------------------------------------------------------------------

    def measured(self, output, which):
        return "9.91E37" if self.not_numbers else nr3(output.deliver()[which])

    def select(self, arguments):
        if len(arguments) != 1:
            raise ScpiError(-109 if not arguments else -108, "Missing parameter" if not arguments else "Parameter not allowed")
        self.selected = int(number(arguments[0], 1, len(self.outputs)))

    def channels(self, arguments, values):
        """The outputs that are meant, once `values` arguments are taken off."""
        if len(arguments) < values:
            raise ScpiError(-109, "Missing parameter")
        rest = arguments[values:]
        if not rest:
            return [self.selected]
        if len(rest) > 1:
            raise ScpiError(-108, "Parameter not allowed")
        found = re.fullmatch(r"\(@(\d+(?::\d+)?(?:,\d+(?::\d+)?)*)\)", rest[0])
        if not found:
            raise ScpiError(-104, "Data type error")
        numbers = []
        for part in found.group(1).split(","):
            first, _, last = part.partition(":")
            numbers += range(int(first), int(last or first) + 1)
        if not all(1 <= n <= len(self.outputs) for n in numbers):
            raise ScpiError(-222, "Data out of range")
        return numbers

    def each(self, value):
        return lambda arguments: ",".join(value(self.outputs[n - 1]) for n in self.channels(arguments, 0))

    def setter(self, name, most):
        def store(arguments):
            channels = self.channels(arguments, 1)
            value = number(arguments[0], 0.0, most)
            for n in channels:
                if not self.stuck:
                    setattr(self.outputs[n - 1], name, value)
        return store

    def switch(self, arguments):
        channels = self.channels(arguments, 1)
        on = boolean(arguments[0])
        for n in channels:
            output = self.outputs[n - 1]
            tripped = output.current_trip or output.voltage_trip
            if not self.stuck:
                output.on = on and not tripped

    # --- messages -----------------------------------------------------------------------------------------------------

    def fail(self, code, text):
        if len(self.errors) >= 10:
            self.errors[-1] = '-350,"Queue overflow"'
        else:
            self.errors.append(f'{code},"{text}"')

    def find(self, nodes, query):
        known = [entry for entry in self.commands if matches(nodes, entry[0])]
        for _, is_query, action in known:
            if is_query == query:
                return action
        raise ScpiError(-113, "Undefined header")

    def unit(self, text, path):
        """Carries one message unit out; its answer or None, and the path that it leaves."""
        found = re.fullmatch(r"\s*(:?)(\*?[A-Za-z][A-Za-z0-9_:]*)(\??)(?:\s+(.*?))?\s*", text)
        if not found:
            raise ScpiError(-102, "Syntax error")
        colon, header, question, rest = found.groups()
        arguments = re.findall(r"\([^)]*\)|[^,\s][^,]*", rest or "")
        arguments = [a.strip() for a in arguments]
        if header.startswith("*"):
            return self.find([header], bool(question))(arguments), path
        nodes = header.split(":") if colon else path + header.split(":")
        return self.find(nodes, bool(question))(arguments), nodes[:-1]

    def message(self, line):
        """Carries a program message out; the response message, nothing where no query was in it."""
        with self.lock:
            self.log.append(line)
            answers, path = [], []
            for text in line.split(";"):
                try:
                    answer, path = self.unit(text, path)
                    if answer is not None:
                        answers.append(answer)
                except ScpiError as error:
                    self.fail(error.code, error.text)
                    if error.code > -200:
                        break  # what follows a command error is not looked at
            self.settle()
            return ";".join(answers) if answers else None

    def settle(self):
        for n, output in enumerate(self.outputs, 1):
            output.deliver()
            if self.switched and output.on != self.was_on[n - 1]:
                self.switched(n, output.on)
            self.was_on[n - 1] = output.on

    # --- the wire -----------------------------------------------------------------------------------------------------

    def send(self, client, answer):
        """Sends an answer as the next fault wants it; false if the connection shall end."""
        fault = self.faults.pop(0) if self.faults else ""
        good = (answer + "\n").encode()
        if fault == "late":
            time.sleep(0.6)
        if fault == "close":
            client.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
            return False
        if fault == "fragments":
            for byte in good:
                client.sendall(bytes([byte]))
                time.sleep(0.002)
        elif fault == "garbage":
            client.sendall(bytes((37 * i + 129) % 256 for i in range(20)) + b"\n")
        elif fault != "silence":
            client.sendall({"cut": good[:len(good) // 2], "twice": good + good}.get(fault, good))
        return True

    def serve_client(self, client):
        client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        received = b""
        while part := client.recv(4096):
            received += part
            while b"\n" in received:
                line, received = received.split(b"\n", 1)
                answer = self.message(line.decode("ascii", "replace"))
                if answer is not None and not self.send(client, answer):
                    return

    def serve(self, listener):
        while True:
            try:
                client, _ = listener.accept()
            except OSError:
                return  # closed
            with client:
                try:
                    self.serve_client(client)
                except OSError:
                    pass

    def start(self, port=0):
        """Listens; the port."""
        listener = socket.create_server(("127.0.0.1", port))
        threading.Thread(target=self.serve, args=(listener,), daemon=True).start()
        return listener.getsockname()[1]

    # --- orders -------------------------------------------------------------------------------------------------------

    def obey(self, words):
        with self.lock:
            name, values = words[0], words[1:]
            output = self.outputs[int(values[0]) - 1] if values and values[0].isdigit() else None
            if name == "load":
                output.ohm = float(values[1])
            elif name == "ocp":
                output.protects_current = True
            elif name == "off":
                output.on = False
            elif name == "trip":
                output.on, output.voltage_trip = False, True
            elif name == "error":
                self.fail(values[0], " ".join(values[1:]))
            elif name == "stuck":
                self.stuck = True
            elif name == "nan":
                self.not_numbers = True
            elif name == "fault":
                self.faults = [values[0]] * int(values[1])
            elif name == "then":
                self.faults += [values[0]] * int(values[1])
            elif name == "log":
                log, self.log = self.log, []
                return "|".join(log)
            elif name == "state":
                volts, amps = output.deliver()
                return f"{'on' if output.on else 'off'} {volts:.3f} {amps:.3f}"
            self.settle()
            return "OK"


if __name__ == "__main__":
    the_supply = Supply()
    print("PORT", the_supply.start(int(sys.argv[1])), flush=True)
    for order in sys.stdin:
        print(the_supply.obey(order.split()), flush=True)
    os._exit(0)
