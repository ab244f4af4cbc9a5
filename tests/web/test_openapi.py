# SPDX-License-Identifier: Apache-2.0
"""docs/openapi.yaml against a real `soakd`: it has every path that the server answers to and no other, the answers are as their
schemas say, and what is refused is what it does not allow."""
import json
import pathlib
import re
import socket
import subprocess
import sys
import unittest
import urllib.error
import urllib.parse
import urllib.request

import jsonschema
import yaml

import test_units
from page_test import Station
from test_units import SERIAL, UnitStation

ROOT = pathlib.Path(__file__).resolve().parents[2]
FILE = ROOT / "docs" / "openapi.yaml"
DOCUMENT = yaml.safe_load(FILE.read_text(encoding="utf-8"))
RESOLVER = jsonschema.RefResolver(FILE.as_uri(), DOCUMENT)
PAGE = "/([^/]*)"  # the pattern of the server for the page and its files
JSON = "application/json"

tearDownModule = test_units.tearDownModule


def resolved(node):
    while "$ref" in node:
        node = {**RESOLVER.resolve(node["$ref"])[1], **{key: value for key, value in node.items() if key != "$ref"}}
    return node


def check(document, schema):
    jsonschema.Draft202012Validator(schema, resolver=RESOLVER).validate(document)


# Only where the station asks who one is: tests/web/test_access.py.
GUARDED = {("POST", "/api/v1/login"), ("POST", "/api/v1/logout")}
EVERY = {(method.upper(), path): operation for path, item in DOCUMENT["paths"].items() for method, operation in item.items()}
# Only before the station is set up: tests/web/test_setup.py.
SETUP = {key for key, operation in EVERY.items() if operation["tags"] == ["setup"]}
OPERATIONS = {key: operation for key, operation in EVERY.items() if key not in GUARDED | SETUP}


def parameters_of(operation, place="query"):
    found = [resolved(parameter) for parameter in operation.get("parameters", [])]
    return {parameter["name"]: {**parameter, "schema": resolved(parameter["schema"])} for parameter in found if parameter["in"] == place}


def body_of(operation):
    return resolved(operation["requestBody"])["content"][JSON]["schema"]


def wrong_values(schema):
    """Values of a JSON member that its schema does not allow."""
    kinds = schema.get("type", "enum")
    kinds = [kinds] if isinstance(kinds, str) else kinds
    if "enum" in schema:
        yield "no such word"
    yield {"string": 5, "integer": "x", "number": "x", "boolean": "x", "array": "x", "object": [], "enum": 5}[kinds[0]]
    if kinds[0] == "integer":
        yield 1.5
    if "minimum" in schema:
        yield schema["minimum"] - 1
    if "maxLength" in schema:
        yield "x" * (schema["maxLength"] + 1)
    if schema.get("minLength"):
        yield ""
    if "pattern" in schema:
        yield "x"


def wrong_words(schema):
    """The same for a parameter: lists of the texts that are given for it."""
    if schema["type"] == "array":
        yield [f"channel_{i}" for i in range(schema["maxItems"] + 1)]
        return
    yield {"integer": ["x"], "number": ["x"], "string": [""]}[schema["type"]]
    yield ["1", "2"]  # given twice
    if "pattern" in schema:
        yield ["x"]
    for key, step in (("minimum", -1), ("maximum", 1)):
        if key in schema:
            yield [str(schema[key] + step)]


