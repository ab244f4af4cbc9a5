// SPDX-License-Identifier: Apache-2.0
#include "nav/filter/transition.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/random.h"
#include "base/units.h"
#include "nav/filter/navigation_filter.h"
#include "nav/inertial/mechanization.h"

namespace soak::nav {
namespace {

using base::kRadPerDeg;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Errors = Eigen::Matrix<double, 21, 1>;

constexpr double kStep_s = 0.01;

const Vector3d kRate_rps(0.05, -0.02, 0.3);
const Vector3d kForce_mps2(1.5, 0.7, 9.6);

NavState fast_and_high() {
  return {{51.0 * kRadPerDeg, 0.3, 1000.0}, {120.0, -80.0, 5.0}, quaternion_of(matrix_of({0.7, 0.1, -0.2}))};
}

/// A state with these errors: estimate less truth; φ with R̂ = (I − [φ×]) R.
NavState wrong_by(const NavState& truth, const Errors& e) {
  NavState state = truth;
  state.position = moved(truth.position, e.segment<3>(0));
  state.velocity_mps += e.segment<3>(3);
  state.body_to_level = rotation_of(-e.segment<3>(6)) * truth.body_to_level;
  return state;
}

/// The errors of `state`.
Errors errors_of(const NavState& state, const NavState& truth) {
  Errors e = Errors::Zero();
  const Radii radii = radii_at(truth.position.latitude_rad);
  e(0) = (state.position.longitude_rad - truth.position.longitude_rad) * (radii.normal_m + truth.position.height_m) *
         std::cos(truth.position.latitude_rad);
  e(1) = (state.position.latitude_rad - truth.position.latitude_rad) * (radii.meridian_m + truth.position.height_m);
  e(2) = state.position.height_m - truth.position.height_m;
  e.segment<3>(3) = state.velocity_mps - truth.velocity_mps;
  e.segment<3>(6) =
      -vector_of(quaternion_of(to_matrix(state.body_to_level) * to_matrix(truth.body_to_level).transpose()));
  return e;
}

/// After two steps, of which only the second starts with the errors: the first shows the mechanization its
/// acceleration.
NavState stepped(const Errors& before) {
  Mechanization ins(fast_and_high());
  ins.step({kStep_s, kStep_s * kRate_rps, kStep_s * kForce_mps2});
  ins.set_state(wrong_by(ins.state(), before));
  const Vector3d rate = kRate_rps.cwiseProduct(Vector3d::Ones() + before.segment<3>(18)) + before.segment<3>(12);
  const Vector3d force = kForce_mps2.cwiseProduct(Vector3d::Ones() + before.segment<3>(15)) + before.segment<3>(9);
  ins.step({kStep_s, kStep_s * rate, kStep_s * force});
  return ins.state();
}

/// Φ as the filter makes it, from what a covariance of one error becomes: column j of Φ is Φ e_j, and Φ e_j e_jᵀ Φᵀ has
/// it in its columns.
MatrixXd transition_matrix() {
  Mechanization ins(fast_and_high());
  ins.step({kStep_s, kStep_s * kRate_rps, kStep_s * kForce_mps2});
  ins.step({kStep_s, kStep_s * kRate_rps, kStep_s * kForce_mps2});
  Transition transition;
  transition.has_scales = true;
  transition.kept.fill(1.0);
  find_transition(ins.terms(), ins.state().velocity_mps, kRate_rps, kForce_mps2, kStep_s, transition);
  MatrixXd phi(21, 21);
  for (int j = 0; j < 21; ++j) {
    Covariance p;
    p.at(j, j) = 1.0;
    propagate(transition, p);
    // The diagonal of Φ is positive here, so that (Φ e_j)_j = sqrt of its square.
    for (int i = 0; i < 21; ++i) phi(i, j) = p.at(i, j) / std::sqrt(p.at(j, j));
  }
  return phi;
}

/// Errors for differences: 100 m, 1 m/s and so on, far above rounding, far below curvature.
constexpr double kSize[] = {100.0, 1.0, 1e-4, 1e-3, 1e-5, 1e-4, 1e-4};
/// Of errors_of(): a place to its last digit in m, the velocity in m/s, the attitude in rad.
constexpr double kRounding[] = {1e-9, 5e-14, 5e-16};

/// ∂(errors after a step)/∂(errors before), by central differences of the mechanization itself.
MatrixXd differences() {
  const NavState truth = stepped(Errors::Zero());
  MatrixXd columns(9, 21);
  for (int j = 0; j < 21; ++j) {
    Errors e = Errors::Zero();
    e(j) = kSize[j / 3];
    columns.col(j) = ((errors_of(stepped(e), truth) - errors_of(stepped(-e), truth)) / (2.0 * e(j))).head<9>();
  }
  return columns;
}

double largest(const MatrixXd& matrix, int row_block, int column_block) {
  return matrix.block<3, 3>(3 * row_block, 3 * column_block).cwiseAbs().maxCoeff();
}

TEST(Transition, IsTheDerivativeOfTheMechanizationBlockByBlock) {
  const MatrixXd found = transition_matrix() - MatrixXd::Identity(21, 21);
  const MatrixXd off = differences() - MatrixXd::Identity(9, 21) - found.topRows(9);
  // Φ is of first order in the step; what it neglects is F² dt²/2.
  const MatrixXd second_order = 0.5 * found.lazyProduct(found);
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 7; ++column) {
      const double size = largest(found, row, column);
      const double tolerance = 0.01 * size + 1.01 * largest(second_order, row, column) + kRounding[row] / kSize[column];
      EXPECT_LT(largest(off, row, column), tolerance) << row << ", " << column;
      // A block of the wrong sign would be off by twice its size.
      EXPECT_TRUE(size == 0.0 || size > 10.0 * tolerance) << row << ", " << column;
    }
  }
}

