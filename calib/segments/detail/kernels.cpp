// SPDX-License-Identifier: Apache-2.0
#include "calib/segments/detail/kernels.h"

#include <array>
#include <cstddef>

#include "base/instruction_set.h"

namespace soak::calib {
namespace {

constexpr std::size_t kLanes = 8;

template <class Term>
SOAK_INLINE double lane_sum(std::size_t n, const Term& term) {
  std::array<double, kLanes> partial{};
  std::size_t i = 0;
  for (; i + kLanes <= n; i += kLanes) {
    for (std::size_t lane = 0; lane < kLanes; ++lane) partial[lane] += term(i + lane);
  }
  for (std::size_t lane = 0; i < n; ++i, ++lane) partial[lane] += term(i);
  double sum = 0.0;
  for (const double p : partial) sum += p;
  return sum;
}

SOAK_CLONES
double sum_above(const double* values, std::size_t n, double origin) {
  return lane_sum(n, [&](std::size_t i) { return values[i] - origin; });
}

SOAK_CLONES
double squares_about(const double* values, std::size_t n, double centre) {
  return lane_sum(n, [&](std::size_t i) { return (values[i] - centre) * (values[i] - centre); });
}

SOAK_CLONES
double count_gaps(const double* values, std::size_t n) {
  return lane_sum(n, [&](std::size_t i) { return values[i] != values[i] ? 1.0 : 0.0; });
}

/// The divisions do not wait for each other; the additions do.
SOAK_CLONES
void add_quotients(const double* x, const double* y, std::size_t count, double n, double* sums) {
  double sum_x = sums[0];
  double sum_y = sums[1];
  std::size_t i = 0;
  for (; i + kLanes <= count; i += kLanes) {
    std::array<double, kLanes> qx;
    std::array<double, kLanes> qy;
    for (std::size_t lane = 0; lane < kLanes; ++lane) qx[lane] = x[i + lane] / n;
    for (std::size_t lane = 0; lane < kLanes; ++lane) qy[lane] = y[i + lane] / n;
    for (std::size_t lane = 0; lane < kLanes; ++lane) sum_x += qx[lane];
    for (std::size_t lane = 0; lane < kLanes; ++lane) sum_y += qy[lane];
  }
  for (; i < count; ++i) {
    sum_x += x[i] / n;
    sum_y += y[i] / n;
  }
  sums[0] = sum_x;
  sums[1] = sum_y;
}

SOAK_CLONES
void minutes_since(const double* t_s, std::size_t n, double start_s, double* minutes) {
  for (std::size_t i = 0; i < n; ++i) minutes[i] = (t_s[i] - start_s) / 60.0;
}

}  // namespace

double sum_above(std::span<const double> values, double origin) {
  return sum_above(values.data(), values.size(), origin);
}

double squares_about(std::span<const double> values, double centre) {
  return squares_about(values.data(), values.size(), centre);
}

bool has_gap(std::span<const double> values) { return count_gaps(values.data(), values.size()) > 0.0; }

void add_quotients(std::span<const double> x, std::span<const double> y, double n, double& sum_x, double& sum_y) {
  std::array<double, 2> sums = {sum_x, sum_y};
  add_quotients(x.data(), y.data(), x.size(), n, sums.data());
  sum_x = sums[0];
  sum_y = sums[1];
}

void minutes_since(std::span<const double> t_s, double start_s, std::span<double> minutes) {
  minutes_since(t_s.data(), t_s.size(), start_s, minutes.data());
}

}  // namespace soak::calib
