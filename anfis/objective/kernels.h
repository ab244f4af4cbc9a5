// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>

// The loops over rows in which training spends its time. All columns have the same number of rows, a multiple of
// kLanes (filled up with rows that weigh nothing). Sums run in kLanes interleaved parts that are added in a fixed
// order: the same bits on every instruction set.
namespace soak::anfis::training {

inline constexpr std::size_t kLanes = 8;

/// distance = ln((u - centre)/width)^2, degree = bell, row by row.
void bell_column(std::size_t rows, const double* u, double width, double slope, double centre, double* distance,
                 double* degree);

/// distance = ((u - centre)/width)^2, degree = Gaussian, row by row.
void gaussian_column(std::size_t rows, const double* u, double width, double centre, double* distance, double* degree);

/// sum over rows of pull * d ln mu / d (width, slope, centre) of a bell.
[[nodiscard]] std::array<double, 3> bell_gradient(std::size_t rows, const double* u, const double* distance,
                                                  const double* degree, const double* pull, double width, double slope,
                                                  double centre);

/// sum over rows of pull * d ln mu / d (width, centre) of a Gaussian.
[[nodiscard]] std::array<double, 2> gaussian_gradient(std::size_t rows, const double* u, const double* distance,
                                                      const double* pull, double width, double centre);

/// values = offset + gain u
void line(std::size_t rows, const double* u, double gain, double offset, double* values);

/// output += wbar consequent [AH05 eq. 5.10]
void add_rule_output(std::size_t rows, const double* wbar, const double* consequent, double* output);

/// pull, the consequent f_i of a rule before, becomes df/d ln w_i = wbar_i (f_i - f) [AH05 eq. 5.18].
void pull_of_rule(std::size_t rows, const double* wbar, const double* output, double* pull);

/// a . b
[[nodiscard]] double dot(std::size_t rows, const double* a, const double* b);

/// The triangular factor R of a matrix of `columns` columns of `rows` rows, stored one after the other in `a`, by
/// modified Gram-Schmidt: as accurate as Householder's, and the last column may be a right-hand side [Bjorck 1967].
/// `a` is overwritten with the orthonormal columns. R is written column by column, columns x columns, its lower part
/// zero.
void triangular_factor(std::size_t rows, std::size_t columns, double* a, double* r);

}  // namespace soak::anfis::training
