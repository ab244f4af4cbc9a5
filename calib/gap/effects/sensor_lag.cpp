// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <array>
#include <cmath>

#include "calib/gap/effects/columns.h"

namespace soak::calib::gap {
namespace {

/// Every curve is read at the temperatures of a sensor's own thermometer, moved by the lag.
std::vector<Candidate> lag_of_tau(const RegressorInputs& in, double tau_s) {
  Candidate candidate{.shape = fmt::format("tau {:.3g} s", tau_s), .shape_values = {tau_s}, .shared = true};
  const std::vector<double> behind = in.history.lag(tau_s);
  for (const Sensor sensor : kSensors) {
    const std::size_t s = index_of(sensor);
    if (in.slope[s].size() == 0) continue;
    std::vector<double> element_c = behind;
    for (std::size_t i = 0; i < element_c.size(); ++i) element_c[i] += in.observations.rows[i].sensor_temp_c[s];
    candidate.columns[s] = in.read_at ? in.read_at(sensor, element_c) : in.slope[s].cwiseProduct(as_vector(behind));
  }
  return {std::move(candidate)};
}

/// Lags of 30 to 960 s, each run at rest or under way at its start, and leads of 30 to 240 s.
OnRamps lag_on_ramps(const Observations&, const TemperatureHistory& history) {
  OnRamps made{.size = OnRamps::Size::time_constant};
  made.meaning = [](const Candidate& candidate, Sensor) {
    Meaning meaning{{}, node_shape(candidate.shape_values.at(0), candidate.shape_values.at(1) > 0.0)};
    meaning.given.insert(meaning.given.begin(), {"factor", 1.0, "1"});
    return meaning;
  };
  const auto add = [&](std::string shape, double tau_s, bool under_way, const Eigen::VectorXd& moved_c) {
    made.candidates.push_back(for_all(std::move(shape), {tau_s, under_way ? 1.0 : 0.0}, moved_c));
    made.candidates.back().shared = made.candidates.back().shifts = true;
  };
  for (const double tau_s : kRampTaus_s) {
    for (const bool under_way : {false, true}) {
      add(fmt::format("tau {:g} s{}", tau_s, start_text(under_way)), tau_s, under_way,
          as_vector(history.lag(tau_s, under_way)));
    }
  }
  for (const double lead_s : {30.0, 60.0, 120.0, 240.0}) {
    add(fmt::format("tau {:g} s", -lead_s), -lead_s, false, lead_s / kMinute_s * rate_kpmin(history));
  }
  return made;
}

}  // namespace

Effect sensor_lag() {
  Effect effect;
  effect.name = "sensor_lag";
  effect.physics =
      "the sensing elements follow the air behind the thermometer by a time constant: every curve is read at the wrong "
      "temperature, and a sensor is affected in proportion to the slope of its curve";
  effect.twins = {"temperature_rate"};
  effect.experiment = "a fast and a slow ramp, with the chamber's air logged";
  effect.missing = [](const RegressorInputs& in) -> std::optional<std::string> {
    if (!in.history.continuous()) return "the temperature between the plateaus was not logged";
    return in.history.blurred();
  };
  effect.follows_history = true;
  effect.candidates = [](const RegressorInputs& in) {
    return over_grid(in, std::array{10.0, 20.0, 40.0, 80.0, 160.0, 320.0, 640.0, 1280.0}, lag_of_tau);
  };
  effect.of_shape = lag_of_tau;
  effect.on_ramps = lag_on_ramps;
  // A lag of tau moves the temperature by what its history says, not by a tenth of it: what fits a long tau with a
  // small factor is a memory of another kind. Wide enough for the steps of the grid.
  effect.plausible = [](const RegressorInputs&, const Candidate&, const Eigen::VectorXd& theta,
                        const Eigen::MatrixXd&) {
    constexpr double kLeastFactor = 0.35;
    constexpr double kMostFactor = 2.8;
    return std::abs(theta(0)) > kLeastFactor && std::abs(theta(0)) < kMostFactor;
  };
  effect.magnitude = [](const RegressorInputs&, const Candidate& candidate, Sensor, const Eigen::VectorXd& theta) {
    return Magnitude{candidate.shape_values.front() * theta(0), "s"};
  };
  effect.meaning = [](const RegressorInputs&, const Candidate& candidate, Sensor) {
    return Meaning{{{"factor", "1"}}, {{"tau_s", candidate.shape_values.front(), "s"}}};
  };
  effect.lab_only = false;
  return effect;
}

}  // namespace soak::calib::gap