TEST(Transition, FifteenStatesAreTheFirstOfTwentyOne) {
  Mechanization ins(fast_and_high());
  ins.step({kStep_s, kStep_s * kRate_rps, kStep_s * kForce_mps2});
  base::Random random(3);
  Covariance small;
  for (int i = 0; i < 15; ++i) {
    for (int j = 0; j <= i; ++j) small.at(i, j) = small.at(j, i) = random.gaussian();
  }
  Covariance large = small;
  Transition transition;
  transition.kept.fill(0.9);
  find_transition(ins.terms(), ins.state().velocity_mps, kRate_rps, kForce_mps2, kStep_s, transition);
  propagate(transition, small);
  transition.has_scales = true;
  find_transition(ins.terms(), ins.state().velocity_mps, kRate_rps, kForce_mps2, kStep_s, transition);
  propagate(transition, large);
  EXPECT_EQ(small.values, large.values);
}

TEST(Transition, AnUpdateIsThatOfTheTextbook) {
  // A fix of the position with a diagonal covariance: P⁺ = P R/(P + R), the error shrinks by R/(P + R).
  Start start;
  start.state = {{0.7, 0.1, 0.0}, Vector3d::Zero(), {}};
  start.position_sigma_m = {3.0, 4.0, 5.0};
  NavigationFilter filter(start, {}, Vector3d::Zero());
  GnssFix fix;
  fix.position = moved(start.state.position, {1.0, 1.0, 1.0});
  fix.position_sigma_m = {1.0, 2.0, 3.0};
  const Innovation innovation = filter.update_position(fix);
  EXPECT_TRUE(innovation.used);
  EXPECT_NEAR(innovation.nis, 1.0 / 10.0 + 1.0 / 20.0 + 1.0 / 34.0, 1e-6);
  const MatrixXd p = filter.covariance();
  EXPECT_NEAR(p(0, 0), 9.0 * 1.0 / 10.0, 1e-12);
  EXPECT_NEAR(p(1, 1), 16.0 * 4.0 / 20.0, 1e-12);
  EXPECT_NEAR(p(2, 2), 25.0 * 9.0 / 34.0, 1e-12);
  const Vector3d left = offset_m(fix.position, filter.state().position);
  EXPECT_NEAR(left.x(), -0.1, 1e-6);
  EXPECT_NEAR(left.y(), -0.2, 1e-6);
  EXPECT_NEAR(left.z(), -9.0 / 34.0, 1e-6);
}

TEST(Transition, AFixThatCannotBeIsLeftOutButNotForEver) {
  Start start;
  start.state = {{0.7, 0.1, 0.0}, Vector3d::Zero(), {}};
  NavigationFilter filter(start, {}, Vector3d::Zero());
  GnssFix fix;
  fix.position = moved(start.state.position, {100.0, 0.0, 0.0});
  int left_out = 0;
  while (!filter.update_position(fix).used && left_out < 100) ++left_out;
  EXPECT_EQ(left_out, 10);
  EXPECT_GT(offset_m(start.state.position, filter.state().position).x(), 40.0);
}

}  // namespace
}  // namespace soak::nav
