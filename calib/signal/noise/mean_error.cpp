// SPDX-License-Identifier: Apache-2.0
#include "calib/signal/noise/mean_error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "base/instruction_set.h"
#include "calib/signal/noise/detail/noise_models.h"

namespace soak::calib::signal {
namespace {

constexpr std::size_t kMaxGroups = 512;

/// Sums of values less an origin, of their squares, and of their products with the index less its middle.
struct Sums {
  double first = 0.0;
  double second = 0.0;
  double moment = 0.0;
};

/// The three sums of lane_sum() in one pass. The index is counted in floating point, which is exact and needs no
/// conversion.
SOAK_CLONES
void sums_above(const double* values, std::size_t n, double origin, double middle, Sums& sums) {
  std::array<double, kSumLanes> first{};
  std::array<double, kSumLanes> second{};
  std::array<double, kSumLanes> moment{};
  std::array<double, kSumLanes> index{};
  for (std::size_t lane = 0; lane < kSumLanes; ++lane) index[lane] = static_cast<double>(lane);
  std::size_t i = 0;
  for (; i + kSumLanes <= n; i += kSumLanes) {
    for (std::size_t lane = 0; lane < kSumLanes; ++lane) {
      const double d = values[i + lane] - origin;
      first[lane] += d;
      second[lane] += d * d;
      moment[lane] += d * (index[lane] - middle);
      index[lane] += static_cast<double>(kSumLanes);
    }
  }
  for (; i < n; ++i) {
    const double d = values[i] - origin;
    first[0] += d;
    second[0] += d * d;
    moment[0] += d * (static_cast<double>(i) - middle);
  }
  for (std::size_t lane = 0; lane < kSumLanes; ++lane) {
    sums.first += first[lane];
    sums.second += second[lane];
    sums.moment += moment[lane];
  }
}

/// Means of consecutive groups of one size, less the first sample; a rest shorter than a group is only in `total`.
struct Groups {
  std::vector<double> means;
  Sums total;  ///< of all single samples
};

Groups group(std::span<const double> samples) {
  const std::size_t size = (samples.size() + kMaxGroups - 1) / kMaxGroups;
  const double middle = 0.5 * (static_cast<double>(samples.size()) - 1.0);
  Groups groups;
  for (std::size_t first = 0; first < samples.size(); first += size) {
    const std::size_t count = std::min(size, samples.size() - first);
    Sums sums;
    sums_above(samples.data() + first, count, samples.front(), middle - static_cast<double>(first), sums);
    groups.total.first += sums.first;
    groups.total.second += sums.second;
    groups.total.moment += sums.moment;
    if (count == size) groups.means.push_back(sums.first / static_cast<double>(size));
  }
  return groups;
}

double variance_about_mean(const Sums& sums, double n) {
  return std::max(0.0, sums.second - sums.first * sums.first / n) / (n - 1.0);
}

/// About the least-squares line, of n >= 3 samples.
double variance_about_line(const Sums& sums, double n) {
  const double along = sums.moment * sums.moment / (n * (n * n - 1.0) / 12.0);
  return std::max(0.0, sums.second - sums.first * sums.first / n - along) / (n - 2.0);
}

/// Least-squares line over the index taken off.
void remove_line(std::vector<double>& values) {
  const auto n = static_cast<double>(values.size());
  const double middle = 0.5 * (n - 1.0);
  double sum = 0.0;
  double moment = 0.0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    sum += values[i];
    moment += values[i] * (static_cast<double>(i) - middle);
  }
  // sum_i (i - middle)^2 = n (n^2 - 1)/12
  const double slope = moment / (n * (n * n - 1.0) / 12.0);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] -= sum / n + slope * (static_cast<double>(i) - middle);
}

SOAK_CLONES
double lagged_products(const double* z, std::size_t n, std::size_t lag) {
  return product_sum({z, n - lag}, {z + lag, n - lag});
}

