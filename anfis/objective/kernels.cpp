// SPDX-License-Identifier: Apache-2.0
#include "anfis/objective/kernels.h"

#include <cmath>

#include "anfis/model/detail/inference.h"
#include "base/instruction_set.h"

namespace soak::anfis::training {
namespace {

SOAK_INLINE double sum_of(const double (&lanes)[kLanes]) {
  return ((lanes[0] + lanes[4]) + (lanes[2] + lanes[6])) + ((lanes[1] + lanes[5]) + (lanes[3] + lanes[7]));
}

SOAK_INLINE double lane_dot(std::size_t rows, const double* __restrict a, const double* __restrict b) {
  double sum[kLanes] = {};
  for (std::size_t i = 0; i < rows; i += kLanes) {
    for (std::size_t k = 0; k < kLanes; ++k) sum[k] += a[i + k] * b[i + k];
  }
  return sum_of(sum);
}

/// y <- y - factor x
SOAK_INLINE void subtract(std::size_t rows, double factor, const double* __restrict x, double* __restrict y) {
  for (std::size_t i = 0; i < rows; ++i) y[i] -= factor * x[i];
}

SOAK_INLINE void scale(std::size_t rows, double factor, double* values) {
  for (std::size_t i = 0; i < rows; ++i) values[i] *= factor;
}

}  // namespace

SOAK_CLONES void bell_column(std::size_t rows, const double* __restrict u, double width, double slope, double centre,
                             double* __restrict distance, double* __restrict degree) {
  for (std::size_t i = 0; i < rows; ++i) {
    distance[i] = inference::bell_distance(u[i], width, centre);
    degree[i] = inference::bell_degree(distance[i], slope);
  }
}

SOAK_CLONES void gaussian_column(std::size_t rows, const double* __restrict u, double width, double centre,
                                 double* __restrict distance, double* __restrict degree) {
  for (std::size_t i = 0; i < rows; ++i) {
    distance[i] = inference::gaussian_distance(u[i], width, centre);
    degree[i] = inference::gaussian_degree(distance[i]);
  }
}

SOAK_CLONES std::array<double, 3> bell_gradient(std::size_t rows, const double* __restrict u,
                                                const double* __restrict distance, const double* __restrict degree,
                                                const double* __restrict pull, double width, double slope,
                                                double centre) {
  double by_width[kLanes] = {};
  double by_slope[kLanes] = {};
  double by_centre[kLanes] = {};
  for (std::size_t i = 0; i < rows; i += kLanes) {
    for (std::size_t k = 0; k < kLanes; ++k) {
      const auto d = inference::bell_log_derivatives(u[i + k], distance[i + k], degree[i + k], width, slope, centre);
      by_width[k] += pull[i + k] * d[0];
      by_slope[k] += pull[i + k] * d[1];
      by_centre[k] += pull[i + k] * d[2];
    }
  }
  return {sum_of(by_width), sum_of(by_slope), sum_of(by_centre)};
}

SOAK_CLONES std::array<double, 2> gaussian_gradient(std::size_t rows, const double* __restrict u,
                                                    const double* __restrict distance, const double* __restrict pull,
                                                    double width, double centre) {
  double by_width[kLanes] = {};
  double by_centre[kLanes] = {};
  for (std::size_t i = 0; i < rows; i += kLanes) {
    for (std::size_t k = 0; k < kLanes; ++k) {
      const auto d = inference::gaussian_log_derivatives(u[i + k], distance[i + k], width, centre);
      by_width[k] += pull[i + k] * d[0];
      by_centre[k] += pull[i + k] * d[1];
    }
  }
  return {sum_of(by_width), sum_of(by_centre)};
}

SOAK_CLONES double dot(std::size_t rows, const double* a, const double* b) { return lane_dot(rows, a, b); }

SOAK_CLONES void triangular_factor(std::size_t rows, std::size_t columns, double* a, double* r) {
  for (std::size_t k = 0; k < columns; ++k) {
    double* q = a + k * rows;
    for (std::size_t j = 0; j < k; ++j) r[k + j * columns] = 0.0;
    const double norm = std::sqrt(lane_dot(rows, q, q));
    r[k + k * columns] = norm;
    scale(rows, norm > 0.0 ? 1.0 / norm : 0.0, q);
    for (std::size_t j = k + 1; j < columns; ++j) {
      const double along = lane_dot(rows, q, a + j * rows);
      r[k + j * columns] = along;
      subtract(rows, along, q, a + j * rows);
    }
  }
}

SOAK_CLONES void add_rule_output(std::size_t rows, const double* __restrict wbar, const double* __restrict consequent,
                                 double* __restrict output) {
  for (std::size_t i = 0; i < rows; ++i) output[i] += wbar[i] * consequent[i];
}

SOAK_CLONES void line(std::size_t rows, const double* __restrict u, double gain, double offset,
                      double* __restrict values) {
  for (std::size_t i = 0; i < rows; ++i) values[i] = offset + gain * u[i];
}

SOAK_CLONES void pull_of_rule(std::size_t rows, const double* __restrict wbar, const double* __restrict output,
                              double* __restrict pull) {
  for (std::size_t i = 0; i < rows; ++i) pull[i] = wbar[i] * (pull[i] - output[i]);
}

}  // namespace soak::anfis::training
