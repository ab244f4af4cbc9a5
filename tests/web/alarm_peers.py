# SPDX-License-Identifier: Apache-2.0
"""A mail server (Debian's python3-aiosmtpd) and a webhook in a process of their own, as a program:
    alarm_peers.py [--tls CERTIFICATE KEY] [--mail-port PORT]
prints {"mail": PORT, "webhook": PORT}, then one line of JSON for each message and each request. With --tls the mail server offers
STARTTLS and takes mail only after it, and only from soak with the password "correct horse". There is no mailbox gone@lab.example. A webhook
whose path is /refuses answers 404, and repeats what it was sent."""
import argparse
import http.server
import json
import socket
import ssl
import sys
import threading

from aiosmtpd.controller import Controller
from aiosmtpd.smtp import AuthResult

PASSWORD = b"correct horse"
lock = threading.Lock()


def tell(**document):
    with lock:
        print(json.dumps(document), flush=True)


class Mailbox:
    async def handle_RCPT(self, server, session, envelope, address, options):
        if address.startswith("gone@"):
            return "550 no such mailbox"
        envelope.rcpt_tos.append(address)
        return "250 taken"

    async def handle_DATA(self, server, session, envelope):
        tell(kind="mail", sender=envelope.mail_from, to=envelope.rcpt_tos, content=envelope.content.decode("ascii"), tls=session.ssl is not None,
             authenticated=session.authenticated)
        return "250 taken"


def is_known(server, session, envelope, mechanism, data):
    right = data.login == b"soak" and data.password == PASSWORD
    tell(kind="log-in", right=right, tls=session.ssl is not None)
    return AuthResult(success=right)


class Hook(http.server.BaseHTTPRequestHandler):
    def do_POST(self):
        body = self.rfile.read(int(self.headers["Content-Length"]))
        tell(kind="webhook", path=self.path, type=self.headers["Content-Type"], authorization=self.headers["Authorization"], body=body.decode())
        refuses = self.path == "/refuses"
        self.send_response(404 if refuses else 204)
        self.end_headers()
        if refuses:
            self.wfile.write(f"no {self.path} for {self.headers['Authorization']}".encode())

    def log_message(self, *_):
        pass


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--tls", nargs=2)
    parser.add_argument("--mail-port", type=int, default=0)
    options = parser.parse_args()
    more = {}
    if options.tls:
        context = ssl.create_default_context(ssl.Purpose.CLIENT_AUTH)
        context.load_cert_chain(*options.tls)
        more = {"tls_context": context, "require_starttls": True, "authenticator": is_known, "auth_required": True}
    # Its own choice of a free port is not told: the controller asks itself at the port that it was given.
    if options.mail_port == 0:
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            options.mail_port = probe.getsockname()[1]
    mail = Controller(Mailbox(), hostname="127.0.0.1", port=options.mail_port, **more)
    mail.start()
    hook = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Hook)
    threading.Thread(target=hook.serve_forever, daemon=True).start()
    tell(mail=options.mail_port, webhook=hook.server_address[1])
    sys.stdin.read()  # until whoever began it ends


if __name__ == "__main__":
    main()
