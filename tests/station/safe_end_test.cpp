// SPDX-License-Identifier: Apache-2.0
// What ends a campaign looks at the chamber, not at what the chamber acknowledges.
#include "station/lab/safe_end.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <iterator>
#include <utility>

#include "station/lab/chamber_off.h"
#include "station/lab/dew_safe_warm_up.h"
#include "station/lab/steps.h"
#include "tests/errors.h"
#include "tests/long_tests.h"
#include "tests/station/fake_power.h"
#include "tests/station/lab_bench.h"

namespace soak::station {
namespace {

using namespace lab_bench;
using namespace std::chrono_literals;

class SafeEndOfAChamberThatGoesOn : public LabBench {
 protected:
  /// Polls until the safe end is over; how the chamber then stands is the question.
  void end_it(bool outputs_off) {
    stream_.rows_per_poll = 1;
    SafeEnd safe_end("tripped", 25.0, outputs_off, false);
    turns_until([&] { return safe_end.poll(*station_); });
  }
};

TEST_F(SafeEndOfAChamberThatGoesOn, IsNotOverBeforeItIsOff) {
  chamber_.deaf_stops = 2;
  end_it(true);
  EXPECT_FALSE(chamber_.running);
  EXPECT_EQ(chamber_.stops, 3);
}

TEST_F(SafeEndOfAChamberThatGoesOn, IsNotOverAfterTheWarmUpEither) {
  chamber_.deaf_stops = 1;
  end_it(false);
  EXPECT_FALSE(chamber_.running);
  EXPECT_EQ(chamber_.set_point_c, 25.0);
  EXPECT_EQ(chamber_.stops, 2);
}

TEST_F(SafeEndOfAChamberThatGoesOn, NeedsNobodyWhileTheChamberDoesWhatItIsTold) {
  stream_.rows_per_poll = 1;
  SafeEnd safe_end("aborted", 25.0, false, true);
  ASSERT_TRUE(station_->poll());
  turns_until([&] {
    const bool over = safe_end.poll(*station_);
    EXPECT_FALSE(safe_end.needs_somebody(*station_));
    return over;
  });
  EXPECT_EQ(chamber_.set_point_c, 25.0);
}

TEST_F(SafeEndOfAChamberThatGoesOn, NeedsSomebodyWhereTheChamberIsSilent) {
  SafeEnd safe_end("aborted", 25.0, false, true);
  ASSERT_TRUE(station_->poll());
  EXPECT_FALSE(safe_end.poll(*station_));
  EXPECT_FALSE(safe_end.needs_somebody(*station_));
  station_->chamber.forget();  // as after ten seconds without an answer
  EXPECT_FALSE(safe_end.poll(*station_));
  EXPECT_TRUE(safe_end.needs_somebody(*station_));
}

TEST_F(SafeEndOfAChamberThatGoesOn, NeedsSomebodyWhereItCannotBeSwitchedOff) {
  chamber_.deaf_stops = 1;
  SafeEnd safe_end("tripped", 25.0, true, true);
  ASSERT_TRUE(station_->poll());
  EXPECT_FALSE(safe_end.poll(*station_));
  EXPECT_TRUE(safe_end.needs_somebody(*station_));
  stream_.rows_per_poll = 1;
  turns_until([&] { return safe_end.poll(*station_); });
  EXPECT_FALSE(safe_end.needs_somebody(*station_));
}

TEST_F(SafeEndOfAChamberThatGoesOn, NeedsSomebodyWhereItDoesNotTakeItsSetPoint) {
  chamber_.takes_set_points = false;
  stream_.rows_per_poll = 1;
  SafeEnd safe_end("aborted", 25.0, false, true);
  ASSERT_TRUE(station_->poll());
  turns_until([&] {
    (void)safe_end.poll(*station_);
    return safe_end.needs_somebody(*station_);
  });
  EXPECT_GE(chamber_.commands, 5);
  EXPECT_NE(safe_end.trouble(), "");
}

TEST_F(SafeEndOfAChamberThatGoesOn, TellsWhatOnlyAPersonShouldDecideUpon) {
  stream_.rows_per_poll = 1;
  SafeEnd quiet("soakd ended", 25.0, false, false);
  turns_until([&] { return quiet.poll(*station_); });
  EXPECT_EQ(quiet.trouble(), "");
  SafeEnd tripped("soakd ended", 25.0, false, false);
  tripped.switch_off_at_once(*station_, "too hot");
  EXPECT_EQ(tripped.trouble(), "too hot");
  EXPECT_TRUE(tripped.outputs_off());
}

/// A chamber that answers and cannot be switched off, whatever it says to the command.
class ChamberThatCannotBeSwitchedOff : public LabBench {
 protected:
  void SetUp() override {
    LabBench::SetUp();
    stream_.rows_per_poll = 1;
    ASSERT_TRUE(station_->poll());
  }

