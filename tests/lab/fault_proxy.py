# SPDX-License-Identifier: Apache-2.0
"""A wire that can be cut: hands bytes on between a client and a server on 127.0.0.1."""
import socket
import threading


class FaultProxy:
    """Listens on `port` (0: any) and connects each client with `target`."""

    def __init__(self, target):
        self.target = target
        self.mode = "whole"
        self.lost = threading.Event()  # bytes came to a wire that is not whole
        self._pairs = []
        self._lock = threading.Lock()
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.port = self._listener.getsockname()[1]
        threading.Thread(target=self._accept, daemon=True).start()

    def cut(self):
        """The peer is gone: connections end, new ones end at once."""
        self._change("cut")

    def silence(self):
        """The wire is dead: connections stay, no byte passes any more."""
        self._change("silent")

    def mend(self):
        self._change("whole")

    def change(self, data):
        """What is handed on of bytes that came, in either direction: a wire that lies has its own."""
        return data

    def close(self):
        self.cut()
        self._listener.close()

    def _change(self, mode):
        with self._lock:
            self.mode = mode
            # A connection that has lost bytes is of no use any more, whatever comes.
            pairs, self._pairs = self._pairs, [] if mode != "silent" else self._pairs
        if mode != "silent":
            for pair in pairs:
                for end in pair:
                    _end(end)

    def _accept(self):
        while True:
            try:
                client, _ = self._listener.accept()
            except OSError:
                return
            with self._lock:
                if self.mode == "cut":
                    _end(client)
                    continue
                try:
                    server = socket.create_connection(("127.0.0.1", self.target))
                except OSError:
                    _end(client)
                    continue
                self._pairs.append((client, server))
            for source, sink in ((client, server), (server, client)):
                threading.Thread(target=self._hand_on, args=(source, sink), daemon=True).start()

    def _hand_on(self, source, sink):
        try:
            while data := source.recv(65536):
                # What comes into a dead wire is taken and lost: a sender that waits for its reader goes on.
                if self.mode == "whole":
                    sink.sendall(self.change(data))
                else:
                    self.lost.set()
        except OSError:
            pass
        _end(source)
        _end(sink)


def _end(end):
    try:
        end.shutdown(socket.SHUT_RDWR)
    except OSError:
        pass
    end.close()