class OpenApi(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.soakd = UnitStation()
        cls.addClassCleanup(cls.soakd.close)
        cls.soakd.soak("reference", "add", "--kind", "level", "--name", "level 7", "--certificate", "N-7", "--issued", "2020-01-01", "--due", "2097-03-01", "--uncertainty", "0.0002")

    def ask(self, path, body=None, url=None, **parameters):
        """Status, type and bytes of the answer."""
        question = urllib.parse.urlencode(parameters, doseq=True)
        request = urllib.request.Request((url or self.soakd.url).rstrip("/") + path + (f"?{question}" if question else ""),
                                         None if body is None else json.dumps(body).encode(), {} if body is None else {"Content-Type": JSON})
        try:
            answer = urllib.request.urlopen(request, timeout=60)
        except urllib.error.HTTPError as refusal:
            answer = refusal
        with answer:
            kind = answer.headers.get_content_type()
            return answer.status, kind, answer.read() if kind != "text/event-stream" else self.first_event(answer)

    @staticmethod
    def first_event(stream):
        """The document of the first event."""
        while not (line := stream.readline()).startswith(b"data: "):
            assert line
        return line[6:]

    def check_answer(self, operation, status, kind, content):
        self.assertIn(str(status), operation["responses"])
        allowed = resolved(operation["responses"][str(status)])["content"]
        self.assertIn(kind, allowed)
        if kind == JSON:
            check(json.loads(content), allowed[kind]["schema"])

    def refusal(self, operation, *arguments, **parameters):
        """(status, where)"""
        status, kind, content = self.ask(*arguments, **parameters)
        self.check_answer(operation, status, kind, content)
        return status, json.loads(content)["error"]["where"]

    def example_values(self):
        """Of the parameters: for what the station holds."""
        run = self.soakd.get("runs", unit=SERIAL, campaign="campaign")["runs"][0]["run_id"]
        channels = [channel["name"] for channel in self.soakd.get("run", run=run, unit=SERIAL)["streams"][0]["channels"]]
        return {"unit": SERIAL, "campaign": "campaign", "run": run, "channel": channels[:2], "stream": "imu", "from_s": 1, "to_s": 1e6, "points": 10,
                "after_s": 0, "around": 0, "after": -5, "file": "app.mjs", "type": "generic", "kind": "run_added", "subject": SERIAL, "user": "Eva",
                "from_utc_s": 0, "to_utc_s": 4e9, "before": 10 ** 6, "most": 10, "version": 1, "format": "json", "simulated": "true", "about": SERIAL, "routine": "false",
                "record_id": self.soakd.get("references")["references"][0]["record_id"]}

    # ---- the document

    def test_it_is_an_openapi_document(self):
        self.assertEqual(DOCUMENT["openapi"], "3.1.0")
        self.assertLessEqual({"title", "version"}, set(DOCUMENT["info"]))
        names = [operation["operationId"] for operation in EVERY.values()]
        self.assertEqual(len(names), len(set(names)))
        tags = {tag["name"] for tag in DOCUMENT["tags"]}
        for (method, path), operation in EVERY.items():
            with self.subTest(method=method, path=path):
                self.assertLessEqual(set(operation["tags"]), tags)
                self.assertEqual(set(parameters_of(operation, "path")), set(re.findall(r"{(\w+)}", path)))
                self.assertEqual("requestBody" in operation, method == "POST")
                for status, answer in operation["responses"].items():
                    self.assertRegex(status, r"^(\d\d\d|default)$")
                    self.assertTrue(resolved(answer)["description"])
                    for media in resolved(answer).get("content", {}).values():
                        jsonschema.Draft202012Validator.check_schema(resolved(media.get("schema", {})))
                if method == "POST":
                    jsonschema.Draft202012Validator.check_schema(body_of(operation))

    def test_it_has_what_the_server_answers_to_and_nothing_else(self):
        station = Station()
        self.addCleanup(station.close)
        routes = set(json.loads(station.tell("routes")[0]))
        self.assertGreater(len(routes), 20)
        described = {f"{method} {path}" for method, path in OPERATIONS}
        self.assertLessEqual({"GET /", "GET /{file}"}, described)
        self.assertEqual((described - {"GET /", "GET /{file}"}) | {f"GET {PAGE}"}, routes)

    def test_a_station_without_accounts_has_no_log_in(self):
        for _, path in GUARDED:
            status, _, _ = self.ask(path, {"name": "eva", "password": "x"})
            self.assertEqual(status, 404)

    def test_a_station_that_is_set_up_cannot_be_set_up_again(self):
        self.assertGreater(len(SETUP), 4)
        for method, path in SETUP:
            status, _, _ = self.ask(path, {} if method == "POST" else None)
            self.assertEqual(status, 404, path)

    def test_the_page_of_the_interface_names_every_path(self):
        text = (ROOT / "docs" / "http-api.md").read_text(encoding="utf-8")
        for method, path in EVERY:
            name = path.removeprefix("/api/v1/").removeprefix("campaign/") if method == "POST" else path
            with self.subTest(method=method, path=path):
                self.assertTrue(f"`{name}`" in text or f"`{path}" in text or f"{method} {path}`" in text or path == "/{file}")

    # ---- answers

    def test_answers_are_as_described(self):
        values = self.example_values()
        done = self.carried_out(kind="fit", unit=SERIAL)
        self.assertEqual(done["state"], "done", done["message"])
        verified = self.carried_out(kind="verify", unit=SERIAL, campaign="verification")
        self.assertEqual(verified["state"], "done", verified["message"])
        released = self.carried_out(kind="release", unit=SERIAL)
        self.assertEqual(released["state"], "done", released["message"])
        values["id"] = self.carried_out(kind="export", unit=SERIAL, format="blob", simulated=True)["id"]
        for (method, path), operation in OPERATIONS.items():
            if method != "GET" or operation["operationId"] == "noise":  # no campaign runs here
                continue
            with self.subTest(path=path):
                parameters = {name: values[name] for name in parameters_of(operation)}
                status, kind, content = self.ask(path.replace("{file}", values["file"]), **parameters)
                self.assertEqual(status, 200, content[:300])
                self.check_answer(operation, status, kind, content)
                if kind == "text/event-stream":
                    check(json.loads(content), {"$ref": "schema/campaign-status.schema.json"})

    def carried_out(self, **job):
        """A job at its end."""
        operation = OPERATIONS["POST", "/api/v1/jobs"]
        check(job, body_of(operation))
        status, kind, content = self.ask("/api/v1/jobs", job)
        self.check_answer(operation, status, kind, content)
        return self.soakd.ended(json.loads(content))

    def test_commands_are_answered_as_described(self):
        station = Station()
        self.addCleanup(station.close)
        bodies = {"campaign": "c", "procedure_text": "x = 1", "units": {"1": "SN1"}, "prompt": 1, "reason": "test", "user": "Eva"}
        for (method, path), operation in OPERATIONS.items():
            if not path.startswith("/api/v1/campaign/"):
                continue
            body = {name: value for name, value in bodies.items() if name in body_of(operation)["properties"]}
            with self.subTest(path=path):
                check(body, body_of(operation))
                status, kind, content = self.ask(path, body, station.url)
                self.assertEqual(status, 200, content)
                self.check_answer(operation, status, kind, content)
                for code, expected in ((2, 409), (3, 502)):
                    station.tell(f"fail {code} state")
                    self.assertEqual(self.refusal(operation, path, body, station.url), (expected, "state"))

    # ---- refusals

    def test_parameters_that_it_does_not_allow_are_refused_by_name(self):
        values = {**self.example_values(), "id": 1}
        for (method, path), operation in OPERATIONS.items():
            if method != "GET" or "400" not in operation["responses"]:
                continue
            known = parameters_of(operation)
            right = {name: values[name] for name in known}
            with self.subTest(path=path):
                self.assertEqual(self.refusal(operation, path, **right, no_such="1"), (400, "no_such"))
            for name, parameter in known.items():
                others = {other: value for other, value in right.items() if other != name}
                if parameter.get("required"):
                    with self.subTest(path=path, missing=name):
                        self.assertEqual(self.refusal(operation, path, **others), (400, name))
                for words in wrong_words(parameter["schema"]):
                    with self.subTest(path=path, name=name, given=words):
                        self.assertEqual(self.refusal(operation, path, **others, **{name: words}), (400, name))

    def test_bodies_that_it_does_not_allow_are_refused_by_the_name_of_the_member(self):
        run = self.example_values()["run"]
        values = {"campaign": "verification", "procedure_text": "x = 1", "procedure_file": "a.toml", "units": {}, "prompt": 1, "reason": "test", "run": run, "unit": SERIAL,
                  "visit": 0, "position": "+X", "attempt": 0, "kind": "export", "format": "blob", "model": 1, "simulated": True, "id": 10 ** 6, "user": "Eva", "type": "generic", "record_id": run, "name": "level 1", "certificate": "L-7", "issued": "2026-01-01",
                  "due": "2099-01-01", "uncertainty": 0.01, "k": 2, "correction": 0.0, "effects": [], "sign": False, "accel_id": 1310988, "gyro_id": 77, "comment": "Laboratory 1", "from": "verification.toml", "set_points_c": [0, 20], "runs": 2, "dwell_s": 60, "minimum_soak_s": 60, "draft": True,
                  "revision": "of another file", "chamber": {}, "fixture": {}, "power": {}, "purge": {}, "unit_type": "generic", "decoder": "xsens", "slots": [], "site": {}, "room": {}, "mail": {}, "webhook": {}}
        for (method, path), operation in OPERATIONS.items():
            if method != "POST":
                continue
            schema = resolved(body_of(operation))
            right = {name: values[name] for name in schema["properties"]}
            if path == "/api/v1/references/add":
                right["kind"] = "level"
            if path == "/api/v1/procedures/new":
                right["name"] = "between"
            check(right, schema)
            with self.subTest(path=path):
                self.assertEqual(self.refusal(operation, path, {**right, "no_such": 1}), (400, "no_such"))
            for name in schema["properties"]:
                others = {other: value for other, value in right.items() if other != name}
                if name in schema.get("required", []):
                    with self.subTest(path=path, missing=name):
                        self.assertEqual(self.refusal(operation, path, others), (400, name))
                for value in wrong_values(resolved(schema["properties"][name])):
                    with self.subTest(path=path, name=name, value=value):
                        self.assertRaises(jsonschema.ValidationError, check, {**right, name: value}, schema)
                        self.assertEqual(self.refusal(operation, path, {**right, name: value}), (400, name))

    # ---- the example

    def test_the_client_of_the_docs_fits_a_unit_and_saves_its_report(self):
        client = [sys.executable, "-B", ROOT / "docs" / "examples" / "client.py", self.soakd.url]
        done = subprocess.run([*client, SERIAL, "--user", "Eva"], cwd=self.soakd.folder, capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertRegex(done.stdout, rf"^Soak \d\S*, idle\nmodel \d+\n{SERIAL}\.html: \w+\n$")
        self.assertIn(f"Unit {SERIAL}", (self.soakd.folder / f"{SERIAL}.html").read_text(encoding="utf-8"))
        refused = subprocess.run([*client, "nobody"], cwd=self.soakd.folder, capture_output=True, text=True)
        self.assertEqual((refused.returncode, refused.stdout.splitlines()[1:]), (1, []))
        self.assertIn("unit: there is no such unit", refused.stderr)

    def test_the_client_says_in_words_that_no_station_answers(self):
        with socket.socket() as probe:  # a port at which nothing answers
            probe.bind(("127.0.0.1", 0))
            address = f"http://127.0.0.1:{probe.getsockname()[1]}"
            done = subprocess.run([sys.executable, "-B", ROOT / "docs" / "examples" / "client.py", address, SERIAL], capture_output=True, text=True)
        self.assertEqual((done.returncode, done.stdout), (1, ""))
        self.assertRegex(done.stderr, rf"^the station does not answer at {address}/api/v1/: .*refused\n$")


if __name__ == "__main__":
    unittest.main()