  [[nodiscard]] std::vector<db::EventRow> alarms() const {
    std::vector<db::EventRow> found;
    const auto events = catalog_->events().value();
    std::ranges::copy_if(events, std::back_inserter(found), [](const auto& event) { return event.kind == "alarm"; });
    return found;
  }

  /// Polls until somebody is called; what is promised of every way to get there.
  void expect_alarm(SafeEnd& safe_end) {
    turns_until([&] {
      EXPECT_FALSE(safe_end.poll(*station_));
      return !alarms().empty();
    });
    EXPECT_TRUE(base::mentions(alarms().front().text, {chamber_.description()}));
    EXPECT_TRUE(safe_end.needs_somebody(*station_));
    EXPECT_NE(safe_end.trouble(), "");
    EXPECT_GE(chamber_.stops, 3) << "one answer may have been lost";
  }
};

TEST_F(ChamberThatCannotBeSwitchedOff, IsAnAlarmWhereItRefusesTheCommand) {
  chamber_.refuses_stops = true;
  SafeEnd safe_end("tripped", 25.0, true, false);
  expect_alarm(safe_end);
}

TEST_F(ChamberThatCannotBeSwitchedOff, IsAnAlarmWhereTheCommandHasNoEffectAtTheEndOfTheWarmUp) {
  SOAK_LONG_TEST();
  chamber_.deaf_stops = 1000;
  SafeEnd safe_end("soakd ended", 25.0, false, false);
  expect_alarm(safe_end);
}

TEST_F(ChamberThatCannotBeSwitchedOff, IsAnAlarmWhereItTakesNoSetPointEither) {
  SOAK_LONG_TEST();
  chamber_.refuses_set_points = chamber_.refuses_stops = true;
  SafeEnd safe_end("aborted", 25.0, false, true);
  expect_alarm(safe_end);
}

TEST_F(ChamberThatCannotBeSwitchedOff, IsToldUntilItGoesOffAndOneAlarmSaysSo) {
  SOAK_LONG_TEST();
  chamber_.deaf_stops = 7;
  SafeEnd safe_end("tripped", 25.0, true, false);
  turns_until([&] { return safe_end.poll(*station_); });
  EXPECT_EQ(chamber_.stops, 8);
  EXPECT_EQ(alarms().size(), 1U);
  EXPECT_FALSE(safe_end.needs_somebody(*station_));
}

TEST_F(ChamberThatCannotBeSwitchedOff, IsNotHopelessBeforeTwoHoursAndAMinute) {
  SOAK_LONG_TEST();
  chamber_.refuses_stops = true;
  SafeEnd safe_end("tripped", 25.0, true, false);
  expect_alarm(safe_end);
  EXPECT_EQ(safe_end.why_hopeless(*station_), "");
}

TEST_F(ChamberThatCannotBeSwitchedOff, IsNotTakenForOffBecauseAReadingIsLost) {
  chamber_.deaf_stops = 1;
  ChamberOff off;
  EXPECT_FALSE(off.attempt(*station_));
  EXPECT_TRUE(off.is_refused());
  chamber_.unreadable = true;
  turns_until([&] {
    EXPECT_FALSE(off.attempt(*station_));
    return chamber_.stops == 2;
  });
  chamber_.unreadable = false;
  turns_until([&] { return off.attempt(*station_); });
  EXPECT_FALSE(chamber_.running);
}

TEST_F(ChamberThatCannotBeSwitchedOff, HasNotRefusedWhereItDidNotAnswer) {
  chamber_.silent = true;
  ChamberOff off;
  EXPECT_FALSE(off.attempt(*station_));
  EXPECT_FALSE(off.is_refused());
  EXPECT_NE(off.trouble(), "");
}

TEST_F(ChamberThatCannotBeSwitchedOff, DoesNotKeepUnitsOnThatWereToGoOffAtOnce) {
  SOAK_LONG_TEST();
  FakePower power;
  config_.slots.emplace_back().power_output = 1;
  power.outputs[1].on = true;
  station_ = std::make_unique<Station>(config_, *catalog_, *log_, chamber_, nullptr, &power);
  ASSERT_TRUE(station_->poll());
  chamber_.refuses_stops = true;
  SafeEnd safe_end("tripped", 25.0, true, false);
  expect_alarm(safe_end);
  turns_until([&] {
    EXPECT_FALSE(safe_end.poll(*station_));
    return !power.outputs[1].on;
  });
}

TEST_F(ChamberThatCannotBeSwitchedOff, IsWhatTheLastStepOfACampaignWaitsFor) {
  SOAK_LONG_TEST();
  chamber_.deaf_stops = 7;
  Step step;
  step.kind = StepKind::warm_end;
  step.temp_c = 25.0;
  const auto task = make_task(station_->campaign.plan, step);
  turns_until([&] {
    EXPECT_EQ(task->poll(*station_).state, StepState::running);
    return !task->trouble().empty();
  });
  turns_until([&] { return task->poll(*station_).state == StepState::done; });
  EXPECT_FALSE(chamber_.running);
}

/// The warm-up at the end, of units that send nothing: half an hour of warm air, here half a second, and they are dry.
class WarmUpAtTheEnd : public LabBench {
 protected:
  void SetUp() override {
    LabBench::SetUp();
    config_.clock_rate = 3600.0;
    station_ = std::make_unique<Station>(config_, *catalog_, *log_, chamber_, nullptr, nullptr);
  }
};

TEST_F(WarmUpAtTheEnd, DoesNotDriveAChamberAgainThatWasToGoOffWhenItsLinkBroke) {
  DewSafeWarmUp warm_up(25.0, {.unreadable = 20ms, .pause = 1ms});
  const auto poll_until = [&](auto there) {
    turns_until([&] {
      EXPECT_FALSE(warm_up.poll(*station_));
      return there();
    });
  };
  chamber_.silent = true;  // to the command to switch off
  poll_until([&] { return chamber_.stops == 1; });
  chamber_.unreadable = true;
  station_->chamber.forget();
  poll_until([&] { return chamber_.stops == 2; });  // a second later: it was unreadable for too long
  const int commands = chamber_.commands;
  chamber_.silent = false;
  turns_until([&] {
    const bool is_over = warm_up.poll(*station_);
    chamber_.unreadable = chamber_.unreadable && chamber_.running;  // the command comes first
    return is_over;
  });
  EXPECT_FALSE(chamber_.running);
  EXPECT_EQ(chamber_.commands, commands);
}

/// Units whose supply the safe end has switched off.
class SafeEndOfUnits : public LabBench {
 protected:
  void SetUp() override {
    LabBench::SetUp();
    for (const int output : {1, 2}) {
      config_.slots.emplace_back().power_output = output;
      power_.outputs[output].on = true;
    }
    station_ = std::make_unique<Station>(config_, *catalog_, *log_, chamber_, nullptr, &power_);
  }

