// SPDX-License-Identifier: Apache-2.0
#include "calib/estimate/detail/parts_of_run.h"

#include <algorithm>
#include <cmath>
#include <functional>

namespace soak::calib {
namespace {

constexpr double kSamePlateau_c = 1.0;  ///< how far the unit may be from where it was in the other part

bool has_scale_at(const SensorEstimate& estimate, double temp_c) {
  return std::ranges::any_of(estimate.plateaus, [&](const PlateauEstimate& plateau) {
    return plateau.scale_ppm && std::abs(plateau.temp_c - temp_c) < kSamePlateau_c;
  });
}

/// Whether one of the other parts has it.
using IsThere = std::function<bool(const SensorEstimate&)>;
using AnyOther = std::function<bool(const IsThere&)>;

bool all_shown(const SensorEstimate& own, bool with_scale, const AnyOther& any_other) {
  for (const PlateauEstimate& plateau : own.plateaus) {
    if (!with_scale || plateau.scale_ppm) continue;
    if (!any_other([&](const SensorEstimate& other) { return has_scale_at(other, plateau.temp_c); })) return false;
  }
  for (std::size_t j = 0; j < own.coupling.size(); ++j) {
    if (own.coupling[j]) continue;
    if (!any_other([&](const SensorEstimate& other) { return other.coupling[j].has_value(); })) return false;
  }
  if (!with_scale || own.even_order) return true;
  return any_other([](const SensorEstimate& other) { return other.even_order.has_value(); });
}

}  // namespace

std::string_view run_of_part(std::string_view name) {
  const std::size_t dot = name.rfind('.');
  if (dot == std::string_view::npos || dot == 0 || dot + 1 == name.size()) return name;
  const std::string_view number = name.substr(dot + 1);
  const bool is_number = std::ranges::all_of(number, [](char c) { return c >= '0' && c <= '9'; });
  return is_number ? name.substr(0, dot) : name;
}

bool shown_by_other_parts(const std::vector<std::string>& names, const std::vector<SixPositionEstimate>& estimates,
                          std::size_t part, Sensor sensor) {
  const std::string_view run = run_of_part(names[part]);
  if (std::ranges::find(names, run) == names.end()) return false;
  const auto any_other = [&](const IsThere& is_there) {
    for (std::size_t i = 0; i < estimates.size(); ++i) {
      if (i == part || run_of_part(names[i]) != run) continue;
      if (is_there(estimates[i].sensor[index_of(sensor)])) return true;
    }
    return false;
  };
  if (!any_other([](const SensorEstimate& other) { return !other.plateaus.empty(); })) return false;
  return all_shown(estimates[part].sensor[index_of(sensor)], !is_gyro(sensor), any_other);
}

}  // namespace soak::calib
