// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <array>
#include <cmath>

#include "calib/gap/effects/columns.h"
#include "calib/gap/effects/detail/list.h"

namespace soak::calib::gap {
namespace {

constexpr std::array kTaus_s = {10.0, 20.0, 40.0, 80.0, 160.0, 320.0, 640.0, 1280.0};

/// A lag of tau moves the temperature by what its course says, not by a tenth of it: what fits a long tau with a small
/// factor is a memory of another kind. Wide enough for the steps of the grid.
constexpr double kLeastFactor = 0.35;
constexpr double kMostFactor = 2.8;

/// The temperatures of a sensor's own thermometer, moved.
std::vector<double> shifted(const Circumstances& c, Sensor sensor, std::vector<double> by_c) {
  for (std::size_t i = 0; i < by_c.size(); ++i) by_c[i] += c.observations.rows[i].sensor_temp_c[index_of(sensor)];
  return by_c;
}

std::vector<Candidate> of_tau(const Circumstances& c, double tau_s) {
  Candidate candidate{.shape = fmt::format("tau {:.3g} s", tau_s), .shape_values = {tau_s}, .shared = true};
  const std::vector<double> behind = c.courses.lag(tau_s);
  for (const Sensor sensor : kSensors) {
    const std::size_t s = index_of(sensor);
    if (c.slope[s].size() == 0) continue;
    candidate.columns[s] =
        c.read_at ? c.read_at(sensor, shifted(c, sensor, behind)) : c.slope[s].cwiseProduct(as_vector(behind));
  }
  return {std::move(candidate)};
}

}  // namespace

Effect sensor_lag() {
  Effect effect;
  effect.name = "sensor_lag";
  effect.physics =
      "the sensing elements follow the air behind the thermometer by a time constant: every curve is read "
      "at another temperature, so that a sensor feels it as much as its curve is steep";
  effect.twins = {"temperature_rate"};
  effect.experiment = "a fast and a slow ramp, with the chamber's air logged";
  effect.missing = [](const Circumstances& c) -> std::optional<std::string> {
    if (!c.courses.continuous()) return "the temperature between the plateaus was not logged";
    return c.courses.blurred();
  };
  effect.of_course = true;
  effect.candidates = [](const Circumstances& c) { return over_grid(c, kTaus_s, of_tau); };
  effect.of_shape = of_tau;
  effect.plausible = [](const Circumstances&, const Candidate&, const Eigen::VectorXd& theta, const Eigen::MatrixXd&) {
    return std::abs(theta(0)) > kLeastFactor && std::abs(theta(0)) < kMostFactor;
  };
  effect.magnitude = [](const Circumstances&, const Candidate& candidate, Sensor, const Eigen::VectorXd& theta) {
    return Magnitude{candidate.shape_values.front() * theta(0), "s"};
  };
  effect.meaning = [](const Circumstances&, const Candidate& candidate, Sensor) {
    return Meaning{{{"factor", "1"}}, {{"tau_s", candidate.shape_values.front(), "s"}}};
  };
  effect.lab_only = false;
  return effect;
}

}  // namespace soak::calib::gap
