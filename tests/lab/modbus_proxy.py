# SPDX-License-Identifier: Apache-2.0
"""A device that speaks Modbus TCP and is not quite what it was: hands requests on to a server on 127.0.0.1, and answers
in its place where it is told to."""
import socket
import struct
import threading

READ, WRITE_ONE, WRITE = 3, 6, 16
ILLEGAL_VALUE = 3


class ModbusProxy:
    """`answer`: takes a request (function code and what follows) and returns the answer, or None to hand it on. `change_request`
    and `change_answer` (request, answer) change what passes.
    `writes`: (first register, data) of all writes that came, whatever became of them."""

    def __init__(self, target):
        self.target = target
        self.answer = lambda request: None
        self.change_request = lambda request: request
        self.change_answer = lambda request, answer: answer
        self.writes = []
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.port = self._listener.getsockname()[1]
        threading.Thread(target=self._accept, daemon=True).start()

    def close(self):
        self._listener.close()

    def writes_to(self, register):
        return [data for address, data in self.writes if address == register]

    def _accept(self):
        while True:
            try:
                client, _ = self._listener.accept()
            except OSError:
                return
            threading.Thread(target=self._serve, args=(client,), daemon=True).start()

    def _serve(self, client):
        try:
            with client, socket.create_connection(("127.0.0.1", self.target)) as server:
                while True:
                    head, request = receive(client)
                    if request[0] in (WRITE_ONE, WRITE):
                        self.writes.append((struct.unpack(">H", request[1:3])[0], request[3:] if request[0] == WRITE_ONE
                                            else request[6:]))
                    answer = self.answer(request)
                    if answer is None:
                        request_on = self.change_request(request)
                        server.sendall(head + request_on)
                        head, answer = receive(server)
                        answer = self.change_answer(request, answer)
                    client.sendall(head[:4] + struct.pack(">H", len(answer) + 1) + head[6:] + answer)
        except OSError:
            pass


def receive(end):
    """Head and body of a frame."""
    head = receive_exactly(end, 7)
    return head, receive_exactly(end, struct.unpack(">H", head[4:6])[0] - 1)


def receive_exactly(end, count):
    data = b""
    while len(data) < count:
        more = end.recv(count - len(data))
        if not more:
            raise OSError("closed")
        data += more
    return data


def reads(request, register):
    """Whether the request asks for that register, alone or in a block."""
    first, count = struct.unpack(">HH", request[1:5])
    return request[0] == READ and first <= register < first + count


def refuses(register):
    """An answer that refuses to write the register (exception 3)."""
    def answer(request):
        written = request[0] in (WRITE_ONE, WRITE) and struct.unpack(">H", request[1:3])[0] == register
        return bytes([request[0] | 0x80, ILLEGAL_VALUE]) if written else None
    return answer


def forgets(register):
    """An answer that takes what is written to the register, and changes nothing."""
    def answer(request):
        written = request[0] in (WRITE_ONE, WRITE) and struct.unpack(">H", request[1:3])[0] == register
        return request[:5] if written else None
    return answer


def says_so_and_goes_on(register, value, times):
    """An answer of a device whose register takes `value` so many times and says so, while what is behind it goes on as before."""
    taken = 0

    def answer(request):
        nonlocal taken
        if request == struct.pack(">BHH", WRITE_ONE, register, value) and taken < times:
            taken += 1
            return request
        if request == struct.pack(">BHH", READ, register, 1) and taken > 0:
            return struct.pack(">BBH", READ, 2, value)
        return None
    return answer


def with_read_f32(register, change):
    """A change of answers: the float (low word first) that begins at `register` reads change(value), in whatever block."""
    def changed(request, answer):
        if request[0] != READ or answer[0] != READ:
            return answer
        first, count = struct.unpack(">HH", request[1:5])
        at = 2 + 2 * (register - first)
        if register < first or register + 2 > first + count:
            return answer
        low, high = struct.unpack(">HH", answer[at:at + 4])
        value, = struct.unpack(">f", struct.pack(">HH", high, low))
        high, low = struct.unpack(">HH", struct.pack(">f", change(value)))
        return answer[:at] + struct.pack(">HH", low, high) + answer[at + 4:]
    return changed


def with_written_f32(register, change):
    """A change of requests: the float that is written to `register` alone becomes change(value)."""
    def changed(request):
        if request[0] != WRITE or request[1:5] != struct.pack(">HH", register, 2):
            return request
        low, high = struct.unpack(">HH", request[6:10])
        value, = struct.unpack(">f", struct.pack(">HH", high, low))
        high, low = struct.unpack(">HH", struct.pack(">f", change(value)))
        return request[:6] + struct.pack(">HH", low, high)
    return changed
