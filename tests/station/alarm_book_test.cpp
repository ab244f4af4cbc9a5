// SPDX-License-Identifier: Apache-2.0
// Which alarms somebody is told of, and when: no clock, no server.
#include "station/alarms/alarm_book.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "station/alarms/alarm_rules.h"
#include "tests/station/http_scripted_station.h"

namespace soak::station {
namespace {

using nlohmann::json;

json alarm(const std::string& code, const std::string& about = "", bool calls = true) {
  return {{"code", code},
          {"about", about.empty() ? json() : json(about)},
          {"calls", calls},
          {"title", code + " of " + about}};
}

bool nothing_lasts_unseen(std::string_view /*code*/, std::string_view /*about*/) { return false; }

/// What is told while these alarms last from one time to another, looked at twice a second.
std::vector<AlarmBook::Entry> over(AlarmBook& book, const json& alarms, double from_s, double to_s,
                                   const AlarmBook::MayLast& may_last = nothing_lasts_unseen) {
  std::vector<AlarmBook::Entry> told;
  for (double now_s = from_s; now_s < to_s; now_s += 0.5) {
    for (auto& entry : book.take(alarms, now_s, may_last)) told.push_back(std::move(entry));
  }
  return told;
}

std::ptrdiff_t count(const std::vector<AlarmBook::Entry>& told, AlarmTurn turn) {
  return std::ranges::count(told, turn, &AlarmBook::Entry::turn);
}

TEST(AlarmBook, TellsOfAnAlarmOnceWhenItBeginsAndOnceWhenItEnds) {
  AlarmBook book;
  const auto begins = over(book, json::array({alarm("a")}), 100.0, 4000.0);
  ASSERT_EQ(begins.size(), 1U);
  EXPECT_EQ(begins[0].turn, AlarmTurn::began);
  const auto ends = over(book, json::array(), 4000.0, 8000.0);
  ASSERT_EQ(ends.size(), 1U);
  EXPECT_EQ(ends[0].turn, AlarmTurn::ended);
  EXPECT_EQ(ends[0].alarm.at("code"), "a");
}

TEST(AlarmBook, PassesOverWhatLastsForAMomentAndWhatNeedsNobody) {
  AlarmBook book;
  EXPECT_TRUE(over(book, json::array({alarm("a")}), 0.0, AlarmBook::kHolds_s - 1.0).empty());
  EXPECT_TRUE(over(book, json::array(), AlarmBook::kHolds_s - 1.0, 60.0).empty());
  EXPECT_TRUE(over(book, json::array({alarm("b", "", false)}), 60.0, 120.0).empty());
}

TEST(AlarmBook, AnAlarmThatComesBackSoonHasNotEnded) {
  AlarmBook book;
  std::vector<AlarmBook::Entry> told;
  for (double t = 0.0; t < 600.0; t += 9.0) {
    for (auto& entry : over(book, json::array({alarm("a")}), t, t + 4.0)) told.push_back(std::move(entry));
    for (auto& entry : over(book, json::array(), t + 4.0, t + 9.0)) told.push_back(std::move(entry));
  }
  EXPECT_EQ(count(told, AlarmTurn::began), 1);
  EXPECT_EQ(count(told, AlarmTurn::ended), 0);
}

TEST(AlarmBook, TwoUnitsWithTheSameTroubleAreTwoAlarms) {
  AlarmBook book;
  EXPECT_EQ(over(book, json::array({alarm("unit_failed", "SN1"), alarm("unit_failed", "SN2")}), 0.0, 10.0).size(), 2U);
  const auto ended = over(book, json::array({alarm("unit_failed", "SN2")}), 10.0, 60.0);
  ASSERT_EQ(ended.size(), 1U);
  EXPECT_EQ(ended[0].alarm.at("about"), "SN1");
}

TEST(AlarmBook, AlarmsThatBeginAgainAndAgainAreHeldBack) {
  AlarmBook book;
  std::vector<AlarmBook::Entry> told;
  constexpr double kDay_s = 86400.0;
  constexpr double kTurn_s = 30.0;  // long enough to begin and to end
  for (double t = 0.0; t < kDay_s; t += kTurn_s) {
    for (auto& entry : over(book, json::array({alarm("a")}), t, t + 10.0)) told.push_back(std::move(entry));
    for (auto& entry : over(book, json::array(), t + 10.0, t + kTurn_s)) told.push_back(std::move(entry));
  }
  const auto began = count(told, AlarmTurn::began);
  EXPECT_GE(began, 20);
  EXPECT_LE(began, 20 + static_cast<std::ptrdiff_t>(kDay_s / AlarmBook::kOneReturnsAfter_s));
  EXPECT_EQ(count(told, AlarmTurn::ended), began);
  EXPECT_GT(count(told, AlarmTurn::held_back), 0);
}

TEST(AlarmBook, AnAlarmThatWasHeldBackIsToldOnceThereIsRoom) {
  AlarmBook book;
  json alarms = json::array();
  for (int i = 0; i < 21; ++i) alarms.push_back(alarm("unit_failed", std::to_string(i)));
  const auto told = over(book, alarms, 0.0, 10.0);
  EXPECT_EQ(count(told, AlarmTurn::began), 20);
  EXPECT_EQ(count(told, AlarmTurn::held_back), 1);
  const auto later = over(book, alarms, 10.0, 10.0 + 2.0 * AlarmBook::kOneReturnsAfter_s);
  EXPECT_EQ(count(later, AlarmTurn::began), 1);
  EXPECT_EQ(later.size(), 1U);
}

TEST(EngineTurns, OnlyAStatusThatDoesNotRiseForAMinuteStandsStill) {
  EngineTurns turns;
  for (std::uint64_t version = 1; version < 10; ++version) {
    EXPECT_FALSE(turns.stand_still(version, 50.0 * static_cast<double>(version)));
  }
  EXPECT_FALSE(turns.stand_still(9, 450.0 + 59.0));
  EXPECT_TRUE(turns.stand_still(9, 450.0 + 60.0));
  EXPECT_FALSE(turns.stand_still(10, 450.0 + 61.0));
}

class AlarmRules : public ::testing::Test {
 protected:
  AlarmRules() {
    for (json& unit : status["units"]) unit["attitude"] = nullptr;
  }
  /// Codes of the alarms, in their order.
  [[nodiscard]] std::vector<std::string> codes() const {
    std::vector<std::string> found;
    for (const json& one : alarms_of(status)) found.push_back(one.at("code"));
    return found;
  }
  [[nodiscard]] bool calls() const { return alarms_of(status).at(0).at("calls"); }

