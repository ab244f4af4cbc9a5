// SPDX-License-Identifier: Apache-2.0
#include "nav/drive/drive.h"

#include <gtest/gtest.h>

#include <limits>

namespace soak::nav {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

Drive small_drive() {
  Drive drive;
  drive.name = "small";
  for (int i = 1; i <= 10; ++i) {
    ImuSample sample;
    sample.t_s = 0.1 * i;
    sample.rate_rps.x() = i;
    drive.imu.push_back(sample);
  }
  GnssFix fix;
  fix.t_s = 0.5;
  drive.gnss.push_back(fix);
  drive.truth.push_back({0.5});
  return drive;
}

/// The drive with a change is refused, and its name is told.
template <class Change>
void expect_refused(const char* what, Change change) {
  Drive drive = small_drive();
  change(drive);
  const auto status = validate(drive);
  ASSERT_FALSE(status) << what;
  EXPECT_EQ(status.error().kind, base::ErrorKind::bad_input) << what;
  EXPECT_EQ(status.error().where, "small") << what;
}

TEST(Drive, WhatCannotBeNavigatedIsRefused) {
  ASSERT_TRUE(validate(small_drive()));
  expect_refused("no readings", [](Drive& drive) { drive.imu.clear(); });
  expect_refused("one sample", [](Drive& drive) { drive.imu.resize(1); });
  expect_refused("time stands", [](Drive& drive) { drive.imu[4].t_s = drive.imu[3].t_s; });
  expect_refused("time is no number", [](Drive& drive) { drive.imu[4].t_s = kNaN; });
  expect_refused("reading is no number", [](Drive& drive) { drive.imu[4].force_mps2.y() = kNaN; });
  expect_refused("rate that cannot be", [](Drive& drive) { drive.imu[4].rate_rps.z() = -1e200; });
  expect_refused("force that cannot be", [](Drive& drive) { drive.imu[4].force_mps2.z() = 1e200; });
  expect_refused("readings are missing", [](Drive& drive) { drive.imu.erase(drive.imu.begin() + 4); });
  expect_refused("fix is no number", [](Drive& drive) { drive.gnss[0].position.height_m = kNaN; });
  expect_refused("fix at the pole", [](Drive& drive) { drive.gnss[0].position.latitude_rad = 1.57; });
  expect_refused("sigma 0", [](Drive& drive) { drive.gnss[0].position_sigma_m.x() = 0.0; });
  expect_refused("fixes run back", [](Drive& drive) { drive.gnss.push_back(drive.gnss[0]); });
  expect_refused("truth is no number", [](Drive& drive) { drive.truth[0].velocity_mps.x() = kNaN; });
}

TEST(Drive, AGapInTheReadingsIsToldWithTheSampleAfterIt) {
  Drive drive = small_drive();
  drive.imu.erase(drive.imu.begin() + 4);
  EXPECT_NE(validate(drive).error().message.find("sample 5: comes 0.200 s after"), std::string::npos);
}

TEST(ImuFeed, PiecesAddUpToTheSamples) {
  const Drive drive = small_drive();
  ImuFeed feed(drive.imu, 0.15);
  double turned_rad = 0.0;
  int pieces = 0;
  for (const double until_s : {0.17, 0.2, 0.33, 0.9, 2.0}) {
    while (const auto piece = feed.next(until_s)) {
      turned_rad += piece->duration_s * piece->sample->rate_rps.x();
      ++pieces;
    }
  }
  // Sample i is the rate of the tenth of a second that ends at i/10 s: half of the second, all from the third on.
  EXPECT_NEAR(turned_rad, 0.05 * 2 + 0.1 * (3 + 4 + 5 + 6 + 7 + 8 + 9 + 10), 1e-12);
  EXPECT_EQ(pieces, 11);
  EXPECT_NEAR(feed.now_s(), 1.0, 1e-12);
}

}  // namespace
}  // namespace soak::nav
