// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/effects/columns.h"

#include <fmt/format.h>
#include <numbers>

namespace soak::calib::gap {

double middle_c(const Observations& observations) {
  return 0.5 * (observations.level_c.back() + observations.level_c.front());
}

double half_range_c(const Observations& observations) {
  const double half = 0.5 * (observations.level_c.back() - observations.level_c.front());
  return half > 0.0 ? half : 1.0;
}

Eigen::VectorXd reduced_temperature(const Observations& observations) {
  const double middle = middle_c(observations);
  const double half = half_range_c(observations);
  Eigen::VectorXd z(static_cast<Eigen::Index>(observations.rows.size()));
  for (Eigen::Index i = 0; i < z.size(); ++i) {
    z(i) = (observations.rows[static_cast<std::size_t>(i)].temp_c - middle) / half;
  }
  return z;
}

Eigen::VectorXd as_vector(const std::vector<double>& values) {
  return Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
}

Candidate for_all(std::string shape, std::vector<double> shape_values, const Eigen::MatrixXd& columns) {
  Candidate candidate{.shape = std::move(shape), .shape_values = std::move(shape_values)};
  candidate.columns.fill(columns);
  return candidate;
}

std::vector<Candidate> constant_and_linear(const Observations& observations, const std::string& shape,
                                           const std::vector<double>& shape_values, const Eigen::VectorXd& column) {
  constexpr const char* kLinear = "linear in temperature";
  Eigen::MatrixXd both(column.size(), 2);
  both << column, column.cwiseProduct(reduced_temperature(observations));
  return {for_all(shape, shape_values, column),
          for_all(shape.empty() ? kLinear : shape + ", " + kLinear, shape_values, both)};
}

std::string_view start_text(bool under_way) {
  return under_way ? ", under way at the start" : ", at rest at the start";
}

std::vector<TermParameter> node_shape(double tau_s, bool under_way) {
  return {{"tau_s", tau_s, "s"}, {"starts_under_way", under_way ? 1.0 : 0.0, "1"}};
}

double mean_of(const std::vector<double>& channel) { return channel.empty() ? 0.0 : as_vector(channel).mean(); }

Eigen::MatrixXd time_of_day(const RegressorInputs& in) {
  constexpr double kDayLength_s = 86400.0;
  const auto rows = static_cast<Eigen::Index>(in.observations.rows.size());
  if (in.history.utc_s().empty()) return Eigen::MatrixXd(rows, 0);
  const Eigen::ArrayXd angle = as_vector(in.history.utc_s()).array() * (2.0 * std::numbers::pi / kDayLength_s);
  Eigen::MatrixXd day(rows, 2);
  day.col(0) = angle.sin();
  day.col(1) = angle.cos();
  return day;
}

Eigen::VectorXd rate_kpmin(const TemperatureHistory& history) { return kMinute_s * as_vector(history.rate()); }

OnRamps channel_on_ramps(const std::vector<double>& channel, std::string_view per) {
  OnRamps made{.per = per};
  if (channel.empty()) return made;
  Eigen::VectorXd column = as_vector(channel);
  column.array() -= column.mean();
  if (column.squaredNorm() > 0.0) made.candidates.push_back(for_all("", {}, column));
  return made;
}

std::optional<std::string> one_attitude_only(const RegressorInputs& in) {
  return in.observations.has_positions() ? std::nullopt : std::optional<std::string>("one attitude only");
}

std::optional<std::string> unmoved_channel(const std::vector<double>& channel, double least, std::string_view name) {
  if (channel.empty()) return fmt::format("the {} was not logged", name);
  const Eigen::VectorXd values = as_vector(channel);
  if (values.maxCoeff() - values.minCoeff() < least) return fmt::format("the {} never changed", name);
  return std::nullopt;
}

std::string si_unit(Sensor sensor) { return is_gyro(sensor) ? "rad/s" : "m/s2"; }

std::string axis_name(std::size_t axis) {
  constexpr std::array<std::string_view, 3> kNames = {"x", "y", "z"};
  return std::string(kNames.at(axis % kNames.size()));
}

Magnitude linear_magnitude(Sensor sensor, const Eigen::VectorXd& parameters, double factor, std::string_view per) {
  return {parameters(0) * factor * printed_per_si(sensor), std::string(printed_unit(sensor)) + std::string(per)};
}

Meaning temperature_shaped(const Observations& observations, const Candidate& candidate, Sensor sensor,
                           std::string_view name, std::string_view per) {
  const std::string unit = si_unit(sensor) + std::string(per);
  Meaning meaning{{{std::string(name), unit}}, {}};
  if (candidate.columns[index_of(sensor)].cols() < 2) return meaning;
  meaning.estimated.push_back({std::string(name) + "_per_c", unit + "/K", 1.0 / half_range_c(observations)});
  meaning.given.push_back({"reference_c", middle_c(observations), "degC"});
  return meaning;
}

}  // namespace soak::calib::gap
