// SPDX-License-Identifier: Apache-2.0
// Jobs for the page: a process apart that takes nothing with it and leaves nothing behind.
#include "station/jobs/job_runner.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <future>
#include <nlohmann/json.hpp>
#include <thread>
#include <vector>

#include "station/io/text.h"
#include "tests/db/sample_catalog.h"
#include "tests/db/support.h"

namespace soak::station {
namespace {

using nlohmann::json;

ChildEnd shell(const std::string& script, const std::string& user = "Eva") {
  const std::atomic<bool> stop = false;
  const auto end = run_child({"/bin/sh", {"-c", script}, user}, stop);
  EXPECT_TRUE(end) << end.error().message;
  return end.value_or(ChildEnd{-1, "", ""});
}

TEST(JobProcess, GivesItsStatusAndWhatItSaidOnBothStreams) {
  const ChildEnd end = shell("echo out; echo err >&2; exit 5");
  EXPECT_EQ(end.exit_status, 5);
  EXPECT_EQ(end.output, "out\n");
  EXPECT_EQ(end.errors, "err\n");
  EXPECT_TRUE(end.is_whole);
  EXPECT_FALSE(end.stopped);
}

TEST(JobProcess, WorksInTheNameOfTheUserBehindEverybodyElse) {
  EXPECT_EQ(shell("echo $USER; nice", "Eva $(id)").output,
            "Eva $(id)\n" + std::to_string(std::min(19, ::getpriority(PRIO_PROCESS, 0) + 10)) + "\n");
}

TEST(JobProcess, HasNoneOfOurOpenFilesAndHearsTheSignalsThatWeBlock) {
  const int leak = ::open("/dev/zero", O_RDONLY);  // no O_CLOEXEC, as a library might have it
  sigset_t blocked;
  sigset_t before;
  sigemptyset(&blocked);
  sigaddset(&blocked, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &blocked, &before);
  // Of a child of the shell, which itself blocks all for a moment while it waits.
  const ChildEnd end =
      shell("ls -l /proc/$$/fd | grep -c zero; grep SigBlk /proc/self/status; kill -TERM $$; sleep 30");
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  ::close(leak);
  EXPECT_TRUE(end.output.starts_with("0\nSigBlk:\t0000000000000000")) << end.output;
  EXPECT_EQ(end.exit_status, 128 + SIGTERM);
}

TEST(JobProcess, WhatItSaysIsBounded) {
  const ChildEnd end = shell("head -c 40000000 /dev/zero; head -c 100000 /dev/zero >&2");
  EXPECT_EQ(end.exit_status, 0);
  EXPECT_EQ(end.output.size(), kMostOutput);
  EXPECT_EQ(end.errors.size(), kMostErrors);
  EXPECT_FALSE(end.is_whole);
}

/// Runs a script that makes the file `begun` once it is ready, and stops it then.
ChildEnd stopped_once_begun(const std::string& script) {
  const db::testing::TempFolder folder;
  const auto begun = folder.path() / "begun";
  std::atomic<bool> stop = false;
  std::atomic<bool> ended = false;
  const auto stopper = std::async(std::launch::async, [&] {
    while (!ended && !std::filesystem::exists(begun)) std::this_thread::sleep_for(std::chrono::milliseconds(5));
    stop = true;
  });
  const auto end = run_child({"/bin/sh", {"-c", script, begun.string()}, "Eva"}, stop);
  ended = true;
  EXPECT_TRUE(end) << end.error().message;
  return end.value_or(ChildEnd{-1, "", ""});
}

TEST(JobProcess, IsKilledWhenItIsToStopEvenIfItDoesNotListen) {
  const ChildEnd end = stopped_once_begun("trap '' TERM; : > \"$0\"; while :; do sleep 0.01; done");
  EXPECT_TRUE(end.stopped);
  EXPECT_EQ(end.exit_status, 128 + SIGKILL);
}

TEST(JobProcess, IsAskedToStopFirstAndMayReportWhatItHasDone) {
  const ChildEnd end =
      stopped_once_begun("trap 'echo committed; exit 0' TERM; echo begun; : > \"$0\"; while :; do sleep 0.01; done");
  EXPECT_TRUE(end.stopped);
  EXPECT_EQ(end.exit_status, 0);
  EXPECT_EQ(end.output, "begun\ncommitted\n");
}

TEST(JobProcess, AProgramThatIsNotThereIsAFailureThatNamesIt) {
  const std::atomic<bool> stop = false;
  const auto end = run_child({"/nowhere/soak", {}, "Eva"}, stop);
  ASSERT_FALSE(end);
  EXPECT_NE(end.error().message.find("/nowhere/soak"), std::string::npos);
}

TEST(Job, AFileNameIsMadeOfHarmlessCharacters) {
  EXPECT_EQ(plain_file_name("SN-0042_a.b"), "SN-0042_a.b");
  EXPECT_EQ(plain_file_name("../x"), "_.._x");
  EXPECT_EQ(plain_file_name("--help"), "_--help");
  EXPECT_EQ(plain_file_name("<a\"\r\nb>"), "_a___b_");
  EXPECT_EQ(plain_file_name(""), "_");
}

TEST(Job, TheMessageIsThatOfTheErrorBehindRemarks) {
  ChildEnd end{2, "",
               "soak: warning: {brace\n{\n  \"error\": {\"code\": 2, \"message\": \"no\", \"where\": \"--unit\"}\n}\n"};
  EXPECT_EQ(job_message(end), "--unit: no");
  end.errors = "==1==ERROR\n";
  EXPECT_EQ(job_message(end), "==1==ERROR\n");
  EXPECT_EQ(job_message({137, "", ""}), "ended by signal 9");
}

TEST(Job, TheStepIsTheLastThatWasToldAsAWholeLine) {
  EXPECT_EQ(job_step(""), std::nullopt);
  EXPECT_EQ(job_step("soak: note: 3 of 5\nfitting: 12 %\nsoak: fitting: 101 %\nsoak: fitting: 1"), std::nullopt);
  EXPECT_EQ(job_step("soak: reading: ...\nsoak: fitting: 12 %\n"), (JobStep{"fitting", 0.12}));
  EXPECT_EQ(job_step("soak: fitting: 12 %\nsoak: searching: ...\nsoak: warning: cold\nsoak: fit"),
            (JobStep{"searching", std::nullopt}));
  EXPECT_EQ(job_message({1, "", "soak: reading: ...\nsoak: why\nsoak: fitting: 12 %\n"}), "soak: why\n");
}

/// A `soak` that is a script.
class Runner : public ::testing::Test {
 protected:
  void SetUp() override { ASSERT_TRUE(catalog_.ensure_unit("-SN 1", "generic")); }

