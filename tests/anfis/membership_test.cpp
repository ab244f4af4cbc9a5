// SPDX-License-Identifier: Apache-2.0
#include "anfis/model/membership.h"

#include <gtest/gtest.h>

#include <cmath>

#include "anfis/model/rule_base.h"
#include "base/random.h"

namespace soak::anfis {
namespace {

// Positions and widths of the size that scaled inputs have.
Membership some_membership(Shape shape, base::Random& random) {
  const double c = random.uniform(-1.0, 1.0);
  const auto length = [&] { return random.uniform(0.05, 1.5); };
  const double left = length(), right = length(), top = random.uniform(0.0, 0.5);
  switch (shape) {
    case Shape::bell:
      return bell(left, random.uniform(0.3, 6.0), c);
    case Shape::gaussian:
      return gaussian(left, c);
    case Shape::two_sided_gaussian:
      return {shape, {left, c, right, c + top}};
    case Shape::triangle:
      return {shape, {c - left, c, c + right}};
    case Shape::trapezoid:
      return {shape, {c - left, c, c + top, c + top + right}};
  }
  return {};
}

long double flank(long double u, long double width, long double from) {
  const long double t = (u - from) / width;
  return std::exp(-t * t / 2);
}

// The formulas of parameter_names() in extended precision.
long double formula(const Membership& m, long double u) {
  const auto& p = m.parameters;
  switch (m.shape) {
    case Shape::bell:
      return 1 / (1 + std::pow(std::abs((u - p[2]) / p[0]), 2 * static_cast<long double>(p[1])));
    case Shape::gaussian:
      return flank(u, p[0], p[1]);
    case Shape::two_sided_gaussian:
      return u < p[1] ? flank(u, p[0], p[1]) : u > p[3] ? flank(u, p[2], p[3]) : 1;
    case Shape::triangle:
    case Shape::trapezoid:
      break;
  }
  const bool triangle = m.shape == Shape::triangle;
  const long double left = p[0], top_left = p[1], top_right = triangle ? p[1] : p[2], right = triangle ? p[2] : p[3];
  if (u <= left || u >= right) return 0;
  return u < top_left ? (u - left) / (top_left - left) : u > top_right ? (right - u) / (right - top_right) : 1;
}

// Visits 200 memberships of each shape with 40 points in [-1.5, 1.5] each.
template <class Visit>
void sample(Visit&& visit) {
  base::Random random(1, 9);
  for (const Shape shape : kShapes) {
    for (int i = 0; i < 200; ++i) {
      const Membership m = some_membership(shape, random);
      ASSERT_TRUE(validate(m));
      for (int k = 0; k < 40; ++k) visit(m, random.uniform(-1.5, 1.5));
    }
  }
}

// t = (u - c)/width has a rounding error of about 3e-16 (|u| + |c|)/width <= 1.5e-14 for widths from 0.05. The degree's
// derivative by t is at most b/2 <= 3 for the bell (by ln t) and 1 for the others, but near the centre ln t^2 of the
// bell is as uncertain as t relatively: t dmu/dt stays below b/2. The exponent b ln t^2 of up to 6 * 2 ln 50 = 47
// carries another 47 * 4e-16 = 2e-14, which a degree of at most 1/4 relative slope reduces.
constexpr double kDegreeTolerance = 5e-14;

TEST(Membership, DegreeIsThatOfTheFormula) {
  sample([](const Membership& m, double u) {
    EXPECT_NEAR(degree(m, u), static_cast<double>(formula(m, u)), kDegreeTolerance) << name(m.shape) << ' ' << u;
  });
}

TEST(Membership, LogarithmIsThatOfTheDegree) {
  sample([](const Membership& m, double u) {
    const long double expected = std::log(formula(m, u));
    if (!(expected > -690)) return;  // ln 1e-300
    // Relative errors of the degree: those above over a degree above 0, that is, of ln t^2 times 2 b (1 - mu).
    EXPECT_NEAR(log_degree(m, u), static_cast<double>(expected),
                1e-13 * (1.0 - static_cast<double>(expected)) + 2e-15 / degree(m, u) * (m.shape >= Shape::triangle))
        << name(m.shape) << ' ' << u;
  });
}

TEST(Membership, LogarithmGoesOnWhereTheDegreeUnderflows) {
  EXPECT_NEAR(log_degree(gaussian(0.1, 0.0), 10.0), -5000.0, 1e-9);
  EXPECT_NEAR(log_degree({Shape::two_sided_gaussian, {0.1, -1.0, 0.2, 1.0}}, 21.0), -5000.0, 1e-9);
  EXPECT_NEAR(log_degree({Shape::two_sided_gaussian, {0.1, -1.0, 0.2, 1.0}}, -11.0), -5000.0, 1e-9);
  EXPECT_NEAR(log_degree(bell(0.5, 200.0, 0.0), 500.0), -400.0 * std::log(1000.0), 1e-9);  // 1e-1200
  EXPECT_NEAR(log_degree(bell(1.0, 2.0, 0.0), 1e50), -200.0 * std::log(10.0), 1e-9);
}

TEST(Membership, LogarithmOutsideAPolygonFallsWithTheDistance) {
  for (const Membership& m :
       {Membership{Shape::triangle, {-1.0, 0.0, 3.0}}, Membership{Shape::trapezoid, {-1.0, 0.0, 1.0, 3.0}}}) {
    EXPECT_EQ(degree(m, 3.0), 0.0);
    EXPECT_NEAR(log_degree(m, 5.0), -1e6 * (1.0 + 2.0 / 4.0), 1e-6);
    EXPECT_NEAR(log_degree(m, -2.0), -1e6 * (1.0 + 1.0 / 4.0), 1e-6);
  }
}

// On its peak and top the degree is 1 whatever the parameters, and half a flank lies half way.
TEST(Membership, IsOneAtItsCentre) {
  sample([](const Membership& m, double) { EXPECT_NEAR(degree(m, centre(m)), 1.0, 1e-15) << name(m.shape); });
}

double nearest_kink(const Membership& m, double u) {
  const auto& p = m.parameters;
  double nearest = 1.0;
  if (m.shape == Shape::bell || m.shape == Shape::gaussian) return std::abs(u - centre(m));
  for (std::size_t i = 0; i < parameter_count(m.shape); ++i) {
    const bool position = m.shape != Shape::two_sided_gaussian || i % 2 == 1;
    if (position) nearest = std::min(nearest, std::abs(u - p[i]));
  }
  return nearest;
}

// Central differences with h = 1e-6 of the formula in extended precision: the truncation h^2/6 f''' of the sharpest
// bell (b = 6, width 0.05: f''' about (2b)^3/8 / width^3 = 1.7e6) is 3e-7. A bell's third derivative grows at its
// centre like t^(2b-3) for b < 3/2: points nearer than 0.02 are left out.
TEST(Membership, EveryDerivativeAgreesWithDifferences) {
  constexpr double kStep = 1e-6;
  int compared = 0;
  sample([&](const Membership& m, double u) {
    if (nearest_kink(m, u) < 0.02) return;
    const auto derivatives = degree_derivatives(m, u);
    for (std::size_t p = 0; p < 4; ++p) {
      if (p >= parameter_count(m.shape)) {
        EXPECT_EQ(derivatives[p], 0.0);
        continue;
      }
      Membership low = m, high = m;
      low.parameters[p] -= kStep;
      high.parameters[p] += kStep;
      const long double step = static_cast<long double>(high.parameters[p]) - low.parameters[p];
      const auto difference = static_cast<double>((formula(high, u) - formula(low, u)) / step);
      EXPECT_NEAR(derivatives[p], difference, 5e-7) << name(m.shape) << ' ' << parameter_names(m.shape)[p] << ' ' << u;
      ++compared;
    }
  });
  EXPECT_GT(compared, 100'000);
}

TEST(Membership, DerivativesOnAKinkAreTheMeanOfBothSides) {
  const Membership triangle{Shape::triangle, {-1.0, 0.0, 2.0}};
  const auto d = degree_derivatives(triangle, 0.0);
  EXPECT_DOUBLE_EQ(d[1], 0.5 * (-1.0 + 0.5));  // slopes 1 and -1/2
  EXPECT_EQ(degree_derivatives(triangle, 2.5), (std::array<double, 4>{}));
  EXPECT_EQ(degree_derivatives(bell(0.3, 1.5, 0.2), 0.2), (std::array<double, 4>{}));
}

TEST(Membership, AroundACentreIsOneHalfAtTheGivenDistance) {
  for (const Shape shape : kShapes) {
    for (const double half : {1e-3, 0.2, 3.0}) {
      const Membership m = membership_around(shape, 0.7, half);
      EXPECT_TRUE(validate(m));
      EXPECT_NEAR(centre(m), 0.7, 1e-15);
      // u = 0.7 +- half is rounded to 1e-16, a share of 1e-13 of the least half width; slopes up to 2/half.
      EXPECT_NEAR(degree(m, 0.7 - half), 0.5, 5e-13) << name(shape);
      EXPECT_NEAR(degree(m, 0.7 + half), 0.5, 5e-13) << name(shape);
    }
  }
}

TEST(Membership, FallsMonotonouslyFromItsCentre) {
  sample([](const Membership& m, double u) {
    const double further = u > centre(m) ? u + 0.1 : u - 0.1;
    EXPECT_LE(degree(m, further), degree(m, u) + 1e-15) << name(m.shape);
    EXPECT_LE(log_degree(m, further), log_degree(m, u) + 1e-13) << name(m.shape);
  });
}

}  // namespace
}  // namespace soak::anfis
