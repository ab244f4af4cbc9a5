// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/config/campaign_config.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>
#include <utility>

#include "tests/sim/support.h"

namespace soak::hal::sim {
namespace {

/// The shipped text with one passage replaced.
std::string shipped_text_with(const std::string& passage, const std::string& replacement) {
  std::string text = test::content_of(test::kShippedConfig);
  const std::size_t at = text.find(passage);
  EXPECT_NE(at, std::string::npos) << passage;
  return text.replace(at, passage.size(), replacement);
}

std::string line_of(const std::string& text, const std::string& passage) {
  const std::string before = text.substr(0, text.find(passage));
  return "lab.toml:" + std::to_string(1 + std::count(before.begin(), before.end(), '\n'));
}

struct Mistake {
  std::string passage;
  std::string replacement;
  std::string named;
};

TEST(CampaignConfig, NamesEveryMistakeWithItsLine) {
  const Mistake mistakes[] = {
      {"units = 3", "units = 0", "campaign.units"},
      {"units = 3", "units = 3.5", "campaign.units"},
      {"slow_share = 0.3", "slow_share = 1.3", "noise.slow_share"},
      {"slow_share = 0.3", "slow_share = nan", "noise.slow_share"},
      {"feature_sigma_c = [6.0, 9.0]", "feature_sigma_c = [9.0, 6.0]", "feature_sigma_c"},
      {"feature_count = [1, 2]", "feature_count = [1, 2.5]", "feature_count"},
      {"feature_count = [1, 2]", "feature_count = 2", "feature_count"},
      {"slow_correlation_times_s = [20.0, 200.0, 2000.0]", "slow_correlation_times_s = []", "slow_correlation_times_s"},
      {"step_c = 5.0", "step_c = 7.0", "step_c"},
      {"turn_c = 70.0", "turn_c = -70.0", "turn_c"},
      {"bias_span_dps = [0.42, 0.58]", "bias_span_dps = [0.1, 0.58]", "bias_span_dps"},
      {"feature_margin_c = 10.0", "feature_margin_c = 80.0", "feature_margin_c"},
      {"# latitude_deg = 51.08", "latitude_deg = 51.08", "latitude_deg"},
      {"[chamber]", "[chamber]\nhumidity = 3", "'humidity'"},
  };
  for (const Mistake& mistake : mistakes) {
    const std::string text = shipped_text_with(mistake.passage, mistake.replacement);
    const auto config = parse_campaign_config(text, "lab.toml");
    ASSERT_FALSE(config) << mistake.replacement;
    EXPECT_EQ(config.error().kind, base::ErrorKind::bad_input);
    EXPECT_NE(config.error().message.find(mistake.named), std::string::npos) << config.error().message;
    const std::string& marker = mistake.named == "'humidity'" ? "humidity" : mistake.replacement;
    EXPECT_EQ(config.error().where, line_of(text, marker)) << mistake.replacement;
  }
}

TEST(CampaignConfig, NamesEveryMistakeInHiddenEffectsAndDesigns) {
  const std::pair<std::string, std::string> mistakes[] = {
      {"[[hidden]]\neffect = \"gremlins\"\nmagnitude = 1.0\nseed = 1", "thermal_hysteresis"},
      {"[[hidden]]\neffect = \"sensor_lag\"\nseed = 1", "'amplitude'"},
      {"[[hidden]]\neffect = \"sensor_lag\"\nmagnitude = 1.0\namplitude = 1.0\nseed = 1", "'magnitude'"},
      {"[[hidden]]\neffect = \"sensor_lag\"\nmagnitude = 0.0\nseed = 1", "hidden[1].magnitude"},
      {"[[hidden]]\neffect = \"sensor_lag\"\namplitude = -5.0\nseed = 1", "'amplitude'"},
      {"[[hidden]]\neffect = \"sensor_lag\"\namplitude = 5.0", "'hidden[1].seed'"},
      {"[[hidden]]\neffect = \"sensor_lag\"\namplitude = 5.0\nseed = 1\nsensors = [\"gyro_x\"]", "sensor_lag"},
      {"[[hidden]]\neffect = \"g_sensitivity\"\namplitude = 5.0\nseed = 1\nsensors = [\"accel_x\"]", "g_sensitivity"},
      {"[[hidden]]\neffect = \"g_sensitivity\"\namplitude = 5.0\nseed = 1\nsensors = [\"gyro\"]", "gyro"},
      {"[[hidden]]\neffect = \"g_sensitivity\"\namplitude = 5.0\nseed = 1\nsize = 3", "'size'"},
      {"[hidden]\neffect = \"g_sensitivity\"", "[[hidden]]"},
      {"[design]\nkind = \"seven\"", "identical"},
      {"[design]\nruns = 0", "design.runs"},
      {"[design]\nruns = 2.5", "design.runs"},
      {"[design]\ngyro_block_sigma_dps = 0.0", "gyro_block_sigma_dps"},
      {"[design]\ndropped_visit = 1", "dropped_visit"},
      {"[design]\nvisits = 3", "'visits'"},
  };
  for (const auto& [added, named] : mistakes) {
    const auto config = parse_campaign_config(test::content_of(test::kShippedConfig) + "\n" + added + "\n", "lab.toml");
    ASSERT_FALSE(config) << added;
    EXPECT_EQ(config.error().kind, base::ErrorKind::bad_input);
    EXPECT_NE(config.error().message.find(named), std::string::npos) << config.error().message;
  }
}

TEST(CampaignConfig, ListsEveryKeyOfADesignWithItsDefaultInTheShippedFile) {
  std::istringstream shipped(test::content_of(test::kShippedConfig));
  std::string text;
  bool in_design = false;
  int keys = 0;
  for (std::string line; std::getline(shipped, line);) {
    if (line == "# [design]") in_design = true;
    if (line.empty()) in_design = false;
    text += (in_design ? line.substr(2) : line) + "\n";
    keys += in_design ? 1 : 0;
  }
  const auto config = parse_campaign_config(text, "lab.toml");
  ASSERT_TRUE(config) << config.error().message;
  ASSERT_TRUE(config->design);
  EXPECT_EQ(*config->design, default_design(DesignKind::identical));
  EXPECT_EQ(keys, 1 + 24);
}

TEST(CampaignConfig, NamesTheLineOfAMistakeInAHiddenEffect) {
  const std::string text = test::content_of(test::kShippedConfig) +
                           "\n[[hidden]]\neffect = \"sensor_lag\"\nseed = 1\namplitude = 5.0\n"
                           "[[hidden]]\neffect = \"supply_sensitivity\"\nseed = 1\nmagnitude = -5.0\n";
  const auto config = parse_campaign_config(text, "lab.toml");
  ASSERT_FALSE(config);
  EXPECT_EQ(config.error().where, line_of(text, "magnitude = -5.0"));
}

TEST(CampaignConfig, HidesNothingAndDesignsNothingUnlessAsked) {
  EXPECT_TRUE(test::shipped_config().hidden.empty());
  EXPECT_FALSE(test::shipped_config().design);
}

TEST(CampaignConfig, NamesAMissingKeyAndTheFile) {
  const auto config = parse_campaign_config(shipped_text_with("ramp_rows = 8", ""), "lab.toml");
  ASSERT_FALSE(config);
  EXPECT_NE(config.error().message.find("'campaign.ramp_rows'"), std::string::npos);
  EXPECT_EQ(config.error().where, line_of(test::content_of(test::kShippedConfig), "[campaign]"));
}

TEST(CampaignConfig, NamesTheLineOfASyntaxError) {
  const auto config = parse_campaign_config("[campaign]\nseed = = 1\n", "lab.toml");
  ASSERT_FALSE(config);
  EXPECT_EQ(config.error().where, "lab.toml:2");
}

TEST(CampaignConfig, TakesAnEarthFrameOnlyWhenBothAnglesAreGiven) {
  EXPECT_FALSE(test::shipped_config().earth);
  const auto config = parse_campaign_config(
      shipped_text_with("\n[site]", "\n[site]\nlatitude_deg = -12.5\nazimuth_deg = 80"), "lab.toml");
  ASSERT_TRUE(config) << config.error().message;
  const EarthFrame earth = config->earth.value_or(EarthFrame{});
  EXPECT_EQ(earth.latitude_deg, -12.5);
  EXPECT_EQ(earth.azimuth_deg, 80.0);
}

}  // namespace
}  // namespace soak::hal::sim
