# SPDX-License-Identifier: Apache-2.0
"""An ESPEC P300 as its users describe it (EspecNorthAmerica/ChamberConnectLibrary), as a peer for the text driver's tests.
Shares nothing with soaksim.

usage: espec_peer.py PORT    (0 = any)

One client at a time. Lines end in CR LF. Prints "PORT n", then obeys lines on standard input and answers each by "OK":
  set NAME VALUE      air, sp, high, low, mode, alarm (codes, as "3 7")
  get NAME            prints the value or the mode, instead of "OK"
  fault KIND COUNT    the next COUNT answers: late (0.6 s), later (1.5 s), silence, fragments, cut (half an answer),
                      garbage, twice, stale (the answer before this one first), other (that to TEMP?), refuse, endless, close
  then KIND COUNT     after those, the next COUNT
  log                 prints the commands that came since the last time, joined by "|", instead of "OK"
  stuck               commands that write are answered, but change nothing
Ends with its standard input.
"""
import os
import re
import socket
import struct
import sys
import threading
import time


class Chamber:
    def __init__(self):
        self.values = {"air": 23.2, "sp": 25.0, "high": 150.0, "low": -60.0}
        self.mode = "STANDBY"
        self.alarms = []
        self.faults = []  # of the answers to come
        self.log = []
        self.stuck = False
        self.last = b""

    def answer(self, line):
        self.log.append(line)
        if line == "TEMP?":
            return ",".join(f"{self.values[name]:.1f}" for name in ("air", "sp", "high", "low"))
        if line == "MODE?":
            return self.mode
        if line == "ALARM?":
            return ",".join([str(len(self.alarms)), *self.alarms])
        if line in ("MODE,CONSTANT", "MODE,STANDBY"):
            if not self.stuck:
                self.mode = line[5:]
            return f"OK:{line}"
        written = re.fullmatch(r"TEMP, S(-?\d+\.\d)", line)
        if written:
            value = float(written.group(1))
            if not self.values["low"] <= value <= self.values["high"]:
                return "NA:DATA OUT OF RANGE"
            if not self.stuck:
                self.values["sp"] = value
            return f"OK:{line}"
        return "NA:PARA ERR" if line.startswith("TEMP,") else "NA:CMD ERR"

    def next_fault(self):
        return self.faults.pop(0) if self.faults else ""


def send(chamber, client, line):
    """Sends the answer as the fault wants it; false if the connection shall end."""
    fault = chamber.next_fault()
    good = b"NA:CHB NOT READY\r\n" if fault == "refuse" else (chamber.answer(line) + "\r\n").encode()
    if fault == "other":
        good = (chamber.answer("TEMP?") + "\r\n").encode()
    if fault in ("late", "later"):
        time.sleep(0.6 if fault == "late" else 1.5)
    if fault == "fragments":
        for byte in good:
            client.sendall(bytes([byte]))
            time.sleep(0.002)
    elif fault == "garbage":
        client.sendall(bytes((37 * i + 129) % 256 for i in range(20)) + b"\r\n")
    elif fault == "endless":
        client.sendall(b"x" * 5000)
    elif fault == "close":
        client.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        return False
    elif fault != "silence":
        client.sendall({"cut": good[:len(good) // 2], "twice": good + good, "stale": chamber.last + good}.get(fault, good))
    chamber.last = good
    return True


def serve(chamber, listener):
    while True:
        client, _ = listener.accept()
        client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        try:
            received, alive = b"", True
            while alive:
                part = client.recv(4096)
                if not part:
                    break
                received += part
                while alive and b"\r\n" in received:
                    line, received = received.split(b"\r\n", 1)
                    alive = send(chamber, client, line.decode("ascii", "replace"))
        except OSError:
            pass
        client.close()


def obey(chamber, words):
    if words[0] == "set" and words[1] == "mode":
        chamber.mode = words[2]
    elif words[0] == "set" and words[1] == "alarm":
        chamber.alarms = words[2:]
    elif words[0] == "set":
        chamber.values[words[1]] = float(words[2])
    elif words[0] == "get":
        return chamber.mode if words[1] == "mode" else f"{chamber.values[words[1]]:.1f}"
    elif words[0] == "fault":
        chamber.faults = [words[1]] * int(words[2])
    elif words[0] == "then":
        chamber.faults += [words[1]] * int(words[2])
    elif words[0] == "stuck":
        chamber.stuck = True
    elif words[0] == "log":
        log, chamber.log = chamber.log, []
        return "|".join(log)
    return "OK"


if __name__ == "__main__":
    the_chamber = Chamber()
    the_listener = socket.create_server(("127.0.0.1", int(sys.argv[1])))
    threading.Thread(target=serve, args=(the_chamber, the_listener), daemon=True).start()
    print("PORT", the_listener.getsockname()[1], flush=True)
    for order in sys.stdin:
        print(obey(the_chamber, order.split()), flush=True)
    os._exit(0)
