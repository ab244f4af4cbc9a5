// SPDX-License-Identifier: Apache-2.0
#include "station/config/rating_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>

namespace soak::station {
namespace {

/// The first set point of a run, its end included, from which the air, passing it by `overshoot_c`, leaves the range.
std::optional<double> first_outside(const Procedure& procedure, double overshoot_c, std::optional<double> min_c,
                                    std::optional<double> max_c) {
  const auto outside = [&](double temp_c) {
    return (min_c && temp_c - overshoot_c < *min_c) || (max_c && temp_c + overshoot_c > *max_c);
  };
  const auto& points = procedure.set_points_c;
  const auto found = std::find_if(points.begin(), points.end(), outside);
  if (found != points.end()) return *found;
  return outside(procedure.end_c) ? std::optional(procedure.end_c) : std::nullopt;
}

std::string type_finding(const Procedure& procedure, const calib::UnitType& type) {
  if (!type.temp_min_c || !type.temp_max_c) {
    return fmt::format("unit type '{}' states no temperature rating: nobody knows what it bears", type.name);
  }
  const auto point = first_outside(procedure, procedure.overshoot_c, type.temp_min_c, type.temp_max_c);
  if (!point) return {};
  return fmt::format("unit type '{}' is rated {} to {} °C: the set point {} °C with an overshoot of {} °C leaves it",
                     type.name, *type.temp_min_c, *type.temp_max_c, *point, procedure.overshoot_c);
}

std::string chamber_finding(const Procedure& procedure, std::optional<double> min_c, std::optional<double> max_c) {
  constexpr double overshoot_c = 0.0;
  const auto point = first_outside(procedure, overshoot_c, min_c, max_c);
  if (!point) return {};
  const auto limit = [](std::optional<double> value_c) { return value_c ? fmt::format("{}", *value_c) : "any"; };
  return fmt::format("the chamber takes set points from {} to {} °C: {} °C is outside", limit(min_c), limit(max_c),
                     *point);
}

}  // namespace

std::vector<std::string> rating_findings(const Procedure& procedure, const std::vector<calib::UnitType>& types) {
  std::vector<std::string> findings;
  for (const calib::UnitType& type : types) findings.push_back(type_finding(procedure, type));
  std::erase(findings, "");
  return findings;
}

base::Status check_ratings(const Procedure& procedure, const std::vector<calib::UnitType>& types,
                           std::optional<double> chamber_min_c, std::optional<double> chamber_max_c) {
  auto findings = rating_findings(procedure, types);
  findings.push_back(chamber_finding(procedure, chamber_min_c, chamber_max_c));
  std::erase(findings, "");
  if (findings.empty()) return {};
  return base::bad_input(fmt::format("{}", fmt::join(findings, "\n")), procedure.file);
}

}  // namespace soak::station
