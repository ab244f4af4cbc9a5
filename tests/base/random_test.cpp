// SPDX-License-Identifier: Apache-2.0
#include "base/random.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

namespace soak::base {
namespace {

TEST(Hashed, DependsOnEachArgument) {
  std::set<std::uint64_t> seen;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    for (std::uint64_t stream = 0; stream < 20; ++stream) {
      for (std::uint64_t index = 0; index < 20; ++index) seen.insert(hashed(seed, stream, index));
    }
  }
  EXPECT_EQ(seen.size(), 8000U);
}

TEST(HashedGaussian, HasTheMomentsOfANormalDistribution) {
  constexpr int n = 200000;
  double m1 = 0.0;
  double m2 = 0.0;
  double m4 = 0.0;
  double lag = 0.0;
  double last = 0.0;
  for (int i = 0; i < n; ++i) {
    const double g = hashed_gaussian(1, 2, static_cast<std::uint64_t>(i));
    m1 += g / n;
    m2 += g * g / n;
    m4 += g * g * g * g / n;
    lag += g * last / n;
    last = g;
  }
  // Five standard errors of each moment.
  EXPECT_NEAR(m1, 0.0, 5.0 / std::sqrt(n));
  EXPECT_NEAR(m2, 1.0, 5.0 * std::sqrt(2.0 / n));
  EXPECT_NEAR(m4, 3.0, 5.0 * std::sqrt(96.0 / n));
  EXPECT_NEAR(lag, 0.0, 5.0 / std::sqrt(n));
}

TEST(Random, NormalsAndUniformsOfOneStreamAreIndependent) {
  constexpr int n = 100000;
  double product = 0.0;
  for (int i = 0; i < n; ++i) {
    Random first(static_cast<std::uint64_t>(i), 3);
    const double u = first.uniform();
    Random second(static_cast<std::uint64_t>(i), 3);
    product += (u - 0.5) * std::abs(second.gaussian()) / n;
  }
  EXPECT_NEAR(product, 0.0, 5.0 * std::sqrt(1.0 / 12.0 / n));
}

TEST(Random, RepeatsWithItsSeed) {
  Random a(9, 1);
  Random b(9, 1);
  for (int i = 0; i < 10; ++i) EXPECT_EQ(a.gaussian(), b.gaussian());
  EXPECT_NE(Random(9, 1).uniform(), Random(10, 1).uniform());
}

}  // namespace
}  // namespace soak::base
