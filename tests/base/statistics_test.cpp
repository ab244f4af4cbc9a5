// SPDX-License-Identifier: Apache-2.0
#include "base/statistics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

namespace soak::base {
namespace {

TEST(StudentT, MatchesPublishedQuantiles) {
  // NIST/SEMATECH e-Handbook, table 1.3.6.7.2, two-sided 95 %: printed to three digits.
  EXPECT_NEAR(student_t_two_sided(0.95, 1), 12.706, 5e-4);
  EXPECT_NEAR(student_t_two_sided(0.95, 3), 3.182, 5e-4);
  EXPECT_NEAR(student_t_two_sided(0.95, 19), 2.093, 5e-4);
  EXPECT_NEAR(student_t_two_sided(0.95, 100), 1.984, 5e-4);
  EXPECT_NEAR(student_t_two_sided(0.99, 10), 3.169, 5e-4);
  EXPECT_NEAR(student_t_two_sided(0.95, 1e7), 1.959964, 1e-5);
}

TEST(StudentT, IsThatOfTheClosedFormsOfOneAndTwoDegreesOfFreedom) {
  for (const double p : {0.05, 0.5, 0.683, 0.95, 0.999, 0.999999}) {
    const double one = std::tan(0.5 * std::numbers::pi * p);
    const double two = p * std::sqrt(2.0 / ((1.0 - p) * (1.0 + p)));
    EXPECT_NEAR(student_t_two_sided(p, 1), one, 1e-9 * one) << p;
    EXPECT_NEAR(student_t_two_sided(p, 2), two, 1e-9 * two) << p;
  }
}

TEST(ChiSquared, MatchesPublishedCriticalValues) {
  // NIST/SEMATECH e-Handbook, table 1.3.6.7.4.
  EXPECT_NEAR(chi_squared_upper_tail(3.841, 1), 0.05, 1e-4);
  EXPECT_NEAR(chi_squared_upper_tail(18.307, 10), 0.05, 1e-4);
  EXPECT_NEAR(chi_squared_upper_tail(23.209, 10), 0.01, 1e-5);
  EXPECT_NEAR(chi_squared_upper_tail(135.807, 100), 0.01, 1e-4);
  EXPECT_DOUBLE_EQ(chi_squared_upper_tail(0.0, 5), 1.0);
}

// SciPy 1.10, stats.f.sf.
TEST(FDistribution, TailsKeepTheirRelativeAccuracy) {
  EXPECT_NEAR(f_upper_tail(3.708, 3, 10), 0.050008781604542425, 1e-12);
  EXPECT_NEAR(f_upper_tail(0.5, 7, 3.5), 0.7991544250016287, 1e-12);
  EXPECT_NEAR(f_upper_tail(40.0, 2, 15) / 9.722039992477878e-07, 1.0, 1e-10);
  EXPECT_NEAR(f_upper_tail(150.5, 1, 17) / 7.173200360616076e-10, 1.0, 1e-10);
  EXPECT_NEAR(f_upper_tail(1200.0, 6, 17) / 2.2847263995338358e-21, 1.0, 1e-10);
  EXPECT_EQ(f_upper_tail(0.0, 2, 5), 1.0);
}

TEST(ChiSquared, QuantilesMatchPublishedCriticalValues) {
  // NIST/SEMATECH e-Handbook, table 1.3.6.7.4: upper 5 % and lower 5 % points, printed to three digits.
  EXPECT_NEAR(chi_squared_quantile(0.95, 10), 18.307, 5e-4);
  EXPECT_NEAR(chi_squared_quantile(0.05, 10), 3.940, 5e-4);
  EXPECT_NEAR(chi_squared_quantile(0.99, 100), 135.807, 5e-4);
  EXPECT_NEAR(chi_squared_quantile(0.05, 1), 0.004, 5e-4);
}

TEST(ChiSquared, QuantileUndoesTheTail) {
  for (const double dof : {0.7, 1.0, 3.5, 40.0, 1e5}) {
    for (const double p : {0.001, 0.025, 0.5, 0.975}) {
      EXPECT_NEAR(1.0 - chi_squared_upper_tail(chi_squared_quantile(p, dof), dof), p, 1e-9) << dof << " " << p;
    }
  }
}

TEST(Median, TakesTheMiddleAndTheMeanOfTwoMiddles) {
  EXPECT_EQ(median(std::vector<double>{3, 1, 2}), 2.0);
  EXPECT_EQ(median(std::vector<double>{4, 1, 2, 3}), 2.5);
  EXPECT_TRUE(std::isnan(median(std::vector<double>{})));
}

}  // namespace
}  // namespace soak::base
