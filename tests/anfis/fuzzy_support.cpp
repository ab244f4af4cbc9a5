// SPDX-License-Identifier: Apache-2.0
#include "fuzzy_support.h"

#include <cmath>
#include <utility>

#include "base/random.h"

namespace soak::anfis::test {

double eliminate(Square a, std::vector<double>& b) {
  const std::size_t n = a.size();
  double determinant = 1.0;
  for (std::size_t c = 0; c < n; ++c) {
    std::size_t pivot = c;
    for (std::size_t r = c + 1; r < n; ++r) pivot = std::abs(a[r][c]) > std::abs(a[pivot][c]) ? r : pivot;
    if (pivot != c) determinant = -determinant;
    std::swap(a[c], a[pivot]);
    std::swap(b[c], b[pivot]);
    determinant *= a[c][c];
    for (std::size_t r = 0; r < n; ++r) {
      if (r == c || a[c][c] == 0.0) continue;
      const double factor = a[r][c] / a[c][c];
      for (std::size_t k = c; k < n; ++k) a[r][k] -= factor * a[c][k];
      b[r] -= factor * b[c];
    }
  }
  for (std::size_t c = 0; c < n; ++c) b[c] /= a[c][c];
  return determinant;
}

double determinant_of(const Square& a) {
  std::vector<double> unused(a.size(), 0.0);
  return eliminate(a, unused);
}

TrainingData one_bent_input(std::uint64_t seed, int rows) {
  TrainingData data;
  data.inputs = 4;
  base::Random random(seed);
  for (int k = 0; k < rows; ++k) {
    for (int j = 0; j < 4; ++j) data.x.push_back(random.uniform(-1.0, 1.0));
    const auto x = data.row(data.rows() - 1);
    data.y.push_back(std::sin(3.0 * x[0]) + 0.8 * x[1] + 0.05 * random.gaussian());
  }
  return data;
}

FuzzyOlsOptions quick_options(std::vector<int> clusters) {
  FuzzyOlsOptions options;
  options.clusters = std::move(clusters);
  options.clustering.starts = 2;
  options.clustering.iterations = 40;
  return options;
}

}  // namespace soak::anfis::test