  json status = ScriptedStation::running_status();
};

using Codes = std::vector<std::string>;

TEST_F(AlarmRules, ACampaignThatRunsNeedsNobody) { EXPECT_EQ(codes(), Codes()); }

TEST_F(AlarmRules, EachCauseOfAWaitIsToldTheMoreUrgentFirst) {
  status["state"] = "waiting";
  status["chamber"]["connected"] = false;
  status["suspension"] = {{"causes", {"disk", "chamber"}}, {"for_s", 1.0}, {"gives_up_in_s", 7200.0}};
  EXPECT_EQ(codes(), (Codes{"chamber_silent", "waits_for_disk"}));
  for (const json& told : alarms_of(status)) {
    // The clock of the scripted laboratory runs 60 times as fast.
    EXPECT_DOUBLE_EQ(told.at("deadline").at("utc_s"), status["clock"]["utc_s"].get<double>() + 120.0);
  }
  EXPECT_EQ(alarms_of(status).at(1).at("about"), "acceptance");
}

/// What is told while a status lasts.
class AlarmsOverTime : public AlarmRules {
 protected:
  std::vector<std::string> minute() { return seconds(60.0); }
  std::vector<std::string> seconds(double for_s) {
    std::vector<std::string> told;
    const auto may_last = [&](std::string_view code, std::string_view about) {
      return may_last_unseen(status, code, about);
    };
    for (const auto& entry : over(book_, alarms_of(status), now_s_, now_s_ + for_s, may_last)) {
      told.push_back((entry.turn == AlarmTurn::began ? "began " : "ended ") +
                     entry.alarm.at("code").get<std::string>());
    }
    now_s_ += for_s;
    return told;
  }
  void suspend(const json& causes) {
    status["state"] = "waiting";
    status["suspension"] = {{"causes", causes}, {"for_s", 1.0}, {"gives_up_in_s", 7200.0}};
  }