  void soak_does(const std::string& script) {
    std::ofstream(program_) << "#!/bin/sh\n" << script << '\n';
    ::chmod(program_.c_str(), 0755);
  }
  static json ended(const JobRunner& jobs, std::int64_t id) {
    json job = jobs.show(id).value();
    while (job["state"] == "running") {
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
      job = jobs.show(id).value();
    }
    return job;
  }
  static JobRequest fit() { return {"fit", "-SN 1", "", "", false, "Eva"}; }

  db::testing::TempFolder folder_;
  db::Catalog catalog_ = db::Catalog::open(folder_.path()).value();
  std::filesystem::path program_ = folder_.path() / "soak";
};

TEST_F(Runner, GivesEachWordAsOneArgumentAndKeepsTheResult) {
  soak_does("for word; do echo \"$word\" >> " + (folder_.path() / "words").string() +
            "; done; echo '{\"model\": 3, \"unit\": \"x\", \"sensors\": {}}'");
  JobRunner jobs(folder_.path(), program_);
  const json job = ended(jobs, jobs.start(fit()).value()["id"]);
  EXPECT_EQ(job["state"], "done");
  EXPECT_EQ(job["result"], json({{"model", 3}, {"unit", "x"}}));
  std::ifstream words(folder_.path() / "words");
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(words), {}),
            "fit\n--unit=-SN 1\n--data=" + folder_.path().string() + "\n--json\n");
}

