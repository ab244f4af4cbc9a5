// SPDX-License-Identifier: Apache-2.0
// Parameters that are refused, and those at the border of what is taken.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "anfis/model/membership.h"
#include "anfis/model/rule_base.h"

namespace soak::anfis {
namespace {

std::string where_of(const Membership& m) {
  const auto status = validate(m);
  return status ? std::string("accepted") : status.error().where;
}

TEST(Membership, RefusesParametersOutOfRangeByName) {
  EXPECT_EQ(where_of(bell(1.0, 2.0, 0.0)), "accepted");
  EXPECT_EQ(where_of(bell(0.0, 2.0, 0.0)), "width");
  EXPECT_EQ(where_of(bell(1e-51, 2.0, 0.0)), "width");  // its square would underflow
  EXPECT_EQ(where_of(bell(1.0, -2.0, 0.0)), "slope");
  EXPECT_EQ(where_of(gaussian(-1.0, 0.0)), "width");
  const auto two_sided = [](double a, double b, double c, double d) {
    return where_of({Shape::two_sided_gaussian, {a, b, c, d}});
  };
  EXPECT_EQ(two_sided(1.0, 0.0, 1.0, 0.0), "accepted");
  EXPECT_EQ(two_sided(0.0, 0.0, 1.0, 0.0), "left_width");
  EXPECT_EQ(two_sided(1.0, 0.0, 0.0, 0.0), "right_width");
  EXPECT_EQ(two_sided(1.0, 0.1, 1.0, 0.0), "left");
  EXPECT_EQ(where_of({Shape::triangle, {0.0, 1.0, 2.0}}), "accepted");
  EXPECT_EQ(where_of({Shape::triangle, {1.0, 1.0, 2.0}}), "left");
  EXPECT_EQ(where_of({Shape::triangle, {0.0, 2.0, 2.0}}), "peak");
  const auto trapezoid = [](double a, double b, double c, double d) {
    return where_of({Shape::trapezoid, {a, b, c, d}});
  };
  EXPECT_EQ(trapezoid(0.0, 1.0, 1.0, 2.0), "accepted");
  EXPECT_EQ(trapezoid(1.0, 1.0, 1.0, 2.0), "left");
  EXPECT_EQ(trapezoid(0.0, 1.5, 1.0, 2.0), "top_left");
  EXPECT_EQ(trapezoid(0.0, 1.0, 2.0, 2.0), "top_right");
}

TEST(Membership, RefusesEveryParameterThatIsNotFiniteAndThoseThatTheShapeDoesNotHave) {
  for (const Shape shape : kShapes) {
    const Membership good = membership_around(shape, 0.1, 0.5);
    for (std::size_t p = 0; p < 4; ++p) {
      for (const double value : {std::numeric_limits<double>::quiet_NaN(), HUGE_VAL, -HUGE_VAL}) {
        Membership bad = good;
        bad.parameters[p] = value;
        const auto names = parameter_names(shape);
        EXPECT_EQ(where_of(bad), p < names.size() ? names[p] : "unused parameter") << name(shape);
      }
    }
  }
}

TEST(Membership, NamesEveryParameter) {
  for (const Shape shape : kShapes) EXPECT_EQ(parameter_names(shape).size(), parameter_count(shape));
}

// Parameters that validate() takes though no training would give them.
std::vector<Membership> extreme_memberships() {
  std::vector<Membership> all;
  for (const double w : {1e-50, 1e-20, 1e-9, 1.0, 1e99}) {
    all.insert(all.end(), {bell(w, 2.0, 0.3), bell(w, 1e-9, 0.3), bell(w, 1e9, 0.3), gaussian(w, -0.4)});
    all.push_back({Shape::two_sided_gaussian, {w, -0.1, w, 0.2}});
    all.push_back({Shape::triangle, {-w, 0.0, w}});
    all.push_back({Shape::trapezoid, {-2.0 * w, -w, w, 2.0 * w}});
  }
  return all;
}

constexpr std::array<double, 10> kSizes = {0.0, 5e-324, 1e-300, 0.2, 0.3, 1.0, 1e10, 1e100, 1e160, 1e308};

TEST(Membership, DegreeIsInTheUnitIntervalForEveryFiniteInput) {
  for (const Membership& m : extreme_memberships()) {
    ASSERT_TRUE(validate(m));
    int outside = 0;
    for (const double u : kSizes) {
      for (const double mu : {degree(m, u), degree(m, -u)}) outside += mu >= 0.0 && mu <= 1.0 ? 0 : 1;
    }
    EXPECT_EQ(outside, 0) << name(m.shape) << ' ' << m.parameters[0] << ' ' << m.parameters[1];
  }
}

TEST(Membership, LogarithmIsFiniteForEveryFiniteInput) {
  for (const Membership& m : extreme_memberships()) {
    int infinite = 0;
    for (const double u : kSizes) {
      for (const double log : {log_degree(m, u), log_degree(m, -u)}) infinite += std::isfinite(log) ? 0 : 1;
    }
    EXPECT_EQ(infinite, 0) << name(m.shape) << ' ' << m.parameters[0] << ' ' << m.parameters[1];
  }
}

}  // namespace
}  // namespace soak::anfis
