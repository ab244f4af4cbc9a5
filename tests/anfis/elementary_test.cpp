// SPDX-License-Identifier: Apache-2.0
#include "anfis/model/detail/inference.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "base/random.h"

namespace soak::anfis::inference {
namespace {

double exponential_error(double x) {
  const long double expected = std::exp(static_cast<long double>(x));
  return static_cast<double>(std::abs(exponential(x) - expected) / expected);
}

TEST(Elementary, ExponentialKeepsItsRelativeErrorOverItsRange) {
  base::Random random(1);
  double worst = 0.0;
  for (int i = 0; i < 1'000'000; ++i) worst = std::max(worst, exponential_error(random.uniform(-708.0, 709.0)));
  for (int i = 0; i < 200'000; ++i) worst = std::max(worst, exponential_error(random.uniform(-1.0, 1.0)));
  EXPECT_LT(worst, 4e-16);
  EXPECT_GT(worst, 1e-17);  // the comparison sees rounding errors
}

TEST(Elementary, ExponentialKeepsItsErrorWhereItsReductionChanges) {
  for (int n = -1021; n <= 1022; ++n) {
    // The nearest integer of x / ln 2 changes at odd multiples of ln(2)/2, r is 0 at even ones.
    for (const double x : {n * 0.69314718055994531, (n + 0.5) * 0.69314718055994531}) {
      if (x < -708.0 || x > 709.0) continue;
      for (const double at : {std::nextafter(x, -1e9), x, std::nextafter(x, 1e9)}) {
        EXPECT_LT(exponential_error(at), 4e-16) << at;
      }
    }
  }
}

TEST(Elementary, ExponentialOfZeroIsOneAndOfTinyNumbersNearIt) {
  EXPECT_EQ(exponential(0.0), 1.0);
  EXPECT_EQ(exponential(-0.0), 1.0);
  EXPECT_EQ(exponential(5e-324), 1.0);
  EXPECT_EQ(exponential(1e-300), 1.0);
  EXPECT_LT(exponential_error(1e-8), 4e-16);
}

TEST(Elementary, ExponentialIsLimitedToNormalNumbers) {
  EXPECT_EQ(exponential(-1e308), exponential(-708.0));
  EXPECT_EQ(exponential(1e308), exponential(709.0));
  EXPECT_EQ(exponential(-HUGE_VAL), exponential(-708.0));
  EXPECT_EQ(exponential(HUGE_VAL), exponential(709.0));
  EXPECT_GE(exponential(-708.0), std::numeric_limits<double>::min());
  EXPECT_TRUE(std::isfinite(exponential(709.0)));
}

double logarithm_excess(double x) {
  const long double expected = std::log(static_cast<long double>(x));
  return static_cast<double>(std::abs(logarithm(x) - expected) / (1 + std::abs(expected)));
}

TEST(Elementary, LogarithmKeepsItsAbsoluteErrorOverItsRange) {
  base::Random random(2);
  double worst = 0.0;
  for (int i = 0; i < 1'000'000; ++i) {
    const double x = std::exp2(random.uniform(-1021.0, 1023.0));
    worst = std::max(worst, logarithm_excess(x));
  }
  for (int i = 0; i < 200'000; ++i) worst = std::max(worst, logarithm_excess(random.uniform(0.4, 3.0)));
  EXPECT_LT(worst, 2e-16);
  EXPECT_GT(worst, 1e-17);
}

TEST(Elementary, LogarithmKeepsItsErrorWhereItsReductionChanges) {
  for (int n = -1021; n <= 1022; ++n) {
    for (const double m : {std::sqrt(0.5), 1.0, std::sqrt(2.0)}) {
      const double x = std::ldexp(m, n);
      for (const double at : {std::nextafter(x, 0.0), x, std::nextafter(x, HUGE_VAL)}) {
        if (at < 2.3e-308 || at > 1.7e308) continue;
        EXPECT_LT(logarithm_excess(at), 2e-16) << at;
      }
    }
  }
}

TEST(Elementary, LogarithmOfOneIsZero) { EXPECT_EQ(logarithm(1.0), 0.0); }

// Near 1 the relative error stays small too: ln(1 + e) is no difference of large numbers.
TEST(Elementary, LogarithmNearOneIsRelativelyGood) {
  for (const double e : {1e-15, 1e-9, 1e-3, -1e-15, -1e-9, -1e-3}) {
    const double x = 1.0 + e;
    const auto expected = static_cast<double>(std::log(static_cast<long double>(x)));
    EXPECT_NEAR(logarithm(x) / expected, 1.0, 1e-15) << e;
  }
}

TEST(Elementary, LogarithmIsLimitedToItsRange) {
  EXPECT_EQ(logarithm(0.0), logarithm(2.3e-308));
  EXPECT_EQ(logarithm(-3.0), logarithm(2.3e-308));
  EXPECT_EQ(logarithm(5e-324), logarithm(2.3e-308));
  EXPECT_EQ(logarithm(HUGE_VAL), logarithm(1.7e308));
}

}  // namespace
}  // namespace soak::anfis::inference
