// SPDX-License-Identifier: Apache-2.0
#include "nav/filter/transition.h"

#include <cstring>

#include "nav/geometry/attitude.h"

namespace soak::nav {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// rows[0..2] of out += block · rows[from..from+2] of p, W numbers a row.
template <int W>
void add_block(const Matrix3d& block, const double* p, double* out) {
  for (int i = 0; i < 3; ++i) {
    const double b0 = block(i, 0);
    const double b1 = block(i, 1);
    const double b2 = block(i, 2);
    double* __restrict row = out + i * kRow;
    for (int c = 0; c < W; ++c) row[c] += b0 * p[c] + b1 * p[kRow + c] + b2 * p[2 * kRow + c];
  }
}

/// out = Φ p for W columns.
template <int W>
void apply(const Transition& t, const double* p, double* __restrict out) {
  std::memcpy(out, p, sizeof(double) * kRow * kMostStates);
  const double* r = p;
  const double* v = p + 3 * kRow;
  const double* a = p + 6 * kRow;
  const double* accel = p + 9 * kRow;
  const double* gyro = p + 12 * kRow;
  add_block<W>(t.rr, r, out);
  add_block<W>(t.rv, v, out);
  double* out_v = out + 3 * kRow;
  add_block<W>(t.vr, r, out_v);
  add_block<W>(t.vv, v, out_v);
  add_block<W>(t.vp, a, out_v);
  add_block<W>(t.va, accel, out_v);
  double* out_p = out + 6 * kRow;
  add_block<W>(t.pr, r, out_p);
  add_block<W>(t.pv, v, out_p);
  add_block<W>(t.pp, a, out_p);
  add_block<W>(t.pg, gyro, out_p);
  if (t.has_scales) {
    add_block<W>(t.vs, p + 15 * kRow, out_v);
    add_block<W>(t.ps, p + 18 * kRow, out_p);
  }
  for (int i = 0; i < 6; ++i) {
    double* row = out + (9 + i) * kRow;
    for (int c = 0; c < W; ++c) row[c] *= t.kept[static_cast<std::size_t>(i)];
  }
}

template <int W>
void propagate_rows(const Transition& t, Covariance& p) {
  Covariance half;
  apply<W>(t, p.values.data(), half.values.data());
  // P is symmetric: Φ (Φ P)ᵀ is the whole product.
  Covariance turned;
  for (int i = 0; i < W; ++i) {
    for (int c = 0; c < W; ++c) turned.at(c, i) = half.at(i, c);
  }
  apply<W>(t, turned.values.data(), p.values.data());
}

}  // namespace

void find_transition(const StepTerms& terms, const Vector3d& velocity_mps, const Vector3d& rate_rps,
                     const Vector3d& force_mps2, double dt, Transition& t) {
  const double m = terms.meridian_m;
  const double n = terms.normal_m;
  const double tangent = terms.tan_latitude;
  const double east = velocity_mps.x();
  const double north = velocity_mps.y();
  const double up = velocity_mps.z();
  const Vector3d& earth = terms.earth_rps;
  const Vector3d inertial = earth + terms.transport_rps;

  // Rates of the level frame by velocity, and by position east, north, up.
  Matrix3d by_velocity;
  by_velocity << 0.0, -1.0 / m, 0.0, 1.0 / n, 0.0, 0.0, tangent / n, 0.0, 0.0;
  Matrix3d earth_by_place = Matrix3d::Zero();
  earth_by_place.col(1) = Vector3d(0.0, -earth.z(), earth.y()) / m;
  Matrix3d transport_by_place = Matrix3d::Zero();
  transport_by_place(2, 1) = east * (1.0 + tangent * tangent) / (n * m);
  transport_by_place.col(2) = Vector3d(north / (m * m), -east / (n * n), -east * tangent / (n * n));

  t.rr << (up - tangent * north) / n, east * tangent / n, -east / n, 0.0, up / m, -north / m, 0.0, 0.0, 0.0;
  t.rr *= dt;
  t.rv = dt * Matrix3d::Identity();
  const Matrix3d v_cross = dt * skew(velocity_mps);
  t.vr = v_cross * (2.0 * earth_by_place + transport_by_place);
  t.vr(2, 2) += dt * 2.0 * terms.gravity_mps2 / n;
  t.vv = v_cross * by_velocity - dt * skew(earth + inertial);
  t.vp = dt * skew(terms.force_mps2);
  t.va = dt * terms.body_to_level;
  t.pr = dt * (earth_by_place + transport_by_place);
  t.pv = dt * by_velocity;
  t.pp = -dt * skew(inertial);
  t.pg = -t.va;
  if (!t.has_scales) return;
  t.vs = t.va * force_mps2.asDiagonal();
  t.ps = t.pg * rate_rps.asDiagonal();
}

void apply(const Transition& transition, Covariance& m) {
  const Covariance before = m;
  apply<kRow>(transition, before.values.data(), m.values.data());
}

void propagate(const Transition& transition, Covariance& p) {
  if (transition.has_scales) {
    propagate_rows<kRow>(transition, p);
  } else {
    propagate_rows<16>(transition, p);
  }
}

}  // namespace soak::nav