TEST_F(Runner, TakesTheEffectsOfAGapByName) {
  soak_does("for word; do echo \"$word\" >> " + (folder_.path() / "words").string() +
            "; done; echo '{\"model\": 4, \"unit\": \"x\", \"parent\": 3, \"not_added\": []}'");
  JobRunner jobs(folder_.path(), program_);
  const JobRequest accept{"gap_accept", "-SN 1", "", "", false, "Eva", {"sensor_lag", "--suspect"}};
  const json job = ended(jobs, jobs.start(accept).value()["id"]);
  EXPECT_EQ(job["state"], "done");
  EXPECT_EQ(job["effects"], json({"sensor_lag", "--suspect"}));
  EXPECT_EQ(job["result"]["parent"], 3) << "the whole document is kept";
  std::ifstream words(folder_.path() / "words");
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(words), {}),
            "gap\naccept\n--unit=-SN 1\n--effect=sensor_lag\n--effect=--suspect\n--data=" + folder_.path().string() +
                "\n--json\n");
  EXPECT_EQ(catalog_.events()->back().text, "gap_accept of sensor_lag, --suspect: done, model 4");
}

TEST_F(Runner, ReleasesOfAllUnitsInOneCommandAndListsThemByTheirJobOnly) {
  soak_does("for word; do echo \"$word\" >> " + (folder_.path() / "words").string() +
            "; done; echo '{\"units\": [{\"unit\": \"-SN 1\", \"model\": 2, \"obstacles\": []}]}'");
  JobRunner jobs(folder_.path(), program_);
  const json one = ended(jobs, jobs.start({"release", "-SN 1", "", "", false, "Eva"}).value()["id"]);
  EXPECT_EQ(one["result"], json({{"unit", "-SN 1"}, {"model", 2}}));
  const json all = ended(jobs, jobs.start({"release_all", "", "", "", false, "Eva"}).value()["id"]);
  EXPECT_EQ(all["result"]["units"].size(), 1U);
  EXPECT_EQ(jobs.list()["jobs"][0]["result"], json::object());
  std::ifstream words(folder_.path() / "words");
  const std::string common = "--data=" + folder_.path().string() + "\n--json\n";
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(words), {}),
            "release\n--unit=-SN 1\n" + common + "release\n--all\n" + common);
  EXPECT_EQ(catalog_.events()->back().text, "release_all: done");
}

TEST_F(Runner, FitsAndVerifiesAllUnitsInOneCommandEach) {
  ASSERT_TRUE(catalog_.ensure_campaign("check", "verification"));
  soak_does("for word; do echo \"$word\" >> " + (folder_.path() / "words").string() + "; done; echo '{\"units\": []}'");
  JobRunner jobs(folder_.path(), program_);
  ended(jobs, jobs.start({"fit_all", "", "", "", false, "Eva"}).value()["id"]);
  const json all = ended(jobs, jobs.start({"verify_all", "", "check", "", false, "Eva"}).value()["id"]);
  EXPECT_EQ(all["campaign"], "check");
  EXPECT_TRUE(all["model"].is_null());
  std::ifstream words(folder_.path() / "words");
  const std::string common = "--data=" + folder_.path().string() + "\n--json\n";
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(words), {}),
            "fit\n--all\n--brief\n" + common + "verify\n--all\n--campaign=check\n--keep=" +
                (folder_.path() / "jobs" / "2" / "verdicts.jsonl").string() + "\n" + common);
  EXPECT_EQ(catalog_.events()->back().text, "verify_all against check: done");
}

TEST_F(Runner, ReportsOnACampaignWithoutSayingItsUnitsInTheList) {
  ASSERT_TRUE(catalog_.ensure_campaign("spring 1", "six-position"));
  soak_does(
      "for word; do echo \"$word\" >> " + (folder_.path() / "words").string() +
      "; done; echo '{\"campaign\": \"spring 1\", \"units\": [{\"unit\": \"x\"}], \"bytes\": 3, \"software\": \"s\"}'");
  JobRunner jobs(folder_.path(), program_);
  const json job = ended(jobs, jobs.start({"report_campaign", "", "spring 1", "", false, "Eva"}).value()["id"]);
  EXPECT_EQ(job["campaign"], "spring 1");
  EXPECT_EQ(job["result"], json({{"campaign", "spring 1"}, {"units", json::array({{{"unit", "x"}}})}, {"bytes", 3}}));
  EXPECT_EQ(jobs.list()["jobs"][0]["result"], json({{"campaign", "spring 1"}, {"bytes", 3}}));
  std::ifstream words(folder_.path() / "words");
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(words), {}),
            "report\n--campaign=spring 1\n--output=" + (folder_.path() / "jobs" / "1" / "spring_1.html").string() +
                "\n--data=" + folder_.path().string() + "\n--json\n");
  EXPECT_EQ(catalog_.events()->back().text, "report_campaign of spring 1: done");
  EXPECT_EQ(jobs.start({"report_campaign", "", "none", "", false, "Eva"}).error().where, "campaign");
}

