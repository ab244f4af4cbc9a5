// SPDX-License-Identifier: Apache-2.0
#include "station/config/plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

namespace soak::station {
namespace {

double sum_from(const std::vector<Step>& steps, std::size_t first) {
  const auto begin = steps.begin() + static_cast<std::ptrdiff_t>(std::min(first, steps.size()));
  return std::accumulate(begin, steps.end(), 0.0, [](double sum, const Step& step) { return sum + step.estimate_s; });
}

/// What is done in a step, without when and where.
std::string action_text(const Step& step) {
  switch (step.kind) {
    case StepKind::turn_fixture:
      return step.heading_deg == 0.0
                 ? "turn the whole fixture back to its usual heading, by hand"
                 : fmt::format("turn the whole fixture to {:+g}° of its usual heading, by hand", step.heading_deg);
    case StepKind::power_on:
      return "units on";
    case StepKind::move:
      return fmt::format("turn to {}", step.position);
    case StepKind::spin:
      return step.rate_dps == 0.0 ? "halt the turning"
                                  : fmt::format("turn at {:+g} deg/s in {}", step.rate_dps, step.position);
    case StepKind::set_temperature:
      return "drive the chamber there";
    case StepKind::wait_stable:
      return fmt::format("wait until settled{}, at most {:.0f} s", step.after_turn ? " after the turn" : "",
                         step.seconds);
    case StepKind::record:
      return fmt::format("record {:g} s at {}{}", step.seconds, step.position,
                         step.rate_dps == 0.0 ? "" : fmt::format(", {:+g} deg/s", step.rate_dps));
    case StepKind::check:
      return "judge the pre-flight recordings";
    case StepKind::warm_end:
      return fmt::format("warm to {:+g} °C, then chamber off", step.temp_c);
    case StepKind::power_off:
      return step.seconds > 0.0 ? fmt::format("units off for {:g} s", step.seconds) : "units off";
  }
  return {};
}

}  // namespace

double Plan::estimate_s() const { return sum_from(steps, 0); }

double Plan::remaining_s(std::size_t index) const { return sum_from(steps, index); }

std::string describe(const Plan& plan, std::size_t step_index) {
  const Step& step = plan.steps.at(step_index);
  std::string text = plan.runs.at(static_cast<std::size_t>(step.run)).label;
  if (step.visit >= 0) {
    text += fmt::format(" visit {}, {:+g} °C", step.visit, step.temp_c);
    if (step.sweep != calib::Sweep::unknown) text += fmt::format(" {}", calib::name_of(step.sweep));
  }
  return fmt::format("{}: {}", text, action_text(step));
}

}  // namespace soak::station
