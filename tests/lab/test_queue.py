# SPDX-License-Identifier: Apache-2.0
"""Campaigns that are queued: they begin one after another, and wait for somebody where the one before did not finish."""
import json
import pathlib

import bench
from bench import AUTO, LabTest, short_procedure

MODE = 2730  # register of the controller: control mode


class Queue(LabTest):
    def queue(self, name, procedure=None):
        path = self.write(f"{name}.toml", procedure or short_procedure())
        return self.lab.soak_json("campaign", "start", path, "--name", name, "--queue")

    def waiting(self):
        document = self.lab.soak_json("campaign", "queue")
        self.check_schema(document, "campaign-queue")
        return [campaign["name"] for campaign in document["campaigns"]], document["waits_for"]

    def begin_two(self, rate):
        """The first one runs, the second one waits for it."""
        self.start_lab(rate=rate)
        self.assertEqual(self.queue("a")["before"], 0)
        self.assertEqual(self.queue("b")["before"], 1)
        self.assertEqual(self.waiting(), (["b"], "campaign"))

    def wait_for_finish(self, name):
        return self.wait(f"the end of {name}", lambda s: s["campaign"]["name"] == name and s["state"] == "finished", lab_s=20.0)

    def states(self):
        return self.query("SELECT campaign, state FROM journal ORDER BY campaign")

    def assert_waits_for_somebody(self, state):
        """Nothing begins for ten minutes of process time."""
        status = self.status()
        self.assertEqual((status["state"], status["queue"]["waits_for"]), (state, "somebody"))
        self.assertIsNone(status["queue"]["begins_utc_s"])
        begun_s = status["clock"]["process_s"]
        self.wait("ten minutes", lambda s: s["clock"]["process_s"] > begun_s + 600 or s["state"] != state)
        self.assertEqual(self.status()["state"], state)

    def test_campaigns_begin_one_after_another_in_the_order_in_which_they_were_queued(self):
        self.begin_two(rate=400)
        self.assertEqual(self.queue("c")["before"], 2)
        self.assertEqual(self.queue("d")["before"], 3)
        self.lab.soak("campaign", "unqueue", "c")
        self.assertEqual(self.waiting(), (["b", "d"], "campaign"))
        status = self.wait_for_finish("a")
        self.assertEqual(status["queue"]["waits_for"], "time")
        self.assertGreater(status["queue"]["begins_utc_s"], status["clock"]["utc_s"])
        self.check_schema(status, "campaign-status")
        ended_s = status["clock"]["process_s"]
        status = self.wait("the next one", lambda s: s["campaign"]["name"] == "b", lab_s=20.0)
        self.assertGreater(status["clock"]["process_s"], ended_s + 280.0, "people have five minutes to see it and to stop it")
        self.wait_for_finish("d")
        self.assertEqual(self.states(), [("a", "finished"), ("b", "finished"), ("d", "finished")])
        self.assertEqual(self.waiting(), ([], None))
        self.assert_safe()

    def test_after_an_abort_the_queue_waits_until_somebody_lets_it_go_on(self):
        self.begin_two(rate=400)
        self.lab.soak("campaign", "abort", "--reason", "a cable is loose")
        self.wait("the safe state", lambda s: s["state"] == "aborted")
        self.assert_waits_for_somebody("aborted")
        self.assertEqual(self.queue("c")["before"], 1, "behind the one that waits, though nothing runs")
        self.lab.soak("campaign", "next")
        self.wait_for_finish("c")
        self.assertEqual(self.states(), [("a", "aborted"), ("b", "finished"), ("c", "finished")])
        self.soak_fails(2, "campaign", "next")

    def test_an_abort_before_the_next_one_begins_stops_it(self):
        self.begin_two(rate=100)
        self.wait_for_finish("a")
        self.lab.soak("campaign", "abort", "--reason", "the units are to be changed")
        self.assert_waits_for_somebody("finished")
        self.assertEqual(self.waiting(), (["b"], "somebody"))

    def test_the_queue_outlives_a_killed_soakd_and_goes_on_behind_the_resumed_campaign(self):
        self.begin_two(rate=400)
        self.wait_for_step("record")
        self.lab.soakd.kill()
        self.lab.soakd.wait()
        self.lab.soakd.stdout.close()
        self.lab.start_soakd()
        self.wait("the safe state", lambda s: s["state"] == "interrupted")
        self.assert_waits_for_somebody("interrupted")
        self.lab.soak("campaign", "resume")
        self.assertEqual(self.waiting(), (["b"], "campaign"))
        self.wait_for_finish("b")
        self.assertEqual(self.states(), [("a", "finished"), ("b", "finished")])

    def test_nothing_begins_by_itself_after_a_restart_though_the_last_campaign_had_finished(self):
        self.begin_two(rate=100)
        self.wait_for_finish("a")
        bench.end(self.lab.soakd)
        self.lab.start_soakd()
        self.assert_waits_for_somebody("idle")

    def test_nothing_begins_in_a_chamber_that_somebody_uses(self):
        self.begin_two(rate=100)
        self.wait_for_finish("a")
        self.modbus("chamber").write_register(MODE, AUTO, 1)
        status = self.wait("the refusal", lambda s: s["queue"]["trouble"] is not None)
        self.assertEqual((status["state"], status["queue"]["waits_for"]), ("finished", "somebody"))
        self.assertEqual(self.chamber()[0], AUTO, "it is left as it is")

    def test_what_cannot_begin_is_refused_when_it_is_queued(self):
        self.begin_two(rate=100)
        bad = self.write("bad.toml", short_procedure().replace("[temperatures]", "[temperature]"))
        good = self.write("good.toml", short_procedure())
        self.soak_fails(2, "campaign", "start", bad, "--name", "x", "--queue")
        for name in ("a", "b"):
            self.soak_fails(2, "campaign", "start", good, "--name", name, "--queue")
        self.soak_fails(2, "campaign", "start", good, "--name", "x", "--queue", "--unit", "99=SN1")
        self.soak_fails(2, "campaign", "unqueue", "x")
        self.soak_fails(2, "campaign", "next")  # one is under way
        self.assertEqual(self.waiting(), (["b"], "campaign"))

    def test_a_queue_that_cannot_be_read_is_kept_aside(self):
        self.begin_two(rate=400)
        bench.end(self.lab.soakd)
        path = pathlib.Path(self.lab.data) / "soakd.queue"
        self.assertEqual([c["campaign"] for c in json.loads(path.read_text(encoding="utf-8"))["campaigns"]], ["b"])
        path.write_text('{"campaigns": [{"campaign": "b"}]}', encoding="utf-8")
        self.lab.start_soakd()
        self.assertEqual(self.waiting()[0], [])
        self.assertTrue(path.with_name("soakd.queue.damaged").exists())
        self.assertTrue(any("soakd.queue.damaged" in text for _, _, text in self.events()))


if __name__ == "__main__":
    bench.main()