TEST_F(Runner, HandsOverOnlyWithAKeyAndInAFormatOfModels) {
  JobRunner jobs(folder_.path(), program_);
  EXPECT_EQ(jobs.start({"export_all", "", "", "blob", false, "Eva"}).error().where, "sign");
  EXPECT_EQ(jobs.start({"export_all", "", "", "kalibr", false, "Eva"}).error().where, "format");
  EXPECT_EQ(jobs.start({"export_all", "-SN 1", "", "blob", false, "Eva"}).error().where, "unit");
}

TEST_F(Runner, SaysHowFarAJobIsAsSoakSaysIt) {
  soak_does("test -n \"$SOAK_PROGRESS\" && echo 'soak: fitting: 40 %' >&2; while [ ! -e " +
            (folder_.path() / "go").string() + " ]; do sleep 0.01; done; echo 'soak: note' >&2; exit 1");
  JobRunner jobs(folder_.path(), program_);
  const std::int64_t id = jobs.start({"fit_all", "", "", "", false, "Eva"}).value()["id"];
  while (jobs.show(id).value()["progress"].is_null()) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  EXPECT_EQ(jobs.show(id).value()["progress"], 0.4);
  EXPECT_EQ(jobs.show(id).value()["doing"], "fitting");
  std::ofstream(folder_.path() / "go") << "on";
  const json job = ended(jobs, id);
  EXPECT_TRUE(job["progress"].is_null());
  EXPECT_TRUE(job["doing"].is_null());
  EXPECT_EQ(job["message"], "soak: note\n") << "how far it was is no reason";
}

TEST_F(Runner, WhatACancelledJobOfAllHasDoneIsKept) {
  soak_does(
      "trap 'echo \"{\\\"units\\\": [{\\\"unit\\\": \\\"-SN 1\\\", \\\"state\\\": \\\"released\\\"}]}\"; exit 1' TERM; "
      ": > " +
      (folder_.path() / "begun").string() + "; while :; do sleep 0.01; done");
  JobRunner jobs(folder_.path(), program_);
  const std::int64_t id = jobs.start({"release_all", "", "", "", false, "Eva"}).value()["id"];
  while (!std::filesystem::exists(folder_.path() / "begun")) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  const auto job = jobs.cancel(id, "Bob");
  ASSERT_TRUE(job);
  EXPECT_EQ((*job)["state"], "cancelled");
  EXPECT_EQ((*job)["result"]["units"][0]["state"], "released");
}

TEST_F(Runner, WhatAKilledVerificationOfAllHadComeToIsKept) {
  ASSERT_TRUE(catalog_.ensure_campaign("check", "verification"));
  soak_does(
      "for word; do case $word in --keep=*) keep=${word#--keep=};; esac; done; "
      "echo '{\"units\": {\"unit\": \"-SN 1\", \"model\": 2, \"verdict\": \"pass\"}}' > $keep; "
      "echo '{\"skipped\": {\"unit\": \"SN2\", \"message\": \"it has no model yet\"}}' >> $keep; "
      "printf '{\"units\": {\"unit' >> $keep; kill -9 $$");
  JobRunner jobs(folder_.path(), program_);
  const json job = ended(jobs, jobs.start({"verify_all", "", "check", "", false, "Eva"}).value()["id"]);
  EXPECT_EQ(job["state"], "failed");
  EXPECT_EQ(job["result"]["units"].size(), 1U) << "the torn line is left out";
  EXPECT_EQ(job["result"]["skipped"][0]["unit"], "SN2");
  EXPECT_EQ(jobs.newest("-SN 1", "verify")["result"]["verdict"], "pass");
  EXPECT_EQ(jobs.newest_verdicts().at("-SN 1"), jobs.newest("-SN 1", "verify"));
}

