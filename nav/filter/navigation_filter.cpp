// SPDX-License-Identifier: Apache-2.0
#include "nav/filter/navigation_filter.h"

#include <cmath>
#include <limits>

#include "base/linear/dense_solve.h"
#include "base/statistics.h"

namespace soak::nav {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr int kPosition = 0;
constexpr int kVelocity = 3;
constexpr int kAttitude = 6;
constexpr int kAccelBias = 9;
constexpr int kGyroBias = 12;
constexpr int kAccelScale = 15;
constexpr int kGyroScale = 18;

/// Measurements in a row that may be left out.
constexpr int kMostLeftOut = 10;

/// The model of the i-th bias state: accelerometers, then gyros.
const SensorModel& model_of(const SensorModels& sensors, std::size_t i) { return sensors[(i + 3) % 6]; }

double squared(double x) { return x * x; }

Eigen::MatrixXd dense(const Covariance& matrix, int states) {
  Eigen::MatrixXd copy(states, states);
  for (int i = 0; i < states; ++i) {
    for (int j = 0; j < states; ++j) copy(i, j) = matrix.at(i, j);
  }
  return copy;
}

}  // namespace

NavigationFilter::NavigationFilter(const Start& start, const FilterOptions& options, const Vector3d& lever_arm_m)
    : options_(options),
      lever_arm_m_(lever_arm_m),
      states_(options.scale_states ? 21 : 15),
      mechanization_(start.state, options.compensation),
      gyro_bias_(start.gyro_bias_rps),
      accel_bias_(start.accel_bias_mps2),
      gyro_level_(start.gyro_bias_rps),
      accel_level_(start.accel_bias_mps2) {
  for (int i = 0; i < 3; ++i) {
    p_.at(kPosition + i, kPosition + i) = squared(start.position_sigma_m(i));
    p_.at(kVelocity + i, kVelocity + i) = squared(start.velocity_sigma_mps(i));
    p_.at(kAttitude + i, kAttitude + i) = squared(start.attitude_sigma_rad(i));
  }
  for (int i = 0; i < 6; ++i) {
    const SensorModel& model = model_of(options.sensors, static_cast<std::size_t>(i));
    p_.at(kAccelBias + i, kAccelBias + i) = squared(model.bias.start_sigma);
    if (options.scale_states) p_.at(kAccelScale + i, kAccelScale + i) = squared(model.scale_sigma);
  }
  transition_.has_scales = options.scale_states;
  for (int rows = 1; rows <= 3; ++rows) {
    gate_[static_cast<std::size_t>(rows)] = options.gate_probability > 0.0
                                                ? base::chi_squared_quantile(1.0 - options.gate_probability, rows)
                                                : std::numeric_limits<double>::infinity();
  }
}

void NavigationFilter::keep_biases(double duration_s) {
  if (duration_s != interval_s_) {
    interval_s_ = duration_s;
    for (std::size_t i = 0; i < 6; ++i) {
      const BiasModel& bias = model_of(options_.sensors, i).bias;
      const double kept = std::exp(-duration_s / bias.time_s);
      transition_.kept[i] = kept;
      bias_variance_[i] = 0.5 * (squared(bias.sigma) * (1.0 - kept * kept) + squared(bias.walk) * duration_s);
    }
  }
  for (int i = 0; i < 3; ++i) {
    const auto at = static_cast<std::size_t>(i);
    accel_bias_(i) = accel_level_(i) + transition_.kept[at] * (accel_bias_(i) - accel_level_(i));
    gyro_bias_(i) = gyro_level_(i) + transition_.kept[at + 3] * (gyro_bias_(i) - gyro_level_(i));
  }
}

void NavigationFilter::add_half_of_noise(double duration_s) {
  const Matrix3d& r = mechanization_.terms().body_to_level;
  Vector3d accel;
  Vector3d gyro;
  for (int i = 0; i < 3; ++i) {
    gyro(i) = 0.5 * duration_s * squared(options_.sensors[static_cast<std::size_t>(i)].white);
    accel(i) = 0.5 * duration_s * squared(options_.sensors[static_cast<std::size_t>(i) + 3].white);
  }
  const Matrix3d of_velocity = r * accel.asDiagonal() * r.transpose();
  const Matrix3d of_attitude = r * gyro.asDiagonal() * r.transpose();
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      p_.at(kVelocity + i, kVelocity + j) += of_velocity(i, j);
      p_.at(kAttitude + i, kAttitude + j) += of_attitude(i, j);
    }
  }
  for (int i = 0; i < 6; ++i) p_.at(kAccelBias + i, kAccelBias + i) += bias_variance_[static_cast<std::size_t>(i)];
}