/// Factor 1 + 2 sum_k (1 - k/n) rho_k by which correlation raises the variance of the mean over that of white noise,
/// over Geyer's pairs rho_0 + rho_1, rho_2 + rho_3, .. as long as they are positive.
double variance_inflation(const std::vector<double>& z, double squares) {
  if (z.size() < 8 || squares <= 0.0) return 1.0;
  const auto n = static_cast<double>(z.size());
  double inflation = -1.0;
  for (std::size_t lag = 0; lag + 1 < z.size() / 2; lag += 2) {
    const double even = lagged_products(z.data(), z.size(), lag) / squares;
    const double odd = lagged_products(z.data(), z.size(), lag + 1) / squares;
    if (even + odd <= 0.0) break;
    const auto k = static_cast<double>(lag);
    inflation += 2.0 * (even * (1.0 - k / n) + odd * (1.0 - (k + 1.0) / n));
  }
  return std::max(1.0, inflation);
}

/// `z`: group means less their straight line.
double error_by_correlation(const std::vector<double>& z) {
  const auto n = static_cast<double>(z.size());
  const double squares = lagged_products(z.data(), z.size(), 0);
  return std::sqrt(squares / ((n - 2.0) * n) * variance_inflation(z, squares));
}

/// Means of `count` parts whose lengths differ by at most one.
std::vector<double> part_means(std::span<const double> values, std::size_t count) {
  std::vector<double> means(count);
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t first = i * values.size() / count;
    const std::size_t last = (i + 1) * values.size() / count;
    const double sum = lane_sum(last - first, [&](std::size_t j) { return values[first + j]; });
    means[i] = sum / static_cast<double>(last - first);
  }
  return means;
}

double allan_at_length(std::span<const double> means) {
  static const std::array<NoiseModels, 4> models{NoiseModels(32), NoiseModels(64), NoiseModels(128), NoiseModels(256)};
  const auto finer =
      std::find_if(models.begin(), models.end(), [&](const NoiseModels& m) { return m.parts() > means.size(); });
  if (finer == models.begin()) return 0.0;
  const NoiseModels& finest = *std::prev(finer);
  return finest.allan_deviation(part_means(means, finest.parts()));
}

MeanError errors_of(std::span<const double> samples, Groups groups) {
  const auto n = static_cast<double>(samples.size());
  const double variance = variance_about_mean(groups.total, n);
  MeanError error;
  error.from_white = std::sqrt((samples.size() < 3 ? variance : variance_about_line(groups.total, n)) / n);
  if (groups.means.size() >= 3) {
    remove_line(groups.means);
    error.from_correlation = error_by_correlation(groups.means);
    error.from_allan = allan_at_length(groups.means);
  }
  error.standard_error = std::max({error.from_white, error.from_correlation, error.from_allan});
  if (error.standard_error > 0.0) error.effective_samples = variance / (error.standard_error * error.standard_error);
  return error;
}

/// For samples whose squares leave the range of numbers: measured in a unit of their own size.
MeanError errors_of_scaled(std::span<const double> samples) {
  double largest = 0.0;
  for (const double v : samples) largest = std::max(largest, std::abs(v));
  if (largest <= 0.0) return {};
  const int exponent = std::ilogb(largest);
  std::vector<double> scaled(samples.begin(), samples.end());
  for (double& v : scaled) v = std::ldexp(v, -exponent);
  MeanError error = errors_of(scaled, group(scaled));
  for (double* e : {&error.standard_error, &error.from_white, &error.from_correlation, &error.from_allan}) {
    *e = std::ldexp(*e, exponent);
  }
  return error;
}

}  // namespace

MeanError standard_error_of_mean(std::span<const double> samples) {
  constexpr double kSmallestSquare = 1e-250;
  if (samples.size() < 2) return {};
  Groups groups = group(samples);
  const bool measurable = std::isfinite(groups.total.second) && groups.total.second > kSmallestSquare;
  return measurable ? errors_of(samples, std::move(groups)) : errors_of_scaled(samples);
}

}  // namespace soak::calib::signal