 private:
  AlarmBook book_;
  double now_s_ = 0.0;
};

TEST_F(AlarmsOverTime, ASilentChamberIsToldOnceWhateverTheCampaignDoesMeanwhile) {
  status["state"] = "waiting";
  status["chamber"]["connected"] = false;
  EXPECT_EQ(minute(), Codes{"began chamber_silent"});
  suspend({"chamber"});
  EXPECT_EQ(minute(), Codes());
  status["state"] = "paused";
  status["suspension"] = nullptr;
  EXPECT_EQ(minute(), Codes());
  status["state"] = "stopping";
  EXPECT_EQ(minute(), Codes{"began campaign_ended"});
  status["state"] = "running";
  status["chamber"]["connected"] = true;
  EXPECT_EQ(minute(), (Codes{"ended campaign_ended", "ended chamber_silent"}));
}

TEST_F(AlarmsOverTime, AFullDiskIsNotOverWhenTheChamberFallsSilentToo) {
  suspend({"disk"});
  EXPECT_EQ(minute(), Codes{"began waits_for_disk"});
  status["chamber"]["connected"] = false;
  suspend({"chamber", "disk"});
  EXPECT_EQ(minute(), Codes{"began chamber_silent"});
  status["chamber"]["connected"] = true;
  suspend({"chamber"});
  EXPECT_EQ(minute(), Codes{"ended waits_for_disk"});
}

TEST_F(AlarmsOverTime, AWaitIsNotOverBecauseSomebodyPausesTheCampaign) {
  suspend({"disk"});
  EXPECT_EQ(minute(), Codes{"began waits_for_disk"});
  status["state"] = "paused";
  status["suspension"] = nullptr;
  EXPECT_EQ(minute(), Codes());
  suspend({"disk"});
  EXPECT_EQ(minute(), Codes());
  status["state"] = "paused";
  status["suspension"] = nullptr;
  EXPECT_EQ(minute(), Codes());
  status["state"] = "running";
  EXPECT_EQ(minute(), Codes{"ended waits_for_disk"});
}

TEST_F(AlarmsOverTime, AWaitThatWasOverBeforeSomebodyPausesTheCampaignIsOver) {
  suspend({"disk"});
  EXPECT_EQ(minute(), Codes{"began waits_for_disk"});
  status["state"] = "running";
  status["suspension"] = nullptr;
  EXPECT_EQ(seconds(2.0), Codes());
  status["state"] = "paused";
  EXPECT_EQ(minute(), Codes{"ended waits_for_disk"});
}

TEST_F(AlarmsOverTime, AChamberThatAnswersAgainWhileTheCampaignIsPausedIsOver) {
  status["state"] = "paused";
  status["chamber"]["connected"] = false;
  EXPECT_EQ(minute(), Codes{"began chamber_silent"});
  status["chamber"]["connected"] = true;
  EXPECT_EQ(minute(), Codes{"ended chamber_silent"});
}

TEST_F(AlarmsOverTime, AChamberThatRefusesToGoOffIsToldBesideTheEnd) {
  status["state"] = "stopping";
  status["ending"] = {{"outcome", "failed"}, {"needs_somebody", false}};
  EXPECT_EQ(minute(), Codes{"began campaign_ended"});
  status["reason"] = "heating and cooling cannot be switched off";
  status["ending"]["needs_somebody"] = true;
  EXPECT_EQ(minute(), Codes{"began chamber_not_off"});
  EXPECT_EQ(alarms_of(status).at(0).at("detail"), status["reason"]);
}

TEST_F(AlarmRules, AFullDiskCallsThoughItIsAWarning) {
  status["state"] = "waiting";
  status["suspension"] = {{"causes", {"disk"}}, {"for_s", 1.0}, {"gives_up_in_s", 7200.0}};
  EXPECT_EQ(alarms_of(status).at(0).at("level"), "warning");
  EXPECT_TRUE(calls());
}

TEST_F(AlarmRules, AtAStoppedSoakdNothingIsToBeMendedButItIsToBeStartedAgain) {
  status["state"] = "stopping";
  status["ending"] = {{"outcome", "interrupted"}, {"needs_somebody", false}};
  const std::string action = alarms_of(status).at(0).at("action");
  EXPECT_NE(action.find("start it again"), std::string::npos) << action;
  EXPECT_EQ(action.find("what is named here"), std::string::npos) << action;
}

TEST_F(AlarmRules, AnAbortThatSomebodyAskedForCallsNobody) {
  status["state"] = "stopping";
  status["ending"] = {{"outcome", "aborted"}, {"needs_somebody", false}};
  EXPECT_EQ(codes(), Codes{"campaign_aborted"});
  EXPECT_FALSE(calls());
  status["ending"]["needs_somebody"] = true;
  EXPECT_EQ(codes(), (Codes{"chamber_not_off", "campaign_ended"}));
  EXPECT_TRUE(calls());
}

TEST_F(AlarmRules, WhatGoesOnByItselfCallsNobodyAndWhatWaitsForResumeDoes) {
  status["state"] = "interrupted";
  status["campaign"] = nullptr;
  status["resumable"] = "acceptance";
  EXPECT_EQ(codes(), Codes{"campaign_interrupted"});
  EXPECT_TRUE(calls());
  status["resumes_by_itself"] = true;
  EXPECT_FALSE(calls());
}

TEST_F(AlarmRules, AlarmsComeBeforeWarnings) {
  status["units"][0]["dropped"] = "no packets for 15 s";
  status["chamber"]["alarms"] = {"over temperature"};
  status["state"] = "stopping";
  EXPECT_EQ(codes(), (Codes{"chamber_alarm", "campaign_ended", "unit_dropped"}));
}

TEST_F(AlarmRules, OtherUnitsGoOnOnlyIfThereAreAny) {
  status["units"][0]["dropped"] = "no packets for 15 s";
  const auto action = [&] { return alarms_of(status).at(0).at("action").get<std::string>(); };
  EXPECT_NE(action().find("The other units go on"), std::string::npos) << action();
  status["units"][1]["dropped"] = "no packets for 15 s";
  EXPECT_EQ(action().find("The other units go on"), std::string::npos) << action();
}

TEST_F(AlarmRules, ASilentChamberPromisesNothingWhereNoUnitIsHeardEither) {
  status["state"] = "waiting";
  status["chamber"]["connected"] = false;
  status["suspension"] = {{"causes", {"chamber"}}, {"for_s", 1.0}, {"gives_up_in_s", 7200.0}};
  const auto action = [&] { return alarms_of(status).at(0).at("action").get<std::string>(); };
  EXPECT_NE(action().find("goes on by itself"), std::string::npos) << action();
  status["units"][0]["state"] = "silent";
  EXPECT_NE(action().find("goes on by itself"), std::string::npos) << action();
  status["units"][1]["state"] = "failed";
  EXPECT_EQ(action().find("goes on by itself"), std::string::npos) << action();
  EXPECT_NE(action().find("Resume continues it"), std::string::npos) << action();
  status["suspension"] = nullptr;
  EXPECT_EQ(action().find("goes on at once"), std::string::npos) << action();
}

TEST_F(AlarmsOverTime, TheEndOfACampaignIsToldOnceAndIsOverWhenItGoesOn) {
  status["state"] = "stopping";
  status["ending"] = {{"outcome", "interrupted"}, {"needs_somebody", false}};
  EXPECT_EQ(minute(), Codes{"began campaign_ended"});
  status["ending"] = nullptr;
  status["state"] = "interrupted";
  EXPECT_EQ(minute(), Codes());
  status["state"] = "running";
  EXPECT_EQ(minute(), Codes{"ended campaign_interrupted"});
  status["state"] = "failed";
  EXPECT_EQ(minute(), Codes{"began campaign_failed"});
}

TEST_F(AlarmRules, AnEndForWantOfUnitsNamesWhatBecameOfEach) {
  for (json& unit : status["units"]) unit["dropped"] = "cannot connect";
  status["reason"] = "no unit is left";
  for (const char* state : {"stopping", "failed"}) {
    status["state"] = state;
    const json alarms = alarms_of(status);
    ASSERT_EQ(alarms.size(), 1U) << state;
    EXPECT_EQ(alarms[0].at("detail"), "no unit is left; SN0042: cannot connect; SN0043: cannot connect") << state;
  }
}

TEST_F(AlarmsOverTime, ADroppedUnitIsNotWellBecauseTheCampaignHasEnded) {
  status["units"][0]["state"] = "failed";
  EXPECT_EQ(minute(), Codes{"began unit_failed"});
  status["units"][0]["dropped"] = "no packets for 15 s";
  EXPECT_EQ(minute(), Codes{"began unit_dropped"});
  status["state"] = "stopping";
  EXPECT_EQ(minute(), Codes{"began campaign_ended"});
  status["state"] = "failed";
  EXPECT_EQ(minute(), Codes()) << "the end of a campaign is told once";
  status["state"] = "running";
  status["units"][0]["state"] = "streaming";
  status["units"][0]["dropped"] = nullptr;
  EXPECT_EQ(minute(), (Codes{"ended campaign_failed", "ended unit_dropped", "ended unit_failed"}));
}

TEST_F(AlarmsOverTime, ADroppedUnitThatTheNextRunTriesIsNotWellBeforeItSends) {
  status["units"][0]["state"] = "failed";
  status["units"][0]["dropped"] = "no packets for 15 s";
  EXPECT_EQ(minute(), Codes{"began unit_dropped"});
  status["step"]["kind"] = "power_on";
  status["units"][0]["dropped"] = nullptr;
  for (const char* state : {"closed", "silent"}) {
    status["units"][0]["state"] = state;
    EXPECT_EQ(minute(), Codes()) << state;
  }
  status["units"][0]["state"] = "streaming";
  EXPECT_EQ(minute(), Codes{"ended unit_dropped"});
}

TEST_F(AlarmsOverTime, AUnitThatIsNotInTheNextCampaignIsNotToldToBeWell) {
  status["units"][0]["dropped"] = "no packets for 15 s";
  EXPECT_EQ(minute(), Codes{"began unit_dropped"});
  status["units"][0]["serial"] = "SN0099";
  status["units"][0]["dropped"] = nullptr;
  EXPECT_EQ(minute(), Codes());
}

TEST_F(AlarmRules, TheEndForWantOfUnitsNamesThoseThatHaveJustFailed) {
  status["state"] = "stopping";
  for (json& unit : status["units"]) unit["state"] = "failed";
  const json told = alarms_of(status);
  EXPECT_TRUE(std::ranges::any_of(told, [](const json& alarm) {
    return alarm.at("detail").is_string() &&
           alarm.at("detail").get<std::string>().find("SN0042: has failed") != std::string::npos;
  })) << told;
}

TEST_F(AlarmRules, AWrongFaceIsToldWithTheWayToTurn) {
  status["units"][0]["attitude"] = {{"up", "-Z"}, {"expected", "+Z"}, {"right", false}};
  const json told = alarms_of(status).at(0);
  EXPECT_EQ(told.at("title"), "Unit SN0042 in slot A has \u2212Z up, not +Z");
  EXPECT_EQ(told.at("action"), "Turn the fixture: \u2212Z is up now, turn it half a turn to +Z.");
  EXPECT_EQ(told.at("about"), "SN0042");
  status["units"][0]["attitude"]["up"] = "";
  EXPECT_EQ(alarms_of(status).at(0).at("title"), "Unit SN0042 in slot A has an unknown face up, not +Z");
  EXPECT_EQ(alarms_of(status).at(0).at("action"), "Turn the fixture: an unknown face is up now, turn it to +Z.");
  status["prompt"] = {{"id", 1}, {"text", "Turn the fixture"}};
  EXPECT_EQ(codes(), Codes());
}

}  // namespace
}  // namespace soak::station
