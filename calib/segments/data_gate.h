// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "calib/vocabulary/recording.h"
#include "calib/vocabulary/segment.h"
#include "calib/vocabulary/unit_type.h"

/// The data gate: what is looked for in the samples of each segment before they may enter a fit.
///
/// | code | severity | what it means |
/// | --- | --- | --- |
/// | `moved` | segment rejected, or warning | the unit was turned within the segment |
/// | `knocked` | segment rejected, or warning | a burst far outside the noise in several sensors at once |
/// | `wrong_position` | segment rejected, or warning | gravity points elsewhere than the position's label says |
/// | `spike` | warning | samples of one sensor that stand alone beyond 20 sigma: left out of the means |
/// | `saturated` | sensor rejected, or warning | samples at the end of the sensor's range |
/// | `stuck` | sensor rejected, or warning | one number repeated for longer than noise and resolution explain |
/// | `dropouts` | sensor rejected, or warning | samples are missing |
/// | `irregular_sampling` | warning | the distances in time between samples scatter |
/// | `coarse_thermometer` | warning | the thermometer moves in steps of half a kelvin or more |
///
/// What it cannot see: a turn about the vertical within a quarter of a second (it looks like a knock), one at a steady
/// rate in a run of less than four positions per visit, or of less than 0.5 deg/s; a move that goes in proportion with
/// the temperature; a sensor with less than 0.35 steps of noise that sticks for part of a segment.
namespace soak::calib {

/// Where the data gate draws its lines. Shares are of a segment's samples of one sensor.
struct GateLimits {
  /// Change of direction of the specific force. An accelerometer's bias moves by 1-2 mg (0.1°) within a segment at
  /// rest; 0.25° is 43 mm/s² on a horizontal axis, as much as many units drift over their whole temperature range.
  double tilt_deg = 0.25;
  /// What temperature may add to the apparent tilt: 0.05°/K is a bias that moves by 8.6 mm/s² per kelvin, three times
  /// the 0.3 m/s² over 100 K of a poor unit. A slow thermal drift is not motion: what each accelerometer does in
  /// proportion to the temperature, up to 30 mm/s² per kelvin, is taken off before (where that changes by 2 K or more
  /// within a quarter of the segment). A segment without plateau whose temperature runs through more than 10 K is a
  /// ramp: there only changes from one stretch to the next but one count.
  double tilt_per_k_deg = 0.05;
  /// Angle that a gyro turns through within one block of 10 s, beyond its rate in the neighbouring blocks.
  double turn_deg = 2.0;
  /// Standard deviations of noise that `tilt_deg` and `turn_deg` are widened by. A segment holds up to some hundred
  /// blocks of six sensors: Gaussian noise passes 6 in one of 10⁶ segments.
  double noise_sigmas = 6.0;

  double knock_sigmas = 10.0;  ///< a sample so far from the median of its block belongs to a knock
  int knock_sensors = 2;       ///< that are hit within 50 ms (or neighbouring samples); one alone is an outlier

  /// Fixtures are true to 1-2°, and a bias of 1 m/s² looks like 6°: the bias common to the positions is taken off
  /// first, where a run has four of the six or more. Beyond the limit, but nearest to the label of all six: a warning.
  double position_deg = 20.0;

  /// More samples than this share at the end of the range, or stuck: the sensor is rejected. 1 % of 60,000 samples
  /// moves a mean by no more than a few of its standard errors.
  double pinned_share = 0.01;
  /// Chance per segment that noise alone repeats a number for as long as counts as stuck.
  double stuck_chance = 1e-9;
  int stuck_samples = 10;  ///< fewer repeated samples are never stuck

  double missing_warn_share = 0.01;
  double missing_reject_share = 0.2;  ///< beyond it nobody knows what the mean is a mean of

  double irregular_share = 0.1;  ///< of the intervals may be off the usual one by more than half of it

  double coarse_step_c = 0.5;  ///< output step of a thermometer
};

/// Examines the samples of each segment of a recording: one list of findings per segment, in their order. `segments`
/// are those of segment() for this recording. Facts of the unit's type (range, output step, sign) are used where they
/// are known. A segment of fewer than 12 samples is too short to tell motion or knocks. Cost linear in rows.
[[nodiscard]] std::vector<std::vector<Finding>> examine(const Recording& recording, std::span<const Segment> segments,
                                                        const UnitType& type, const GateLimits& limits = {});

/// The same for sensors that are in memory one at a time. `recording` (whose own samples nobody looks at) and
/// `segments` must stay where they are.
class Examination {
 public:
  Examination(const Recording& recording, std::span<const Segment> segments, const UnitType& type,
              const GateLimits& limits = {});
  Examination(const Examination&) = delete;
  Examination& operator=(const Examination&) = delete;
  ~Examination();

  /// Looks at one sensor: one sample per row, NaN = missing. Each sensor once at most, when its statistics stand in the
  /// segments.
  void add(Sensor sensor, std::span<const double> samples);
  /// After all sensors. Visits may have been numbered anew since.
  [[nodiscard]] std::vector<std::vector<Finding>> findings() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace soak::calib