Vector3d NavigationFilter::corrected_rps(const Vector3d& reading_rps) const {
  return (reading_rps - gyro_bias_).cwiseQuotient(Vector3d::Ones() + gyro_scale_);
}

void NavigationFilter::predict(const Vector3d& rate_rps, const Vector3d& force_mps2, double duration_s) {
  keep_biases(duration_s);
  rate_rps_ = corrected_rps(rate_rps);
  const Vector3d force = (force_mps2 - accel_bias_).cwiseQuotient(Vector3d::Ones() + accel_scale_);
  mechanization_.step({duration_s, duration_s * rate_rps_, duration_s * force});

  // P ← Φ (P + Q/2) Φᵀ + Q/2
  find_transition(mechanization_.terms(), mechanization_.state().velocity_mps, rate_rps_, force, duration_s,
                  transition_);
  add_half_of_noise(duration_s);
  propagate(transition_, p_);
  add_half_of_noise(duration_s);
}

bool NavigationFilter::passes_gate(const Innovation& innovation, Kind kind) {
  const bool passes = innovation.nis <= gate_[static_cast<std::size_t>(innovation.degrees_of_freedom)];
  if (kind == Kind::computed) return true;
  int& left_out = left_out_[kind];
  // Only a receiver can be right against the filter; that the vehicle stands or does not slide is no more than assumed.
  const bool is_read = kind == Kind::position || kind == Kind::velocity;
  const bool used = passes || (is_read && left_out >= kMostLeftOut);
  left_out = used ? 0 : left_out + 1;
  return used;
}

template <int N>
Innovation NavigationFilter::update_states(const Measurement& measurement) {
  using Gain = Eigen::Matrix<double, N, 3>;
  using Rows = Eigen::Map<Eigen::Matrix<double, kRow, kRow, Eigen::RowMajor>, Eigen::Aligned16>;
  auto p = Rows(p_.values.data()).template topLeftCorner<N, N>();
  const Eigen::Matrix<double, 3, N> h = measurement.h.leftCols<N>();

  // S = H P Hᵀ + R, K = P Hᵀ S⁻¹ [AH05 eq. 3.13]
  const Gain p_ht = p * h.transpose();
  const Matrix3d h_p_ht = h * p_ht;
  Matrix3d s = h_p_ht;
  s.diagonal() += measurement.variance;
  const Matrix3d s_inverse = base::inverse(s);
  Innovation innovation{measurement.z.dot(s_inverse * measurement.z), measurement.rows, false};
  innovation.used = passes_gate(innovation, measurement.kind);
  if (!innovation.used) return innovation;

  // Joseph: P ← (I − K H) P (I − K H)ᵀ + K R Kᵀ; the lower triangle, then its mirror image.
  const Gain k = p_ht * s_inverse;
  const Gain left = p_ht - k * h_p_ht - k * measurement.variance.asDiagonal();
  for (int i = 0; i < N; ++i) {
    for (int j = 0; j <= i; ++j) {
      const double less = k(i, 0) * p_ht(j, 0) + k(i, 1) * p_ht(j, 1) + k(i, 2) * p_ht(j, 2) + left(i, 0) * k(j, 0) +
                          left(i, 1) * k(j, 1) + left(i, 2) * k(j, 2);
      p_.at(i, j) -= less;
      p_.at(j, i) = p_.at(i, j);
    }
  }
  Errors errors = Errors::Zero();
  errors.head<N>() = k * measurement.z;
  feed_back(errors);
  return innovation;
}

Innovation NavigationFilter::update(const Measurement& measurement) {
  return options_.scale_states ? update_states<21>(measurement) : update_states<15>(measurement);
}

void NavigationFilter::feed_back(const Errors& errors) {
  NavState state = mechanization_.state();
  state.position = moved(state.position, -errors.segment<3>(kPosition));
  state.velocity_mps -= errors.segment<3>(kVelocity);
  // R = (I + [φ×]) R̂
  state.body_to_level = normalized(rotation_of(errors.segment<3>(kAttitude)) * state.body_to_level);
  mechanization_.set_state(state);
  const Vector3d reading_rps = rate_rps_ + gyro_scale_.cwiseProduct(rate_rps_) + gyro_bias_;
  accel_bias_ += errors.segment<3>(kAccelBias);
  gyro_bias_ += errors.segment<3>(kGyroBias);
  accel_scale_ += errors.segment<3>(kAccelScale);
  gyro_scale_ += errors.segment<3>(kGyroScale);
  rate_rps_ = corrected_rps(reading_rps);
  fed_back_ += errors;
  ++feed_backs_;
}

