# SPDX-License-Identifier: Apache-2.0
"""A Modbus server on pymodbus, as a peer for the drivers' tests.

usage: pymodbus_server.py tcp|rtu PORT SPEC...    (PORT 0 = any; rtu: RTU frames over TCP, for a pseudo-terminal made by socat)

SPEC is KIND:ADDRESS:VALUE with KIND u16, i16, f32lo (low word first), f32hi, in (an input register); copy:FROM:TO
repeats what is written to FROM in TO; stuck:ADDRESS:0 ignores writes. Register 60000 counts the requests that wrote.
Prints "PORT n m" and serves until its standard input ends; m is a port with Modbus TCP frames for the same registers.
"""
import asyncio
import logging
import os
import struct
import sys
import threading
import types

# Debian's pymodbus imports this module for serial ports without depending on its package; here all is TCP.
sys.modules.setdefault("serial_asyncio", types.SimpleNamespace(create_serial_connection=None))

from pymodbus.datastore import ModbusServerContext, ModbusSlaveContext, ModbusSparseDataBlock
from pymodbus.framer.rtu_framer import ModbusRtuFramer
from pymodbus.framer.socket_framer import ModbusSocketFramer
from pymodbus.server.async_io import ModbusTcpServer

WRITE_COUNT = 60000


class Registers(ModbusSparseDataBlock):
    """Holding registers with holes: a hole answers exception 2."""

    def __init__(self, values, copies, stuck):
        super().__init__(values)
        self.copies = copies
        self.stuck = stuck

    def setValues(self, address, values, use_as_default=False):
        self.values[WRITE_COUNT] += 1
        for offset, value in enumerate(values):
            register = address + offset
            if register not in self.stuck:
                self.values[register] = value
            if register in self.copies:
                self.values[self.copies[register]] = value


def words(kind, text):
    if kind == "f32lo":
        return list(reversed(struct.unpack(">HH", struct.pack(">f", float(text)))))
    if kind == "f32hi":
        return list(struct.unpack(">HH", struct.pack(">f", float(text))))
    return [int(text, 0) & 0xFFFF]


def context(specs):
    holding, inputs, copies, stuck = {WRITE_COUNT: 0}, {0: 0}, {}, set()
    for spec in specs:
        kind, address, value = spec.split(":")
        if kind == "copy":
            copies[int(address)] = int(value)
        elif kind == "stuck":
            stuck.add(int(address))
        else:
            bank = inputs if kind == "in" else holding
            for offset, word in enumerate(words(kind, value)):
                bank[int(address) + offset] = word
    slave = ModbusSlaveContext(hr=Registers(holding, copies, stuck), ir=ModbusSparseDataBlock(inputs), zero_mode=True)
    return ModbusServerContext(slaves={1: slave}, single=False)


def leave_with_parent():
    sys.stdin.read()
    os._exit(0)


async def begin(shared, framer, port):
    server = ModbusTcpServer(shared, framer=framer, address=("127.0.0.1", port), ignore_missing_slaves=True,
                             allow_reuse_address=True)
    task = asyncio.ensure_future(server.serve_forever())
    await server.serving
    return task, server.server.sockets[0].getsockname()[1]


async def serve(framer, port, specs):
    shared = context(specs)
    task, bound = await begin(shared, framer, port)
    look = bound
    if framer is not ModbusSocketFramer:
        other, look = await begin(shared, ModbusSocketFramer, 0)
    print("PORT", bound, look, flush=True)
    await (task if look == bound else asyncio.gather(task, other))


if __name__ == "__main__":
    logging.disable()  # every closed connection is an error there
    threading.Thread(target=leave_with_parent, daemon=True).start()
    asyncio.run(serve(ModbusRtuFramer if sys.argv[1] == "rtu" else ModbusSocketFramer, int(sys.argv[2]), sys.argv[3:]))