TEST_F(Runner, WhatAVerificationOfAllHadComeToIsKeptWhenSoakdDies) {
  const auto folder = folder_.path() / "jobs" / "1";
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "job.json") << json({{"id", 1},
                                              {"kind", "verify_all"},
                                              {"unit", ""},
                                              {"campaign", "check"},
                                              {"user", "Eva"},
                                              {"state", "running"},
                                              {"started_utc_s", 1.0}});
  std::ofstream(folder / "verdicts.jsonl") << R"({"units": {"unit": "-SN 1", "model": 2, "verdict": "fail"}})" << '\n';
  const JobRunner jobs(folder_.path(), program_);
  EXPECT_EQ(jobs.show(1).value()["state"], "failed");
  EXPECT_EQ(jobs.newest("-SN 1", "verify")["result"]["verdict"], "fail");
}

TEST_F(Runner, AJobThatDoesNotComeToBeLeavesNoFolder) {
  const JobRequest verify{"verify", "-SN 1", "check", "", false, "Eva"};
  JobRunner jobs(folder_.path(), program_);
  EXPECT_FALSE(jobs.start(verify)) << "there is no model";
  EXPECT_FALSE(std::filesystem::exists(folder_.path() / "jobs" / "1"));
}

TEST_F(Runner, AVerificationOfAllIsToEachUnitOneOfItsOwnAndLastsAsLong) {
  const json judged = {{"unit", "-SN 1"}, {"model", 2}, {"verdict", "fail"}, {"warnings", json::array()}};
  JobShelf shelf(folder_.path() / "jobs");
  std::filesystem::create_directories(shelf.folder_of(1));
  shelf.put({{"id", 1}, {"kind", "verify"}, {"unit", "-SN 1"}, {"state", "done"}, {"result", {{"model", 2}}}});
  std::filesystem::create_directories(shelf.folder_of(2));
  shelf.put({{"id", 2},
             {"kind", "verify_all"},
             {"unit", ""},
             {"campaign", "check"},
             {"user", "Eva"},
             {"state", "cancelled"},
             {"message", "cancelled by Bob"},
             {"result", {{"units", {judged}}}}});
  soak_does("echo '{\"unit\": \"x\"}'");
  JobRunner jobs(folder_.path(), program_);
  for (std::size_t i = 0; i < JobShelf::kMostJobs; ++i) ended(jobs, jobs.start(fit()).value()["id"]);
  const json own = jobs.newest("-SN 1", "verify");
  EXPECT_EQ(own["id"], 2);
  EXPECT_EQ(own["kind"], "verify");
  EXPECT_EQ(own["unit"], "-SN 1");
  EXPECT_EQ(own["campaign"], "check");
  EXPECT_EQ(own["state"], "done");
  EXPECT_EQ(own["exit_status"], 5);
  EXPECT_EQ(own["result"], judged);
  EXPECT_FALSE(jobs.show(1)) << "a newer verdict has taken its place";
  EXPECT_TRUE(jobs.newest("SN2", "verify").is_null());
}

TEST_F(Runner, BeginningAndEndAreInTheEventLogWithTheUser) {
  soak_does("echo '{\"error\": {\"code\": 2, \"message\": \"no run\", \"where\": \"\"}}' >&2; exit 2");
  JobRunner jobs(folder_.path(), program_);
  const json job = ended(jobs, jobs.start(fit()).value()["id"]);
  EXPECT_EQ(job["state"], "failed");
  EXPECT_EQ(job["message"], "no run");
  const auto events = catalog_.events().value();
  ASSERT_GE(events.size(), 2U);
  const auto& begin = events[events.size() - 2];
  EXPECT_EQ(begin.kind + begin.subject + begin.text + begin.user, "job_started-SN 1fitEva");
  EXPECT_EQ(events.back().kind + events.back().text, "job_endedfit: failed: no run");
}

