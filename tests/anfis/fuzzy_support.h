// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "anfis/data/training_data.h"
#include "anfis/select/fuzzy_ols.h"

namespace soak::anfis::test {

using Square = std::vector<std::vector<double>>;

/// Gauss elimination with partial pivoting: leaves the solution in b, returns the determinant.
double eliminate(Square a, std::vector<double>& b);
double determinant_of(const Square& a);

/// Four inputs: y bends along input 0, is straight along input 1, and does not depend on 2 and 3.
TrainingData one_bent_input(std::uint64_t seed, int rows = 400);

/// Options of small problems.
FuzzyOlsOptions quick_options(std::vector<int> clusters);

}  // namespace soak::anfis::test
