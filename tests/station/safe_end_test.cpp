// SPDX-License-Identifier: Apache-2.0
// What ends a campaign looks at the chamber, not at what the chamber acknowledges.
#include "station/lab/safe_end.h"

#include <gtest/gtest.h>

#include "tests/station/lab_bench.h"

namespace soak::station {
namespace {

using namespace lab_bench;

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

}  // namespace
}  // namespace soak::station
