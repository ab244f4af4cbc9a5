// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "base/statistics.h"
#include "calib/gate/checks.h"

namespace soak::calib::gate {
namespace {

constexpr double kSigmaPerMad = 1.4826;  ///< of a Gaussian
constexpr double kKnock_s = 0.05;
/// A knock that shifts a mean by more standard errors of its noise than this spoils the segment.
constexpr double kTolerableShift = 3.0;

/// One sensor's distances from the medians of its stretches, and their spread.
struct Residuals {
  Sensor sensor = Sensor::gyro_x;
  std::vector<double> value;  ///< one per row; NaN = no sample
  double sigma = 0.0;
};

std::optional<Residuals> residuals_of(const View& view, Sensor sensor, const std::vector<Stretch>& all) {
  const std::span<const double> x = view.values(sensor);
  if (x.empty()) return std::nullopt;
  Residuals residuals{sensor, {x.begin(), x.end()}, 0.0};
  for (const Stretch& stretch : all) {
    const double middle = base::median(present(x.subspan(stretch.first, stretch.last - stretch.first)));
    for (std::size_t i = stretch.first; i < stretch.last; ++i) residuals.value[i] -= middle;
  }
  std::vector<double> sizes = present(residuals.value);
  for (double& size : sizes) size = std::abs(size);
  const SensorFacts& facts = view.facts_of(sensor);
  residuals.sigma = std::max({kSigmaPerMad * base::median(sizes), facts.noise, facts.step});
  if (!(residuals.sigma > 0.0)) return std::nullopt;
  return residuals;
}

/// Whether a row's sample lies outside the noise.
bool hit(const Residuals& residuals, std::size_t row, double sigmas) {
  return std::abs(residuals.value[row]) > sigmas * residuals.sigma;
}

/// Knocks of a segment: bursts of hits in several sensors.
struct Knocks {
  int count = 0;
  double first_s = 0.0;
  double worst_sigmas = 0.0;
  std::vector<std::size_t> rows;
};

/// Rows from `first` on whose hits follow each other within kKnock_s or from row to row.
std::vector<std::size_t> burst_from(const View& view, const std::vector<std::size_t>& hits, std::size_t first) {
  const double near_s =
      std::max(kKnock_s, 1.5 * (view.t_s().back() - view.t_s().front()) / static_cast<double>(view.rows()));
  std::vector<std::size_t> burst = {hits[first]};
  for (std::size_t i = first + 1; i < hits.size() && view.t_s()[hits[i]] - view.t_s()[burst.back()] <= near_s; ++i) {
    burst.push_back(hits[i]);
  }
  return burst;
}

int sensors_hit(const std::vector<Residuals>& all, const std::vector<std::size_t>& burst, double sigmas) {
  return static_cast<int>(std::count_if(all.begin(), all.end(), [&](const Residuals& residuals) {
    return std::any_of(burst.begin(), burst.end(), [&](std::size_t row) { return hit(residuals, row, sigmas); });
  }));
}

Knocks find_knocks(const View& view, const std::vector<Residuals>& all) {
  const double sigmas = view.limits.knock_sigmas;
  std::vector<std::size_t> hits;
  for (std::size_t row = 0; row < view.rows(); ++row) {
    if (std::any_of(all.begin(), all.end(), [&](const Residuals& r) { return hit(r, row, sigmas); })) {
      hits.push_back(row);
    }
  }
  Knocks knocks;
  for (std::size_t first = 0; first < hits.size();) {
    const std::vector<std::size_t> burst = burst_from(view, hits, first);
    first += burst.size();
    if (sensors_hit(all, burst, sigmas) < view.limits.knock_sensors) continue;
    if (knocks.count++ == 0) knocks.first_s = view.t_s()[burst.front()];
    knocks.rows.insert(knocks.rows.end(), burst.begin(), burst.end());
  }
  return knocks;
}

/// Largest shift of a sensor's mean by the rows of the knocks, in standard errors of its white noise: Σ r / (σ √n).
double shift_of(const std::vector<Residuals>& all, const std::vector<std::size_t>& rows) {
  double largest = 0.0;
  for (const Residuals& residuals : all) {
    double sum = 0.0;
    for (const std::size_t row : rows) sum += std::isnan(residuals.value[row]) ? 0.0 : residuals.value[row];
    const auto samples = static_cast<double>(present(residuals.value).size());
    largest = std::max(largest, std::abs(sum) / (residuals.sigma * std::sqrt(samples)));
  }
  return largest;
}

}  // namespace

void knocked(const View& view, std::vector<Finding>& findings) {
  const std::vector<Stretch> cut = stretches(view.t_s());
  if (cut.empty() || has(findings, "moved")) return;
  std::vector<Residuals> all;
  for (const Sensor sensor : kSensors) {
    if (auto residuals = residuals_of(view, sensor, cut)) all.push_back(*std::move(residuals));
  }
  const Knocks knocks = find_knocks(view, all);
  if (knocks.count == 0) return;
  const double shift = shift_of(all, knocks.rows);
  findings.push_back({"knocked", shift > kTolerableShift ? Severity::reject : Severity::warn, std::nullopt,
                      fmt::format("{} burst{} beyond {:.0f} sigma in several sensors at once, the first at {:.2f} s, "
                                  "shift a mean by {:.1f} standard errors of its noise (up to {:.0f} are tolerable)",
                                  knocks.count, knocks.count == 1 ? "" : "s", view.limits.knock_sigmas, knocks.first_s,
                                  shift, kTolerableShift)});
}

}  // namespace soak::calib::gate
