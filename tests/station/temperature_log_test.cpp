// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "station/lab/campaign_log.h"

namespace soak::station {
namespace {

/// 35 hours of a campaign, a point a second, temperatures with all their digits.
nlohmann::json history_of(std::size_t units) {
  TemperatureLog log;
  std::vector<std::string> serials;
  for (std::size_t u = 0; u < units; ++u) serials.push_back("0380A" + std::to_string(100 + u));
  log.begin(serials);
  for (int second = 0; second < 35 * 3600; ++second) {
    const double temp_c = -20.0 + second / 1733.0;
    log.add(second, temp_c, 20.0, std::vector<std::optional<double>>(units, temp_c + 1.0 / 3.0));
  }
  return log.document(-1.0);
}

class TemperatureLogOf : public ::testing::TestWithParam<std::size_t> {};

TEST_P(TemperatureLogOf, ALongCampaignStaysSmallAndReachesFromItsBeginToItsEnd) {
  const nlohmann::json history = history_of(GetParam());
  const auto& t_s = history.at("t_s");
  EXPECT_LE(history.dump().size(), 80'000U);
  EXPECT_GE(t_s.size(), 128U);
  EXPECT_EQ(t_s.front(), 0.0);
  const double spacing_s = t_s[1].get<double>() - t_s[0].get<double>();
  EXPECT_GT(t_s.back().get<double>(), 35 * 3600 - 1 - 2.0 * spacing_s);
  for (std::size_t i = 1; i < t_s.size(); ++i) EXPECT_EQ(t_s[i].get<double>() - t_s[i - 1].get<double>(), spacing_s);
  EXPECT_EQ(history.at("units").size(), GetParam());
  for (const auto& [serial, values] : history.at("units").items()) EXPECT_EQ(values.size(), t_s.size()) << serial;
}

INSTANTIATE_TEST_SUITE_P(Units, TemperatureLogOf, ::testing::Values(1U, 2U, 16U, 32U));

TEST(TemperatureLog, TellsTemperaturesToAHundredthAndWhatIsNotKnownAsNull) {
  TemperatureLog log;
  log.begin({"0380A001"});
  log.add(10.0, 20.123456, std::nullopt, {std::nullopt});
  EXPECT_EQ(log.document(0.0), nlohmann::json({{"t_s", {10.0}},
                                               {"chamber_c", {20.12}},
                                               {"set_point_c", {nullptr}},
                                               {"units", {{"0380A001", nlohmann::json::array({nullptr})}}}}));
}

TEST(TemperatureLog, TellsOnlyWhatCameAfterATime) {
  TemperatureLog log;
  log.begin({});
  for (int second = 0; second < 10; ++second) log.add(second, 20.0, 20.0, {});
  EXPECT_EQ(log.document(6.0).at("t_s"), nlohmann::json({7.0, 8.0, 9.0}));
}

}  // namespace
}  // namespace soak::station
