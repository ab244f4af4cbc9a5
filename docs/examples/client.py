# SPDX-License-Identifier: Apache-2.0
"""Fits a unit on a station and saves its report, over the HTTP interface (docs/openapi.yaml), with Python's own library.

    python3 client.py http://127.0.0.1:8088 SN0042 --user Eva

A station that others may reach asks for a token ('soak user token' makes one; its account is then the name in the log) and has a
certificate of its own:

    python3 client.py https://soak.lab.example:8088 SN0042 --token-file nightly.token --certificate soakd.crt
"""
import argparse
import json
import pathlib
import ssl
import sys
import time
import urllib.error
import urllib.parse
import urllib.request


class Station:
    """A station at its address. Calls raise RuntimeError with the station's own words where it refuses, and where it does not answer."""

    def __init__(self, address, token=None, certificate=None):
        self.address = address.rstrip("/") + "/api/v1/"
        self.headers = {"Content-Type": "application/json", **({"Authorization": f"Bearer {token}"} if token else {})}
        self.trust = ssl.create_default_context(cafile=certificate)

    def get(self, path, **parameters):
        return json.loads(self.ask(f"{path}?{urllib.parse.urlencode(parameters)}"))

    def post(self, path, **body):
        return json.loads(self.ask(path, json.dumps(body).encode()))

    def ask(self, path, body=None):
        request = urllib.request.Request(self.address + path, body, self.headers)
        try:
            with urllib.request.urlopen(request, timeout=60, context=self.trust) as answer:
                return answer.read()
        except urllib.error.HTTPError as refusal:
            error = json.load(refusal)["error"]
            raise RuntimeError(": ".join(filter(None, (error["where"], error["message"])))) from None
        except OSError as failure:
            raise RuntimeError(f"the station does not answer at {self.address}: {getattr(failure, 'reason', failure)}") from None

    def carry_out(self, **job):
        """Starts a job and waits for its end."""
        document = self.post("jobs", **job)
        while document["state"] == "running":
            time.sleep(0.5)
            document = self.get("job", id=document["id"])
        if document["state"] != "done":
            raise RuntimeError(f"{job['kind']} of {job['unit']} {document['state']}: {document['message']}")
        return document


def main():
    parser = argparse.ArgumentParser(description="Fit a unit and save its report.")
    parser.add_argument("address")
    parser.add_argument("unit", help="serial number")
    parser.add_argument("--user", default="client.py", help="your name, for the event log")
    parser.add_argument("--token-file", type=pathlib.Path, help="file with the token of an account")
    parser.add_argument("--certificate", help="file with the station's certificate (PEM), where it made one itself")
    arguments = parser.parse_args()
    token = arguments.token_file.read_text(encoding="utf-8").strip() if arguments.token_file else None
    station = Station(arguments.address, token, arguments.certificate)
    who = {"unit": arguments.unit, "user": arguments.user}
    try:
        status = station.get("status")
        print(f"Soak {status['version']}, {status['state']}")
        print(f"model {station.carry_out(kind='fit', **who)['result']['model']}")
        report = station.carry_out(kind="report", **who)
        page = pathlib.Path(report["file"]["name"])
        page.write_bytes(station.ask(f"job/file?id={report['id']}"))
        print(f"{page}: {report['result']['verdict']}")
    except RuntimeError as failure:
        sys.exit(str(failure))


if __name__ == "__main__":
    main()