TEST_F(Runner, AUnitBeyondItsLimitsIsNoFailureOfTheJob) {
  soak_does("echo '{\"unit\": \"x\", \"model\": 1}'; exit 5");
  JobRunner jobs(folder_.path(), program_);
  EXPECT_EQ(ended(jobs, jobs.start(fit()).value()["id"])["state"], "done");
}

TEST_F(Runner, BeginsNoneWhileItIsHeldAndIsNotHeldWhileOneRuns) {
  soak_does("while :; do sleep 0.01; done");
  JobRunner jobs(folder_.path(), program_);
  ASSERT_TRUE(jobs.hold());
  const auto refused = jobs.start(fit());
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().where, "state");
  jobs.end_hold();
  const auto job = jobs.start(fit());
  ASSERT_TRUE(job) << job.error().message;
  const auto held = jobs.hold();
  ASSERT_FALSE(held);
  EXPECT_EQ(held.error().where, "state");
  EXPECT_TRUE(jobs.cancel((*job)["id"], "Eva"));
}

TEST_F(Runner, OneJobAtATimeAndACancelEndsIt) {
  soak_does("sleep 60");
  JobRunner jobs(folder_.path(), program_);
  const std::int64_t id = jobs.start(fit()).value()["id"];
  const auto second = jobs.start(fit());
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().where, "state");
  const auto cancelled = jobs.cancel(id, "Bob");
  ASSERT_TRUE(cancelled);
  EXPECT_EQ((*cancelled)["state"], "cancelled");
  EXPECT_EQ((*cancelled)["message"], "cancelled by Bob");
  EXPECT_FALSE(jobs.cancel(id, "Bob"));
  soak_does("echo '{\"unit\": \"x\"}'");
  EXPECT_EQ(ended(jobs, jobs.start(fit()).value()["id"])["state"], "done");
}

TEST_F(Runner, ACancelInTheMomentOfTheCommitDoesNotSayCancelled) {
  soak_does("trap 'echo \"{\\\"model\\\": 4}\"; exit 0' TERM; : > " + (folder_.path() / "begun").string() +
            "; while :; do sleep 0.01; done");
  JobRunner jobs(folder_.path(), program_);
  const std::int64_t id = jobs.start(fit()).value()["id"];
  while (!std::filesystem::exists(folder_.path() / "begun")) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  const auto job = jobs.cancel(id, "Bob");
  ASSERT_TRUE(job);
  EXPECT_EQ((*job)["state"], "done");
  EXPECT_EQ((*job)["result"]["model"], 4);
  EXPECT_EQ(catalog_.events().value().back().text, "fit: done, model 4");
}

TEST_F(Runner, TheEndOfAJobThatDiedWithSoakdEntersTheEventLogAtTheNextStartOnce) {
  JobShelf shelf(folder_.path() / "jobs");
  std::filesystem::create_directories(shelf.folder_of(1));
  shelf.put(
      {{"id", 1}, {"kind", "verify"}, {"unit", "-SN 1"}, {"campaign", "c"}, {"user", "Eva"}, {"state", "running"}});
  const std::size_t before = catalog_.events().value().size();
  for (int starts = 0; starts < 2; ++starts) {
    JobRunner jobs(folder_.path(), program_);
    EXPECT_EQ(jobs.show(1).value()["message"], "soakd ended meanwhile");
  }
  const auto events = catalog_.events().value();
  ASSERT_EQ(events.size(), before + 1);
  const auto& end = events.back();
  EXPECT_EQ(end.kind + end.subject + end.text + end.user,
            "job_ended-SN 1verify against c: failed: soakd ended meanwhileEva");
}

TEST_F(Runner, AnEndThatWasLoggedBeforeSoakdDiedIsNotLoggedAgain) {
  JobShelf shelf(folder_.path() / "jobs");
  std::filesystem::create_directories(shelf.folder_of(1));
  json job = {{"id", 1}, {"kind", "fit"}, {"unit", "-SN 1"}, {"user", "Eva"}, {"started_utc_s", 1000.0}};
  for (const char* state : {"running", "done"}) {
    job["state"] = state;
    shelf.put(job);
    ASSERT_TRUE(catalog_.log_event({1001.0, "job_ended", "-SN 1", "fit: done, model 3", "Eva"}));
    const std::size_t before = catalog_.events().value().size();
    JobRunner jobs(folder_.path(), program_);
    EXPECT_EQ(catalog_.events().value().size(), before) << state;
  }
}

