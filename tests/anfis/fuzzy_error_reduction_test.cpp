// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>

#include "anfis/select/detail/compaction.h"
#include "anfis/select/detail/gath_geva.h"
#include "base/random.h"
#include "fuzzy_support.h"

namespace soak::anfis {
namespace {

using test::eliminate;
using test::Square;

/// Weighted sum of squares that is left after least squares on some inputs and a constant.
double squares_left(const fuzzy::ScaledRows& rows, const Eigen::VectorXd& beta, const std::vector<int>& inputs) {
  const std::size_t n = inputs.size() + 1;
  const auto column = [&](Eigen::Index k, std::size_t c) { return c == 0 ? 1.0 : rows.x(k, inputs[c - 1]); };
  Square normal(n, std::vector<double>(n, 0.0));
  std::vector<double> theta(n, 0.0);
  for (Eigen::Index k = 0; k < beta.size(); ++k) {
    for (std::size_t r = 0; r < n; ++r) {
      for (std::size_t c = 0; c < n; ++c) normal[r][c] += beta(k) * column(k, r) * column(k, c);
      theta[r] += beta(k) * column(k, r) * rows.y(k);
    }
  }
  eliminate(normal, theta);
  double squares = 0.0;
  for (Eigen::Index k = 0; k < beta.size(); ++k) {
    double r = rows.y(k);
    for (std::size_t c = 0; c < n; ++c) r -= theta[c] * column(k, c);
    squares += beta(k) * r * r;
  }
  return squares;
}

struct Made {
  fuzzy::ScaledRows rows;
  Eigen::VectorXd mu;
};

/// Four correlated inputs with a linear output and noise, random weights and memberships.
Made linear_problem(std::uint64_t seed) {
  base::Random random(seed);
  Made made{{Eigen::MatrixXd(80, 4), Eigen::VectorXd(80), Eigen::VectorXd(80)}, Eigen::VectorXd(80)};
  for (Eigen::Index k = 0; k < 80; ++k) {
    const double common = random.gaussian();
    for (Eigen::Index j = 0; j < 4; ++j) made.rows.x(k, j) = 0.3 * common + 0.5 * random.gaussian() + 0.2;
    made.rows.y(k) =
        0.5 + made.rows.x(k, 2) - 0.4 * made.rows.x(k, 0) + 0.1 * made.rows.x(k, 3) + 0.1 * random.gaussian();
    made.rows.weight(k) = random.uniform(0.5, 1.5);
    made.mu(k) = random.uniform();
  }
  return made;
}

TEST(ErrorReduction, RanksAsForwardSelectionByLeastSquaresDoes) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const Made made = linear_problem(seed);
    const fuzzy::ErrorReduction reduction = fuzzy::error_reduction(made.rows, made.mu);
    const Eigen::VectorXd beta = made.mu.cwiseProduct(made.rows.weight);
    const double total = made.rows.y.cwiseAbs2().dot(beta);
    std::vector<int> taken;
    double left = squares_left(made.rows, beta, taken);
    EXPECT_NEAR(reduction.offset, (total - left) / total, 1e-12);
    for (std::size_t step = 0; step < 4; ++step) {
      int best = -1;
      double best_left = std::numeric_limits<double>::infinity();
      for (int j = 0; j < 4; ++j) {
        if (std::ranges::find(taken, j) != taken.end()) continue;
        std::vector<int> with = taken;
        with.push_back(j);
        const double with_left = squares_left(made.rows, beta, with);
        if (with_left < best_left) {
          best_left = with_left;
          best = j;
        }
      }
      EXPECT_EQ(reduction.order[step], best);
      // What a term explains is by how much the squares fall [AH05 eq. 5.36].
      EXPECT_NEAR(reduction.ratios[step], (left - best_left) / total, 1e-12);
      left = best_left;
      taken.push_back(best);
    }
  }
}

TEST(ErrorReduction, ARepeatedInputExplainsNothing) {
  Made made = linear_problem(1);
  made.rows.x.col(1) = 2.0 * made.rows.x.col(2).array() - 0.7;
  const fuzzy::ErrorReduction reduction = fuzzy::error_reduction(made.rows, made.mu);
  const auto place = [&](int input) {
    return static_cast<std::size_t>(std::ranges::find(reduction.order, input) - reduction.order.begin());
  };
  EXPECT_EQ(reduction.ratios[std::max(place(1), place(2))], 0.0);
  EXPECT_GT(reduction.ratios[std::min(place(1), place(2))], 0.1);
}

TEST(ErrorReduction, AnOutputOfZeroIsExplainedByNothing) {
  Made made = linear_problem(1);
  made.rows.y.setZero();
  const fuzzy::ErrorReduction reduction = fuzzy::error_reduction(made.rows, made.mu);
  EXPECT_EQ(reduction.offset, 0.0);
  EXPECT_EQ(reduction.ratios, std::vector<double>(4, 0.0));
  EXPECT_EQ(fuzzy::terms_kept(reduction, 0.01), 0U);
}

TEST(ErrorReduction, DropsTheTailThatTogetherStaysBelowTheThreshold) {
  const fuzzy::ErrorReduction reduction{0.5, {3, 0, 2, 1}, {0.3, 0.1, 0.02, 0.01}};
  // The offset leaves 0.5: shares are 0.6, 0.2, 0.04, 0.02.
  EXPECT_EQ(fuzzy::terms_kept(reduction, 0.0), 4U);
  EXPECT_EQ(fuzzy::terms_kept(reduction, 0.019), 4U);
  EXPECT_EQ(fuzzy::terms_kept(reduction, 0.021), 3U);
  EXPECT_EQ(fuzzy::terms_kept(reduction, 0.059), 3U);
  EXPECT_EQ(fuzzy::terms_kept(reduction, 0.061), 2U);
  EXPECT_EQ(fuzzy::terms_kept(reduction, 0.9), 0U);
}

}  // namespace
}  // namespace soak::anfis
