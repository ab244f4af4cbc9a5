// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <numbers>

#include "calib/segments/detail/checks.h"

namespace soak::calib::gate {
namespace {

/// A rounded temperature is off by up to half a step, √(1/12) of it in the mean square.
constexpr double kRounding = 0.28867513459481287;

void judge(const View& view, double step_c, std::optional<Sensor> sensor, std::vector<Finding>& findings) {
  if (step_c < view.limits.coarse_step_c) return;
  const std::string whose = sensor ? fmt::format("the thermometer of {}", name_of(*sensor)) : "the unit's thermometer";
  findings.push_back(
      {"coarse_thermometer", Severity::warn, sensor,
       fmt::format("{} moves in steps of {:.2g} K (finer than {:.2g} K would be right): temperatures are off by "
                   "{:.2g} K (1 sigma), rates of change are false, and the curve is smeared by its slope times that",
                   whose, step_c, view.limits.coarse_step_c, kRounding * step_c)});
}

}  // namespace

void coarse_thermometer(const View& view, std::vector<Finding>& findings) {
  const double type_step_c = view.type.temp_lsb_c.value_or(0.0);
  judge(view, std::max(type_step_c, view.facts.temp_step_c), std::nullopt, findings);
  for (const Sensor sensor : kSensors) {
    judge(view, view.facts.sensor_temp_step_c[index_of(sensor)], sensor, findings);
  }
}

}  // namespace soak::calib::gate
