// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "nav/drive/drive.h"
#include "nav/filter/sensor_model.h"
#include "nav/filter/standstill.h"
#include "nav/filter/transition.h"
#include "nav/inertial/mechanization.h"

namespace soak::nav {

/// Where a filter begins, and how well that is known.
struct Start {
  double t_s = 0.0;
  NavState state;                                                ///< of the unit, not of the antenna
  Eigen::Vector3d position_sigma_m = Eigen::Vector3d::Ones();    ///< east, north, up
  Eigen::Vector3d velocity_sigma_mps = Eigen::Vector3d::Ones();  ///< east, north, up
  /// About east and north (tilt) and up (heading).
  Eigen::Vector3d attitude_sigma_rad = Eigen::Vector3d::Constant(0.01);
  Eigen::Vector3d gyro_bias_rps = Eigen::Vector3d::Zero();
  Eigen::Vector3d accel_bias_mps2 = Eigen::Vector3d::Zero();
};

/// A wheeled vehicle neither slides nor jumps: what of its velocity points right and up is taken for noise.
struct NonHolonomic {
  double sigma_mps = 0.2;   ///< of each of the two
  double interval_s = 0.1;  ///< between two such updates
};

/// What a filter takes for granted.
struct FilterOptions {
  SensorModels sensors;
  bool scale_states = false;  ///< 21 states instead of 15: scale factor errors of the six sensors
  Compensation compensation = Compensation::two_sample;
  /// Measurements of less than this probability are left out (chi-squared test of the innovation); after ten fixes
  /// in a row the next is used all the same: then it is the filter that is wrong. 0: none is left out.
  double gate_probability = 1e-4;
  std::optional<NonHolonomic> non_holonomic;
  std::optional<Standstill> standstill;
};

/// What became of a measurement.
struct Innovation {
  double nis = 0.0;  ///< normalised innovation squared, chi-squared with `degrees_of_freedom` if all is as assumed
  int degrees_of_freedom = 0;
  bool used = false;
};

/// Error-state Kalman filter of inertial and satellite navigation, loosely coupled, closed loop: errors are fed back
/// into mechanization and readings at once [AH05 §3.3, fig. 3.3]. States: errors of position, velocity, attitude,
/// biases of accelerometers and gyros, with scale_states also their scale factors.
///
/// Φ = I + F dt, Q by the trapezoidal rule, both at each sample; updates in Joseph's form. Good for intervals up to
/// 0.1 s (the neglected term of the second order is then below 1 % of that of the first for turns below 10°/s).
class NavigationFilter {
 public:
  /// Errors of the states, in the order of covariance(); without scale states the last six are zero.
  using Errors = Eigen::Matrix<double, kMostStates, 1>;

  NavigationFilter(const Start& start, const FilterOptions& options, const Eigen::Vector3d& lever_arm_m);

  /// Carries state and covariance over an interval with these readings. duration > 0.
  void predict(const Eigen::Vector3d& rate_rps, const Eigen::Vector3d& force_mps2, double duration_s);

  Innovation update_position(const GnssFix& fix);
  Innovation update_velocity(const GnssFix& fix);
  /// Position and velocity that were computed, not received. The gate is not asked, and the count of fixes that it left
  /// out stays: whoever computed them says by their standard deviations how far to believe them.
  void update_computed(const GnssFix& fix);
  /// The vehicle stands: its velocity is 0 with this standard deviation.
  Innovation update_standstill(double sigma_mps);
  /// The vehicle neither slides nor jumps. Body axes must be those of the vehicle.
  Innovation update_non_holonomic(double sigma_mps);
  /// Takes errors out of the estimate, as all updates do; the covariance stays.
  void feed_back(const Errors& errors);

  [[nodiscard]] const NavState& state() const { return mechanization_.state(); }
  [[nodiscard]] Geodetic antenna() const;
  [[nodiscard]] Eigen::Vector3d antenna_velocity_mps() const;
  [[nodiscard]] const Eigen::Vector3d& gyro_bias_rps() const { return gyro_bias_; }
  [[nodiscard]] const Eigen::Vector3d& accel_bias_mps2() const { return accel_bias_; }
  /// 1 = 100 %; zero without scale states.
  [[nodiscard]] const Eigen::Vector3d& gyro_scale() const { return gyro_scale_; }
  [[nodiscard]] const Eigen::Vector3d& accel_scale() const { return accel_scale_; }

  /// Of the errors: position, velocity, attitude, accelerometer and gyro biases, their scale factors; 15 or 21 square.
  [[nodiscard]] Eigen::MatrixXd covariance() const;
  /// Φ of the last prediction, of the same errors.
  [[nodiscard]] Eigen::MatrixXd transition() const;
  /// All that feed_back() has taken out so far, summed, and how often it has: an update may take out nothing.
  [[nodiscard]] const Errors& fed_back() const { return fed_back_; }
  [[nodiscard]] std::size_t feed_backs() const { return feed_backs_; }
  /// H: by how much the errors put the antenna off, in m along east, north, up.
  [[nodiscard]] Eigen::Matrix<double, 3, kMostStates> antenna_by_errors() const;

 private:
  enum Kind : std::uint8_t { position, velocity, standing, sideways, computed };
  /// Up to three measurements: unused rows have h = 0, z = 0 and variance 1.
  struct Measurement {
    Kind kind;
    Eigen::Matrix<double, 3, kMostStates> h = Eigen::Matrix<double, 3, kMostStates>::Zero();
    Eigen::Vector3d z = Eigen::Vector3d::Zero();  ///< estimate less measured
    Eigen::Vector3d variance = Eigen::Vector3d::Ones();
    int rows = 3;
  };
  [[nodiscard]] Measurement position_by(const GnssFix& fix, Kind kind) const;
  [[nodiscard]] Measurement velocity_by(const GnssFix& fix, Kind kind) const;
  Innovation update(const Measurement& measurement);
  template <int N>
  Innovation update_states(const Measurement& measurement);
  bool passes_gate(const Innovation& innovation, Kind kind);
  void add_half_of_noise(double duration_s);
  void keep_biases(double duration_s);
  [[nodiscard]] Eigen::Vector3d corrected_rps(const Eigen::Vector3d& reading_rps) const;
  [[nodiscard]] Eigen::Vector3d lever_level_m() const;
  [[nodiscard]] Eigen::Vector3d lever_velocity_mps() const;

  FilterOptions options_;
  Eigen::Vector3d lever_arm_m_;
  int states_;
  Mechanization mechanization_;
  Covariance p_;
  Transition transition_;
  Eigen::Vector3d gyro_bias_;
  Eigen::Vector3d accel_bias_;
  Eigen::Vector3d gyro_level_;   ///< what the gyros' biases tend to
  Eigen::Vector3d accel_level_;  ///< what the accelerometers' biases tend to
  Eigen::Vector3d gyro_scale_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d accel_scale_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d rate_rps_ = Eigen::Vector3d::Zero();  ///< the last corrected reading
  Errors fed_back_ = Errors::Zero();
  std::size_t feed_backs_ = 0;
  double interval_s_ = 0.0;                ///< for which what follows was computed
  std::array<double, 6> bias_variance_{};  ///< half of what an interval adds: accelerometers, gyros
  std::array<double, 4> gate_{};           ///< limit of the NIS by degrees of freedom
  std::array<int, 4> left_out_{};          ///< measurements in a row, of the kinds that the gate may leave out
};

}  // namespace soak::nav