TEST_F(Runner, AnEndThatSoakdDiedBeforeLoggingIsLoggedOnceAtTheNextStart) {
  JobShelf shelf(folder_.path() / "jobs");
  std::filesystem::create_directories(shelf.folder_of(1));
  shelf.put({{"id", 1},
             {"kind", "fit"},
             {"unit", "-SN 1"},
             {"user", "Eva"},
             {"state", "done"},
             {"started_utc_s", 1000.0},
             {"result", {{"model", 3}}}});
  // Ends of another unit, of another kind and from before are not its own.
  ASSERT_TRUE(catalog_.log_event({1001.0, "job_ended", "SN2", "fit: done, model 3", "Eva"}));
  ASSERT_TRUE(catalog_.log_event({1001.0, "job_ended", "-SN 1", "report: done, model 3", "Eva"}));
  ASSERT_TRUE(catalog_.log_event({999.0, "job_ended", "-SN 1", "fit: done, model 2", "Eva"}));
  const std::size_t before = catalog_.events().value().size();
  for (int starts = 0; starts < 2; ++starts) const JobRunner jobs(folder_.path(), program_);
  const auto events = catalog_.events().value();
  ASSERT_EQ(events.size(), before + 1);
  EXPECT_EQ(events.back().subject + ' ' + events.back().text + ' ' + events.back().user,
            "-SN 1 fit: done, model 3 Eva");
}

TEST_F(Runner, ADamagedDocumentIsPutAsideAndStopsNobody) {
  const json sound = {{"id", 1}, {"kind", "gap_accept"}, {"unit", "-SN 1"}, {"user", "Eva"}, {"state", "running"}};
  std::vector<std::string> damaged = {"", "{", "[]", "null", R"({"id": 2, "kind": "fit"})"};
  for (const json& change : {json{{"user", 5}},
                             {{"effects", "all"}},
                             {{"effects", {1}}},
                             {{"effects", json::object()}},
                             {{"campaign", json::array()}},
                             {{"format", 1}},
                             {{"message", 1}},
                             {{"started_utc_s", "now"}},
                             {{"result", "pass"}},
                             {{"result", {{"warnings", {{{"code", "partial_range"}}}}}}},
                             {{"result", {{"units", {{{"unit", 1}}}}}}},
                             {{"result", {{"units", {{{"unit", "x"}, {"warnings", {{{"code", 1}}}}}}}}}},
                             {{"file", {{"name", 1}}}},
                             {{"state", "lost"}},
                             {{"id", 7}}}) {
    json job = sound;
    job.update(change);
    damaged.push_back(job.dump());
  }
  const auto folder = folder_.path() / "jobs";
  for (const std::string& text : damaged) {
    std::filesystem::create_directories(folder / "1");
    std::ofstream(folder / "1" / "job.json") << text;
    const std::size_t before = catalog_.events().value().size();
    for (int starts = 0; starts < 2; ++starts) {
      const JobRunner jobs(folder_.path(), program_);
      EXPECT_EQ(jobs.list()["jobs"], json::array()) << text;
    }
    EXPECT_FALSE(std::filesystem::exists(folder / "1")) << text;
    std::ifstream aside(folder / "damaged-1" / "job.json");
    EXPECT_EQ(std::string(std::istreambuf_iterator<char>(aside), {}), text);
    EXPECT_EQ(catalog_.events().value().size(), before) << text;
  }
}

TEST_F(Runner, TheListIsBoundedAndSaysHowManyItLeavesOut) {
  JobShelf shelf(folder_.path() / "jobs");
  constexpr std::int64_t kKept = 130;  // of as many units the newest verdict: none of them is removed
  for (std::int64_t id = 1; id <= kKept; ++id) {
    std::filesystem::create_directories(shelf.folder_of(id));
    shelf.put({{"id", id},
               {"kind", "verify"},
               {"unit", "SN" + std::to_string(id)},
               {"state", "done"},
               {"result", {{"model", 1}}}});
  }
  const json list = JobRunner(folder_.path(), program_).list();
  ASSERT_EQ(list["jobs"].size(), JobShelf::kMostListed);
  EXPECT_EQ(list["jobs"][0]["id"], kKept);
  EXPECT_EQ(list["not_listed"], kKept - static_cast<std::int64_t>(JobShelf::kMostListed));
}

