// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "station/gap/gap_search.h"

namespace soak::station {
namespace {

constexpr double kFirst_s = 1.7e9;

db::RunInfo run(const std::string& source, double created_utc_s, double clock_rate = 1.0) {
  db::RunInfo info;
  info.source = source;
  info.created_utc_s = created_utc_s;
  info.clock_rate = clock_rate;
  return info;
}

TEST(TimesOfRuns, ARunOfTheStationBeganWhenItsFileWasMade) {
  const auto begun = begun_utc_s({run("soakd", kFirst_s), run("soakd", kFirst_s + 86400.0)});
  EXPECT_EQ(begun, (std::vector<std::optional<double>>{kFirst_s, kFirst_s + 86400.0}));
}

TEST(TimesOfRuns, AnImportedRunBeganAtATimeThatNobodyKnows) {
  const auto begun = begun_utc_s({run("import r1.csv", kFirst_s), run("soakd", kFirst_s + 60.0)});
  EXPECT_EQ(begun, (std::vector<std::optional<double>>{std::nullopt, kFirst_s + 60.0}));
}

TEST(TimesOfRuns, HoursOfASimulatedLaboratoryGoByAsFastAsItsClock) {
  const auto begun = begun_utc_s({run("soakd", kFirst_s, 300.0), run("soakd", kFirst_s + 120.0, 300.0)});
  EXPECT_EQ(begun[1].value() - begun[0].value(), 36000.0);
}

TEST(TimesOfRuns, RunsOfAnotherClockHaveNoPlaceAmongTheOthers) {
  const auto begun =
      begun_utc_s({run("soakd", kFirst_s, 300.0), run("soakd", kFirst_s + 120.0), run("soakd", kFirst_s + 240.0)});
  EXPECT_EQ(begun, (std::vector<std::optional<double>>{std::nullopt, kFirst_s + 120.0, kFirst_s + 240.0}));
}

}  // namespace
}  // namespace soak::station