  void end_it() {
    chamber_.running = false;
    SafeEnd safe_end("soakd ended", 25.0, true, false);
    turns_until([&] { return safe_end.poll(*station_); });
  }

  [[nodiscard]] bool has_event(const std::string& kind, const std::string& subject) const {
    const auto events = catalog_->events().value();
    return std::ranges::any_of(events, [&](const auto& e) { return e.kind == kind && e.subject == subject; });
  }

  FakePower power_;
};

TEST_F(SafeEndOfUnits, SwitchesThemOffOnce) {
  end_it();
  EXPECT_FALSE(power_.outputs[1].on || power_.outputs[2].on);
  EXPECT_EQ(power_.commands, 2);
  EXPECT_FALSE(has_event("power", "power"));
}

TEST_F(SafeEndOfUnits, FindsAnOutputThatALateCommandHasSwitchedOnAgain) {
  bool was_late = false;
  power_.before_read = [&] { power_.outputs[2].on = power_.outputs[2].on || !std::exchange(was_late, true); };
  end_it();
  EXPECT_FALSE(power_.outputs[1].on || power_.outputs[2].on);
  EXPECT_TRUE(has_event("power", "power"));
}

TEST_F(SafeEndOfUnits, CallsSomebodyToAnOutputThatDoesNotStayOff) {
  power_.before_read = [&] { power_.outputs[1].on = true; };
  end_it();
  EXPECT_TRUE(has_event("alarm", "power"));
}

}  // namespace
}  // namespace soak::station
