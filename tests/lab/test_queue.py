# SPDX-License-Identifier: Apache-2.0
"""Campaigns that are queued: they begin one after another, and wait for somebody where the one before did not finish."""
import contextlib
import json
import pathlib
import sqlite3
import urllib.error
import urllib.request

import bench
from bench import AUTO, LabTest, long_test, short_procedure

MODE = 2730  # register of the controller: control mode
NOTICE_S = 300.0  # of process time before a campaign begins by itself
SLOW = 50  # rate at which the notice takes six seconds: what is to happen in it can


class Queue(LabTest):
    def queue(self, name, procedure=None, user="paula"):
        path = self.write(f"{name}.toml", procedure or short_procedure())
        return self.lab.soak_json("campaign", "start", path, "--name", name, "--queue", "--user", user)

    def post(self, command, **body):
        request = urllib.request.Request(self.lab.page + "api/v1/campaign/" + command, json.dumps({"user": "eva", **body}).encode(),
                                         {"Content-Type": "application/json"})
        urllib.request.urlopen(request, timeout=60).close()

    def waiting(self):
        document = self.lab.soak_json("campaign", "queue")
        self.check_schema(document, "campaign-queue")
        return [campaign["name"] for campaign in document["campaigns"]], document["waits_for"]

    def begin_two(self, rate, cut=()):
        """The first one runs, the second one waits for it."""
        self.start_lab(rate=rate, cut=cut)
        self.start_campaign(short_procedure(), "a")
        self.assertEqual(self.queue("b")["before"], 1)
        self.assertEqual(self.waiting(), (["b"], "campaign"))

    def wait_for_state(self, name, state):
        return self.wait(f"{name} {state}", lambda s: s["campaign"] and s["campaign"]["name"] == name and s["state"] == state, lab_s=1.0)

    def expect_states(self, *states):
        """Of the campaigns in the journal, which is written beside the engine."""
        def written(_):
            return self.query("SELECT campaign, state FROM journal ORDER BY campaign") == list(states)
        self.wait(f"the journal: {states}", written, seconds=60.0, lab_s=10.0)

    def assert_waits_for_somebody(self, state):
        """Nothing begins for twice the notice."""
        status = self.status()
        self.assertEqual((status["state"], status["queue"]["waits_for"]), (state, "somebody"))
        self.assertIsNone(status["queue"]["begins_utc_s"])
        begun_s = status["clock"]["process_s"]
        self.wait("ten minutes", lambda s: s["clock"]["process_s"] > begun_s + 2 * NOTICE_S or s["state"] != state)
        self.assertEqual(self.status()["state"], state)

    def begins(self):
        """Host time at which each campaign began, in the journal's words for its end when it ended."""
        return {name: (begun, ended) for name, begun, ended in
                self.query("SELECT campaign, created_utc_s, updated_utc_s FROM journal")}

    def test_campaigns_begin_one_after_another_in_the_order_in_which_they_were_queued(self):
        rate = 400
        self.begin_two(rate)
        self.assertEqual(self.queue("c")["before"], 2)
        self.assertEqual(self.queue("d")["before"], 3)
        self.lab.soak("campaign", "unqueue", "c")
        self.assertEqual(self.waiting(), (["b", "d"], "campaign"))
        with urllib.request.urlopen(self.lab.page + "metrics", timeout=30) as answer:
            self.assertIn("\nsoak_queue_campaigns 2\n", answer.read().decode())
        self.wait_for_state("d", "finished")
        self.expect_states(("a", "finished"), ("b", "finished"), ("d", "finished"))
        self.assertEqual(self.waiting(), ([], None))
        times = self.begins()
        for before, after in (("a", "b"), ("b", "d")):
            self.assertGreater(rate * (times[after][0] - times[before][1]), 0.95 * NOTICE_S, "people have their time to stop it")
        self.assert_safe()

    @long_test
    def test_the_status_names_the_time_and_an_abort_before_it_stops_the_next_one(self):
        self.begin_two(SLOW)
        status = self.wait_for_state("a", "finished")
        self.assertEqual(status["queue"]["waits_for"], "time")
        self.assertGreater(status["queue"]["begins_utc_s"], status["clock"]["utc_s"])
        self.check_schema(status, "campaign-status")
        self.post("abort", reason="the units are to be changed")
        self.assert_waits_for_somebody("finished")
        self.assertEqual(self.waiting(), (["b"], "somebody"))

    @long_test
    def test_after_an_abort_the_queue_waits_whatever_finishes_until_somebody_lets_it_go_on(self):
        self.begin_two(400)
        self.lab.soak("campaign", "abort", "--reason", "a cable is loose")
        self.wait("the safe state", lambda s: s["state"] == "aborted")
        self.assert_waits_for_somebody("aborted")
        self.assertEqual(self.queue("c")["before"], 1)
        self.start_campaign(short_procedure(), "meanwhile")
        self.wait_for_state("meanwhile", "finished")
        self.assert_waits_for_somebody("finished")
        with self.assertRaises(urllib.error.HTTPError) as refused:
            self.post("next", campaign="c")
        self.assertEqual(refused.exception.code, 409)
        refused.exception.close()
        self.lab.soak("campaign", "next")
        self.wait_for_state("c", "finished")
        self.expect_states(("a", "aborted"), ("b", "finished"), ("c", "finished"), ("meanwhile", "finished"))
        self.soak_fails(2, "campaign", "next")

    @long_test
    def test_on_a_station_that_has_nothing_to_do_it_waits_for_somebody(self):
        self.start_lab(rate=400)
        self.assertEqual(self.queue("a")["before"], 0)
        self.assert_waits_for_somebody("idle")
        self.lab.soak("campaign", "next")
        self.wait_for_state("a", "finished")

    @long_test
    def test_the_queue_outlives_a_killed_soakd_and_goes_on_behind_the_resumed_campaign(self):
        self.begin_two(400)
        self.wait_for_step("record")
        self.lab.soakd.kill()
        self.lab.soakd.wait()
        self.lab.soakd.stdout.close()
        self.lab.start_soakd()
        self.wait("the safe state", lambda s: s["state"] == "interrupted")
        self.assert_waits_for_somebody("interrupted")
        self.lab.soak("campaign", "resume")
        self.assertEqual(self.waiting(), (["b"], "campaign"))
        self.wait_for_state("b", "finished")
        self.expect_states(("a", "finished"), ("b", "finished"))

    def author_in_runs(self, campaign):
        """What the run files of a campaign say of who began it."""
        files = self.query(f"SELECT DISTINCT file_name, created_utc_s FROM run WHERE campaign = '{campaign}' ORDER BY created_utc_s")
        authors = []
        for file, _ in files:
            with contextlib.closing(sqlite3.connect(f"file:{pathlib.Path(self.lab.data) / 'runs' / file}?mode=ro", uri=True)) as run:
                authors += [text for (text,) in run.execute("SELECT text FROM event WHERE kind = 'begun'")]
        return authors

    @long_test
    def test_a_campaign_of_the_queue_keeps_who_put_it_there_whoever_begins_it(self):
        self.start_lab(rate=2000)
        self.queue("a")
        self.queue("b", user="quentin")
        self.lab.soak("campaign", "next", "--user", "rita")
        self.wait_for_state("b", "finished")
        self.expect_states(("a", "finished"), ("b", "finished"))
        self.assert_event("campaign", "a", "started by rita, queued by paula")
        self.assert_event("campaign", "b", "started by soakd, queued by quentin")
        documents = dict(self.query("SELECT campaign, document FROM journal"))
        self.assertEqual({name: json.loads(text)["queued_by"] for name, text in documents.items()}, {"a": "paula", "b": "quentin"})
        self.wait("the runs", lambda _: len(self.author_in_runs("b")) == 1, lab_s=10.0)
        self.assertEqual(self.author_in_runs("a"), ["by rita, queued by paula"])
        self.assertEqual(self.author_in_runs("b"), ["by soakd, queued by quentin"])

    @long_test
    def test_nothing_begins_by_itself_after_a_restart_though_the_last_campaign_had_finished(self):
        self.begin_two(SLOW)
        self.wait_for_state("a", "finished")
        bench.end(self.lab.soakd)
        self.lab.start_soakd()
        self.assert_waits_for_somebody("idle")

    def test_nothing_begins_in_a_chamber_that_somebody_uses(self):
        self.begin_two(SLOW)
        chamber = self.modbus("chamber")
        self.wait_for_state("a", "finished")
        chamber.write_register(MODE, AUTO, 1)
        status = self.wait("the refusal", lambda s: s["queue"]["trouble"] is not None)
        self.assertEqual((status["state"], status["queue"]["waits_for"]), ("finished", "somebody"))
        self.assertEqual(self.chamber()[0], AUTO, "it is left as it is")

    @long_test
    def test_a_chamber_that_was_silent_gives_notice_again_before_the_next_one_begins(self):
        self.begin_two(SLOW, cut=("chamber",))
        self.wait_for_state("a", "finished")
        self.proxies["chamber"].cut()
        status = self.wait("the first try", lambda s: s["queue"]["trouble"] is not None)
        self.assertEqual((status["state"], status["queue"]["waits_for"]), ("finished", "time"))
        self.assertGreater(status["queue"]["begins_utc_s"], status["clock"]["utc_s"])
        self.proxies["chamber"].mend()
        answered_s = self.wait("an answer", lambda s: s["queue"]["trouble"] is None)["clock"]["process_s"]
        begun_s = self.wait("the begin", lambda s: s["campaign"]["name"] == "b")["clock"]["process_s"]
        self.assertGreater(begun_s - answered_s, 0.8 * NOTICE_S)

    def test_what_cannot_begin_is_refused_when_it_is_queued(self):
        self.begin_two(SLOW)
        bad = self.write("bad.toml", short_procedure().replace("[temperatures]", "[temperature]"))
        good = self.write("good.toml", short_procedure())
        self.soak_fails(2, "campaign", "start", bad, "--name", "x", "--queue")
        for name in ("a", "b"):
            self.soak_fails(2, "campaign", "start", good, "--name", name, "--queue")
        self.soak_fails(2, "campaign", "start", good, "--name", "x", "--queue", "--unit", "99=SN1")
        hot = self.write("hot.toml", short_procedure(set_points=(25, 150)))
        self.soak_fails(2, "campaign", "start", hot, "--name", "x", "--queue")
        self.soak_fails(2, "campaign", "start", good, "--name", "b")
        self.soak_fails(2, "campaign", "unqueue", "x")
        self.soak_fails(2, "campaign", "next")  # one is under way
        self.assertEqual(self.waiting(), (["b"], "campaign"))

    def test_a_queue_that_cannot_be_read_is_kept_aside(self):
        self.start_lab(rate=400)
        self.queue("b")
        bench.end(self.lab.soakd)
        path = pathlib.Path(self.lab.data) / "soakd.queue"
        self.assertEqual([c["campaign"] for c in json.loads(path.read_text(encoding="utf-8"))["campaigns"]], ["b"])
        path.write_text('{"campaigns": [{"campaign": "b"}]}', encoding="utf-8")
        self.lab.start_soakd()
        self.assertEqual(self.waiting()[0], [])
        self.assertTrue(path.with_name("soakd.queue.damaged").exists())
        self.assert_event("campaign", "queue", "soakd.queue.damaged")


if __name__ == "__main__":
    bench.main()