Vector3d NavigationFilter::lever_level_m() const { return to_matrix(state().body_to_level) * lever_arm_m_; }

/// Of the antenna over the unit: it turns about it with the body, over a rotating Earth.
Vector3d NavigationFilter::lever_velocity_mps() const {
  return to_matrix(state().body_to_level) * cross(rate_rps_, lever_arm_m_) -
         cross(earth_rate_rps(state().position.latitude_rad), lever_level_m());
}

Geodetic NavigationFilter::antenna() const { return moved(state().position, lever_level_m()); }

Vector3d NavigationFilter::antenna_velocity_mps() const { return state().velocity_mps + lever_velocity_mps(); }

Eigen::Matrix<double, 3, kMostStates> NavigationFilter::antenna_by_errors() const {
  // r̂ + R̂ l − (r + R l) = δr + (R l) × φ
  Eigen::Matrix<double, 3, kMostStates> h = Eigen::Matrix<double, 3, kMostStates>::Zero();
  h.block<3, 3>(0, kPosition).setIdentity();
  h.block<3, 3>(0, kAttitude) = skew(lever_level_m());
  return h;
}

NavigationFilter::Measurement NavigationFilter::position_by(const GnssFix& fix, Kind kind) const {
  Measurement at{kind};
  at.h = antenna_by_errors();
  at.z = offset_m(fix.position, antenna());
  at.variance = fix.position_sigma_m.cwiseAbs2();
  return at;
}

NavigationFilter::Measurement NavigationFilter::velocity_by(const GnssFix& fix, Kind kind) const {
  // v̂ + R̂ (ω̂ × l) − v_gnss = δv + R (ω × l) × φ − R [l×] δω
  const Matrix3d r = to_matrix(state().body_to_level);
  Measurement over{kind};
  over.h.block<3, 3>(0, kVelocity).setIdentity();
  over.h.block<3, 3>(0, kAttitude) = skew(r * cross(rate_rps_, lever_arm_m_));
  over.h.block<3, 3>(0, kGyroBias) = -r * skew(lever_arm_m_);
  if (options_.scale_states) {
    over.h.block<3, 3>(0, kGyroScale) = -r * skew(lever_arm_m_) * rate_rps_.asDiagonal();
  }
  over.z = antenna_velocity_mps() - fix.velocity_mps;
  over.variance = fix.velocity_sigma_mps.cwiseAbs2();
  return over;
}

Innovation NavigationFilter::update_position(const GnssFix& fix) { return update(position_by(fix, Kind::position)); }

Innovation NavigationFilter::update_velocity(const GnssFix& fix) { return update(velocity_by(fix, Kind::velocity)); }

void NavigationFilter::update_computed(const GnssFix& fix) {
  update(position_by(fix, Kind::computed));
  update(velocity_by(fix, Kind::computed));
}

Innovation NavigationFilter::update_standstill(double sigma_mps) {
  Measurement rest{Kind::standing};
  rest.h.block<3, 3>(0, kVelocity).setIdentity();
  rest.z = state().velocity_mps;
  rest.variance.setConstant(squared(sigma_mps));
  return update(rest);
}

Innovation NavigationFilter::update_non_holonomic(double sigma_mps) {
  // v̂ in body axes: R̂ᵀ v̂ = Rᵀ v + Rᵀ δv − Rᵀ [v×] φ; rows right and up.
  const Matrix3d level_to_body = to_matrix(state().body_to_level).transpose();
  const Vector3d in_body = level_to_body * state().velocity_mps;
  const Matrix3d by_attitude = -level_to_body * skew(state().velocity_mps);
  Measurement slide{Kind::sideways};
  slide.rows = 2;
  for (const auto& [row, axis] : {std::pair(0, 0), std::pair(1, 2)}) {
    slide.h.block<1, 3>(row, kVelocity) = level_to_body.row(axis);
    slide.h.block<1, 3>(row, kAttitude) = by_attitude.row(axis);
    slide.z(row) = in_body(axis);
    slide.variance(row) = squared(sigma_mps);
  }
  return update(slide);
}

Eigen::MatrixXd NavigationFilter::covariance() const { return dense(p_, states_); }

Eigen::MatrixXd NavigationFilter::transition() const {
  Covariance phi;
  for (int i = 0; i < states_; ++i) phi.at(i, i) = 1.0;
  apply(transition_, phi);
  return dense(phi, states_);
}

}  // namespace soak::nav
