// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>

// The functions of anfis/objective/kernels.h compiled once, for any processor: see kernels_baseline.cpp.
namespace soak::anfis::training::baseline {

void bell_column(std::size_t rows, const double* u, double width, double slope, double centre, double* distance,
                 double* degree);
void gaussian_column(std::size_t rows, const double* u, double width, double centre, double* distance, double* degree);
std::array<double, 3> bell_gradient(std::size_t rows, const double* u, const double* distance, const double* degree,
                                    const double* pull, double width, double slope, double centre);
std::array<double, 2> gaussian_gradient(std::size_t rows, const double* u, const double* distance, const double* pull,
                                        double width, double centre);
double dot(std::size_t rows, const double* a, const double* b);
void triangular_factor(std::size_t rows, std::size_t columns, double* a, double* r);

}  // namespace soak::anfis::training::baseline