TEST_F(Runner, KeepsTheNewestJobsAndTheNewestVerdictAcrossARestart) {
  soak_does("echo '{\"unit\": \"x\", \"verdict\": \"pass\"}'");
  JobShelf shelf(folder_.path() / "jobs");
  std::filesystem::create_directories(shelf.folder_of(1));
  shelf.put({{"id", 1}, {"kind", "verify"}, {"unit", "-SN 1"}, {"state", "done"}, {"result", {{"model", 3}}}});
  std::filesystem::create_directories(shelf.folder_of(2));
  shelf.put({{"id", 2}, {"kind", "fit"}, {"unit", "-SN 1"}, {"state", "running"}});
  // Values of the noise: of no model.
  std::filesystem::create_directories(shelf.folder_of(3));
  shelf.put({{"id", 3}, {"kind", "export"}, {"unit", "-SN 1"}, {"state", "done"}, {"result", {{"model", nullptr}}}});
  std::filesystem::create_directories(shelf.folder_of(4));
  shelf.put({{"id", 4}, {"kind", "gap_find"}, {"unit", "-SN 1"}, {"state", "done"}, {"result", {{"model", 3}}}});
  std::filesystem::create_directories(folder_.path() / "jobs" / "rubbish");
  JobRunner jobs(folder_.path(), program_);
  EXPECT_EQ(jobs.show(2).value()["state"], "failed");
  EXPECT_FALSE(std::filesystem::exists(folder_.path() / "jobs" / "rubbish"));
  for (std::size_t i = 0; i < JobShelf::kMostJobs; ++i) ended(jobs, jobs.start(fit()).value()["id"]);
  EXPECT_EQ(jobs.list()["jobs"].size(), JobShelf::kMostJobs + 2);
  EXPECT_EQ(jobs.newest("-SN 1", "verify")["id"], 1);
  EXPECT_EQ(jobs.newest("-SN 1", "gap_find")["id"], 4);
  EXPECT_TRUE(jobs.newest("-SN 1", "export").is_null());
  for (const int gone : {2, 3}) EXPECT_FALSE(jobs.show(gone)) << gone;
  EXPECT_FALSE(std::filesystem::exists(folder_.path() / "jobs" / "2"));
}

TEST_F(Runner, RefusesWhatIsNoJobAndLeavesNoFolder) {
  JobRunner jobs(folder_.path(), program_);
  const auto refused = [&](const JobRequest& request) {
    const auto started = jobs.start(request);
    return started ? std::string("started") : started.error().where;
  };
  EXPECT_EQ(refused({"rm", "-SN 1", "", "", false, ""}), "kind");
  EXPECT_EQ(refused({"fit", "SN2", "", "", false, ""}), "unit");
  EXPECT_EQ(refused({"fit", "", "", "", false, ""}), "unit");
  EXPECT_EQ(refused({"release_all", "-SN 1", "", "", false, ""}), "unit");
  EXPECT_EQ(refused({"fit_all", "-SN 1", "", "", false, ""}), "unit");
  EXPECT_EQ(refused({"verify_all", "", "", "", false, ""}), "campaign");
  EXPECT_EQ(refused({"verify_all", "", "c", "", false, ""}), "campaign");
  EXPECT_EQ(refused({"verify", "-SN 1", "", "", false, ""}), "campaign");
  EXPECT_EQ(refused({"verify", "-SN 1", "c", "", false, ""}), "unit") << "it has no model";
  EXPECT_EQ(refused({"export", "-SN 1", "", "exe", false, ""}), "format");
  EXPECT_EQ(refused({"gap_accept", "-SN 1", "", "", false, ""}), "effects");
  EXPECT_TRUE(std::filesystem::is_empty(folder_.path() / "jobs"));
  EXPECT_FALSE(JobRunner("", program_).start(fit()));
}

}  // namespace
}  // namespace soak::station
