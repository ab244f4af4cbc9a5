// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "calib/vocabulary/unit_type.h"
#include "station/config/plan.h"
#include "station/config/procedure.h"
#include "station/import/columns_map.h"
#include "tests/fuzz/targets.h"

namespace soak::fuzz {
namespace {

/// Compiling takes a while for the longest of procedures; those are no more interesting than their beginning.
constexpr std::size_t kMostStepsToDescribe = 2000;

void check_plan(const station::Plan& plan) {
  require(!plan.steps.empty() && !plan.runs.empty(), "a procedure has runs and steps");
  require(std::isfinite(plan.estimate_s()) && plan.estimate_s() >= 0.0, "the estimate is a time");
  require(plan.remaining_s(plan.steps.size()) == 0.0, "nothing remains after the last step");
  for (const station::Step& step : plan.steps) {
    require(std::isfinite(step.temp_c) && std::isfinite(step.seconds), "steps have finite numbers");
    require(step.run >= 0 && static_cast<std::size_t>(step.run) < plan.runs.size(), "each step belongs to a run");
  }
  for (std::size_t i = 0; i < std::min(plan.steps.size(), kMostStepsToDescribe); ++i) {
    require(!describe(plan, i).empty(), "each step has a line for the operator");
  }
  if (plan.steps.size() <= kMostStepsToDescribe) {
    // Throws for text that is not UTF-8: the plan goes out over HTTP.
    require(!plan_document(plan).dump().empty(), "the plan is a document");
  }
}

const std::vector<calib::UnitType> kRated = {{.name = "rated", .temp_min_c = -60.0, .temp_max_c = 100.0}};

bool check_procedure(std::string_view text) {
  const auto procedure = station::parse_procedure(text, "fuzz.toml");
  const auto within_rating = station::parse_procedure(text, "fuzz.toml", kRated);
  require(procedure || !within_rating, "a rating refuses procedures and allows none");
  if (!procedure) {
    require(!procedure.error().message.empty(), "a refusal says why");
    return false;
  }
  check_plan(station::compile_plan(*procedure));
  return true;
}

bool check_columns_map(std::string_view text) {
  const auto map = station::parse_columns_map(text, "fuzz.toml");
  if (!map) {
    require(!map.error().message.empty(), "a refusal says why");
    return false;
  }
  const std::string written = station::columns_map_text(*map);
  const auto again = station::parse_columns_map(written, "again.toml");
  require(again.has_value(), "a columns map that is written can be read");
  require(station::columns_map_text(*again) == written, "a columns map that is read back is the same");
  return true;
}

}  // namespace

bool procedure(Input input) {
  const bool is_procedure = check_procedure(as_text(input));
  const bool is_columns_map = check_columns_map(as_text(input));
  return is_procedure || is_columns_map;
}

}  // namespace soak::fuzz
