// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "nav/geometry/attitude.h"
#include "nav/geometry/earth.h"

/// A drive: what a unit and a receiver of satellite navigation read, and where they really were.
namespace soak::nav {

/// Readings of a unit, means over the time since the sample before, in body axes (right, forward, up).
struct ImuSample {
  double t_s = 0.0;  ///< end of the interval
  Eigen::Vector3d rate_rps = Eigen::Vector3d::Zero();
  Eigen::Vector3d force_mps2 = Eigen::Vector3d::Zero();
  double temp_c = std::numeric_limits<double>::quiet_NaN();  ///< of the unit's thermometer; NaN: not read
};

/// A solution of the receiver, for its antenna. Sigmas along east, north, up.
struct GnssFix {
  double t_s = 0.0;
  Geodetic position;
  Eigen::Vector3d position_sigma_m = Eigen::Vector3d::Ones();
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_sigma_mps = Eigen::Vector3d::Ones();
};

/// Where the antenna was.
struct TruthPoint {
  double t_s = 0.0;
  Geodetic position;
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero();
  std::optional<Quaternion> body_to_level;  ///< absent: the recording has no attitude
};

/// What a drive's truth is: of a simulation, the receiver's fixes, another file, or smoothed (nav/filter/smoother.h).
enum class TruthSource : std::uint8_t { simulation, fixes, file, smoother };

/// A drive with one time scale for all of it.
struct Drive {
  std::string name;
  std::vector<ImuSample> imu;
  std::vector<GnssFix> gnss;
  std::vector<TruthPoint> truth;
  Eigen::Vector3d lever_arm_m = Eigen::Vector3d::Zero();  ///< from the unit to the antenna, body axes
  /// Turns the unit's own axes, in which it was calibrated, into body axes: how it is mounted.
  Eigen::Matrix3d unit_to_body = Eigen::Matrix3d::Identity();
  TruthSource truth_source = TruthSource::simulation;
  double truth_sigma_m = 0.0;  ///< horizontal standard deviation of the truth, root of the mean square
};

/// A stretch without satellite navigation.
struct Outage {
  double begin_s = 0.0;
  double end_s = 0.0;
};

/// Readings may be missing for so long: what NavigationFilter is good for, and some rounding of times.
inline constexpr double kLongestInterval_s = 0.11;

/// Refuses (bad_input, where = the drive's name) fewer than 2 samples, times that do not rise, samples more than
/// kLongestInterval_s apart, values that are not finite, rates above 100 rad/s and specific forces above 10,000 m/s²,
/// sigmas that are not positive, fixes at ±89° and beyond.
[[nodiscard]] base::Status validate(const Drive& drive);

/// The drive as it is known at the end of the outage, without the fixes of the outage: what was recorded later is not
/// there, truth included.
[[nodiscard]] Drive with_outage(const Drive& drive, const Outage& outage);

/// Hands out the samples of a drive in time order, cut where something else happens. The drive must outlive it.
class ImuFeed {
 public:
  /// From `start_s`; must not lie before the first sample.
  ImuFeed(const std::vector<ImuSample>& samples, double start_s);
  /// Goes on where the other one is, with other readings of the same times.
  ImuFeed(const ImuFeed& so_far, const std::vector<ImuSample>& samples)
      : samples_(samples), index_(so_far.index_), now_s_(so_far.now_s_) {}

  /// The readings from the present time to the next sample or `until_s`, whichever comes first, and their duration;
  /// nothing once the present time is `until_s` or the samples end.
  struct Piece {
    const ImuSample* sample = nullptr;
    double duration_s = 0.0;
  };
  [[nodiscard]] std::optional<Piece> next(double until_s);

  [[nodiscard]] double now_s() const { return now_s_; }

 private:
  const std::vector<ImuSample>& samples_;
  std::size_t index_ = 0;
  double now_s_;
};

}  // namespace soak::nav
