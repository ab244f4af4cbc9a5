# SPDX-License-Identifier: Apache-2.0
"""Three chambers as public clients of them speak: SimServ of Weiss and Vötsch, CTS over Ethernet, Thermotron 8800. A peer for the
text driver's tests; shares nothing with it or with soaksim. Sources: SengerM/VotschTechnik-climate-chamber-Python
ClimateChamber.py and F. Guescini's Climate Chamber Controller; ppudo's labtoys ASCII_Proto_ETH.py and L. Lanzieri's CTSChamber;
the class ThermotronChamber and the maker's texts in it.

usage: dialects_peer.py PORT DIALECT    (0 = any port; simserv, cts, thermotron)

One client at a time. Prints "PORT n", then obeys lines on standard input and answers each by "OK":
  set NAME VALUE   air, sp, low, high, on (0 or 1), error (0 = none)
  get NAME         prints the value instead of "OK"
  log              prints the bytes that came since the last time, each command in hexadecimal, joined by "|"
  ends TEXT        answers end in crlf or cr from now on
  broken N         the next N answers are bytes that are no text, with a line end
Ends with its standard input.
"""
import os
import re
import socket
import sys
import threading

SEPARATOR = b"\xb6"


class Chamber:
    def __init__(self):
        self.values = {"air": 23.4, "sp": 25.0, "low": -60.0, "high": 150.0, "on": 0.0, "error": 0.0}
        self.log = []
        self.end = b"\r\n"
        self.broken = 0

    def set_point(self, value):
        allowed = self.values["low"] <= value <= self.values["high"]
        if allowed:
            self.values["sp"] = value
        return allowed


def simserv(chamber, command):
    """Status and value, separated by the byte 182; a negative status is an error."""
    words = [word.decode("ascii") for word in command.split(SEPARATOR)]
    number, index, arguments = words[0], words[1], words[2:]
    values = chamber.values
    answers = {("11004", ("1",)): "air", ("11002", ("1",)): "sp", ("11007", ("1",)): "low", ("11009", ("1",)): "high"}
    if index != "1":
        return b"-3"
    if name := answers.get((number, tuple(arguments))):
        return b"1" + SEPARATOR + f"{values[name]:.1f}".encode()
    if number == "11001" and arguments[0] == "1":
        return b"1" if chamber.set_point(float(arguments[1])) else b"-6"
    if number == "14001" and arguments in (["1", "0"], ["1", "1"]):
        values["on"] = float(arguments[1])
        return b"1"
    if number == "14003" and arguments == ["1"]:
        return b"1" + SEPARATOR + str(int(values["on"])).encode()
    if number == "10012" and not arguments:
        return b"1" + SEPARATOR + str(8 if values["error"] else 2 if values["on"] else 1).encode()
    return b"-5"


def cts(chamber, command):
    text = command.decode("ascii")
    values = chamber.values

    def five(value):
        return f"{value:05.1f}"
    if text == "A0":
        return f"A0 {five(values['air'])} {five(values['sp'])}".encode()
    if written := re.fullmatch(r"a0 ((?:\d{3}|-\d{2})\.\d)", text):
        chamber.set_point(float(written.group(1)))
        return b"a"
    if text in ("s1 0", "s1 1"):
        values["on"] = float(text[-1])
        return b"s1"
    if text == "S":
        return f"S{int(values['on'])}{int(values['error'] != 0)}1000000{int(values['error'])}"[:10].encode()
    return b"?"


def thermotron(chamber, command):
    text = command.decode("ascii")
    values = chamber.values
    if text == "PVAR1?":
        return f"{values['air']:.2f}".encode()
    if text == "SETP1?":
        return f"{values['sp']:.2f}".encode()
    if text == "SCOD?":
        return b"10" if values["error"] else b"1" if values["on"] else b"5"
    if text in ("RUNM", "STOP"):
        values["on"] = float(text == "RUNM")
        return b"0"
    if written := re.fullmatch(r"SETP1,(-?\d+(?:\.\d+)?)", text):
        # While it stands it takes the command, and keeps what it had.
        if values["on"] and not chamber.set_point(float(written.group(1))):
            return b"5"
        return b"0"
    return b"3"


DIALECTS = {"simserv": simserv, "cts": cts, "thermotron": thermotron}


def serve(chamber, answer, listener, has_lines):
    while True:
        client, _ = listener.accept()
        client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        try:
            received = b""
            while part := client.recv(4096):
                received += part
                commands = [received]
                if has_lines:
                    *commands, received = received.split(b"\r")
                else:
                    received = b""
                for command in commands:
                    chamber.log.append(command.hex())
                    line = answer(chamber, command)
                    if chamber.broken > 0:
                        chamber.broken -= 1
                        line = b"\x07" * len(line)
                    client.sendall(line + (chamber.end if has_lines else b""))
        except OSError:
            pass
        client.close()


def obey(chamber, words):
    if words[0] == "set":
        chamber.values[words[1]] = float(words[2])
    elif words[0] == "get":
        return f"{chamber.values[words[1]]:.1f}"
    elif words[0] == "ends":
        chamber.end = {"crlf": b"\r\n", "cr": b"\r"}[words[1]]
    elif words[0] == "broken":
        chamber.broken = int(words[1])
    elif words[0] == "log":
        log, chamber.log = chamber.log, []
        return "|".join(log)
    return "OK"


if __name__ == "__main__":
    the_chamber = Chamber()
    the_listener = socket.create_server(("127.0.0.1", int(sys.argv[1])))
    threading.Thread(target=serve, args=(the_chamber, DIALECTS[sys.argv[2]], the_listener, sys.argv[2] != "cts"), daemon=True).start()
    print("PORT", the_listener.getsockname()[1], flush=True)
    for order in sys.stdin:
        print(obey(the_chamber, order.split()), flush=True)
    os._exit(0)
