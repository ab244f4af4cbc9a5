// SPDX-License-Identifier: Apache-2.0
#include "station/config/plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <numeric>
#include <utility>

namespace soak::station {
namespace {

constexpr std::array<std::string_view, 10> kStepNames = {"turn_fixture",    "power_on",    "move",   "spin",
                                                         "set_temperature", "wait_stable", "record", "check",
                                                         "warm_end",        "power_off"};

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
      return step.rate_dps == 0.0 ? "stop the rotation"
                                  : fmt::format("rotate at {:+g} deg/s in {}", step.rate_dps, step.position);
    case StepKind::set_temperature:
      return "drive the chamber to the set point";
    case StepKind::wait_stable:
      return fmt::format("wait until settled{}, at most {:.0f} s", step.after_turn ? " after the turn" : "",
                         step.seconds);
    case StepKind::record:
      return fmt::format("record {:g} s at {}{}", step.seconds, step.position,
                         step.rate_dps == 0.0 ? "" : fmt::format(", {:+g} deg/s", step.rate_dps));
    case StepKind::check:
      return "check the pre-flight recordings";
    case StepKind::warm_end:
      return fmt::format("warm to {:+g} °C, then chamber off", step.temp_c);
    case StepKind::power_off:
      return step.seconds > 0.0 ? fmt::format("units off for {:g} s", step.seconds) : "units off";
  }
  return {};
}

nlohmann::json procedure_part(const Procedure& p) {
  return {{"name", p.name},
          {"description", p.description},
          {"file", p.file},
          {"purpose", name_of(p.purpose)},
          {"kind", name_of(p.kind)},
          {"runs", p.runs},
          {"set_points_c", p.set_points_c},
          {"positions", p.positions},
          {"dwell_s", p.dwell_s},
          {"end_c", p.end_c}};
}

nlohmann::json step_document(const Step& step) {
  nlohmann::json document = {{"kind", name_of(step.kind)},    {"run", step.run},
                             {"temp_c", step.temp_c},         {"sweep", calib::name_of(step.sweep)},
                             {"position", step.position},     {"seconds", step.seconds},
                             {"after_turn", step.after_turn}, {"estimate_s", step.estimate_s}};
  if (step.kind == StepKind::turn_fixture) document["heading_deg"] = step.heading_deg;
  if (step.rate_dps != 0.0) document["rate_dps"] = step.rate_dps;
  document["visit"] = step.visit >= 0 ? nlohmann::json(step.visit) : nlohmann::json();
  return document;
}

/// Of the run with that number: its plateaus, each with its first recording (null: a ramp), and the end of its
/// `warm_end`; `later_s`: from step `end` on. Times are those to the end of the plan.
nlohmann::json outline_of_run(const nlohmann::json& document, const nlohmann::json& run, std::ptrdiff_t end) {
  nlohmann::json plateaus = nlohmann::json::array();
  nlohmann::json later_s = 0.0;
  nlohmann::json warm = nullptr;
  double left_s = 0.0;
  const nlohmann::json& steps = document.at("steps");
  for (std::ptrdiff_t i = std::ssize(steps) - 1; i >= 0; --i) {
    const nlohmann::json& step = steps.at(static_cast<std::size_t>(i));
    const bool is_of_run = step.at("run") == run;
    if (is_of_run && step.at("kind") == name_of(StepKind::warm_end)) warm = {{"step", i}, {"after_s", left_s}};
    left_s += step.at("estimate_s").get<double>();
    if (i == end) later_s = left_s;
    if (!is_of_run || step.at("visit").is_null()) continue;
    if (plateaus.empty() || plateaus.back().at("visit") != step.at("visit")) {
      plateaus.push_back(
          {{"visit", step.at("visit")}, {"temp_c", step.at("temp_c")}, {"step", nullptr}, {"left_s", nullptr}});
    }
    if (step.at("kind") != name_of(StepKind::record)) continue;
    plateaus.back()["step"] = i;
    plateaus.back()["left_s"] = left_s;
  }
  std::ranges::reverse(plateaus);
  return {{"plateaus", std::move(plateaus)}, {"warm_end", std::move(warm)}, {"later_s", std::move(later_s)}};
}

}  // namespace

std::string_view name_of(StepKind kind) { return kStepNames.at(static_cast<std::size_t>(kind)); }

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

nlohmann::json plan_document(const Plan& plan) {
  nlohmann::json runs = nlohmann::json::array();
  for (const PlannedRun& run : plan.runs) {
    runs.push_back({{"label", run.label},
                    {"preflight", run.preflight},
                    {"first_step", run.first_step},
                    {"last_step", run.last_step}});
  }
  nlohmann::json steps = nlohmann::json::array();
  for (const Step& step : plan.steps) steps.push_back(step_document(step));
  return {{"procedure", procedure_part(plan.procedure)},
          {"runs", std::move(runs)},
          {"steps", std::move(steps)},
          {"estimate_s", plan.estimate_s()}};
}

base::Result<nlohmann::json> plan_around(const nlohmann::json& document, std::int64_t step) {
  const nlohmann::json& steps = document.at("steps");
  if (step < 0 || step >= std::ssize(steps)) {
    return base::bad_input(fmt::format("the plan has {} steps, numbered from 0: there is no {}", steps.size(), step),
                           "around");
  }
  const nlohmann::json& asked = steps.at(static_cast<std::size_t>(step));
  const auto belongs = [&](std::ptrdiff_t i) {
    const nlohmann::json& other = steps.at(static_cast<std::size_t>(i));
    return other.at("run") == asked.at("run") && other.at("visit") == asked.at("visit");
  };
  std::ptrdiff_t first = step;
  std::ptrdiff_t end = step + 1;
  while (first > 0 && belongs(first - 1)) --first;
  while (end < std::ssize(steps) && belongs(end)) ++end;
  nlohmann::json part = {{"procedure", document.at("procedure")},
                         {"runs", document.at("runs")},
                         {"steps", nlohmann::json::array_t(steps.begin() + first, steps.begin() + end)},
                         {"first_step", first},
                         {"estimate_s", document.at("estimate_s")}};
  part.update(outline_of_run(document, asked.at("run"), end));
  return part;
}

}  // namespace soak::station
