// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "calib/gap/effects/effect.h"

/// What the files of this folder make their effects from.
namespace soak::calib::gap {

/// Middle of the campaign's range of temperature, and half of the range (1 with a single level), °C and kelvin.
[[nodiscard]] double middle_c(const Observations& observations);
[[nodiscard]] double half_range_c(const Observations& observations);
/// Temperature of each observation about that middle, −1 to 1 over the range.
[[nodiscard]] Eigen::VectorXd reduced_temperature(const Observations& observations);

[[nodiscard]] Eigen::VectorXd as_vector(const std::vector<double>& values);

/// The same columns for all sensors.
[[nodiscard]] Candidate for_all(std::string shape, std::vector<double> shape_values, const Eigen::MatrixXd& columns);
/// That of one column, and that of the column beside the column times the reduced temperature ("linear in
/// temperature").
[[nodiscard]] std::vector<Candidate> constant_and_linear(const Observations& observations, const std::string& shape,
                                                         const std::vector<double>& shape_values,
                                                         const Eigen::VectorXd& column);
/// The candidates of each value of the shape, side by side.
template <class Grid, class OfShape>
[[nodiscard]] std::vector<Candidate> over_grid(const RegressorInputs& inputs, const Grid& grid, OfShape of_shape) {
  std::vector<Candidate> list;
  for (const double value : grid) {
    for (Candidate& candidate : of_shape(inputs, value)) list.push_back(std::move(candidate));
  }
  return list;
}
/// Second thermal nodes that are tried on ramps, and how a shape says in what state a run starts.
inline constexpr std::array kRampTaus_s = {30.0, 60.0, 120.0, 240.0, 480.0, 960.0};
[[nodiscard]] std::string_view start_text(bool under_way);
/// Numbers of the shape of such a node: its time constant, and in what state each run starts.
[[nodiscard]] std::vector<TermParameter> node_shape(double tau_s, bool under_way);
inline constexpr double kMinute_s = 60.0;
/// Sine and cosine of the time of day, a row for each observation; no column where Unix times are not known.
[[nodiscard]] Eigen::MatrixXd time_of_day(const RegressorInputs& in);
/// Slope of the thermometer, K/min.
[[nodiscard]] Eigen::VectorXd rate_kpmin(const TemperatureHistory& history);
/// On ramps, a logged channel about its mean; nothing where it was not logged or never moved.
[[nodiscard]] OnRamps channel_on_ramps(const std::vector<double>& channel, std::string_view per);
/// Mean of a channel that was logged; 0 where it was not.
[[nodiscard]] double mean_of(const std::vector<double>& channel);

/// Why a campaign in one attitude cannot show what follows the positions.
[[nodiscard]] std::optional<std::string> one_attitude_only(const RegressorInputs& in);
/// Why a channel cannot show what follows it: it was not logged, or moved by less than `least`; nothing where it can.
[[nodiscard]] std::optional<std::string> unmoved_channel(const std::vector<double>& channel, double least,
                                                         std::string_view name);

/// "rad/s" or "m/s2".
[[nodiscard]] std::string si_unit(Sensor sensor);
/// "x", "y", "z" of an axis, counted on cyclically.
[[nodiscard]] std::string axis_name(std::size_t axis);

/// Magnitude of a linear term with one parameter (the first): printed unit, then `per` ("/V").
[[nodiscard]] Magnitude linear_magnitude(Sensor sensor, const Eigen::VectorXd& parameters, double factor,
                                         std::string_view per);
/// Meaning of constant_and_linear() in one sensor: `name` at the middle of the range and, with two columns, its slope
/// against temperature. `per`: what follows the sensor's unit ("/(K/s)").
[[nodiscard]] Meaning temperature_shaped(const Observations& observations, const Candidate& candidate, Sensor sensor,
                                         std::string_view name, std::string_view per);

}  // namespace soak::calib::gap
