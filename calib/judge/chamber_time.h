// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "calib/model/unit_model.h"
#include "calib/vocabulary/sensor.h"

namespace soak::calib {

/// Which directions of temperature a campaign visits. The plateau at which a run turns belongs to both.
enum class Sweeps : std::uint8_t { both, up, down };

constexpr std::string_view name_of(Sweeps sweeps) {
  return sweeps == Sweeps::up ? "up" : sweeps == Sweeps::down ? "down" : "both";
}

/// What a campaign of some kind is expected to leave of one sensor's bias, SI. Offsets of single runs are not in it.
struct ExpectedError {
  double error_rms = 0.0;  ///< of the fitted curve against the shape that all runs share, over all plateaus and sweeps
  /// 95 % interval of error_rms: of its expectation over campaigns of that kind, not of one campaign's luck.
  double error_low = 0.0;
  double error_high = 0.0;
  /// Of the plateau estimates of a fresh run about the curve, its own mean error removed: √(error_rms² + scatter²), the
  /// scatter of single estimates being the same for all campaigns.
  double rmse_shape = 0.0;
  double rmse_shape_high = 0.0;  ///< the same with error_high
  double level_rms = 0.0;        ///< of the curve's level: run-to-run sigma / √runs
};

/// A campaign that could have been run instead.
struct ChamberTimeOption {
  int runs = 0;
  int plateau_step = 1;            ///< every how manyeth plateau; the coldest and the hottest always
  std::vector<double> plateaus_c;  ///< set points, rising
  Sweeps sweeps = Sweeps::both;
  /// Hours of recording: with the recorded ways between plateaus in full, and with only the longest of the ways that a
  /// longer step joins (detail/schedule.h). The truth is between the two.
  double hours = 0.0;
  double hours_at_least = 0.0;
  /// Whether runs were left over to judge it by; false: all runs, from the trend a + b / runs of the smaller numbers.
  bool measured = true;
  std::array<std::optional<ExpectedError>, kSensorCount> sensors;
};

/// Expected error against chamber time, from parts of a campaign.
struct ChamberTime {
  double hours = 0.0;  ///< of the whole campaign
  int runs = 0;
  /// Rising hours. The last one is the whole campaign. Empty where the runs cannot be judged.
  std::vector<ChamberTimeOption> options;
  std::optional<std::size_t> recommended;  ///< index into options
  std::string reason;                      ///< a sentence: why that option, or why none
};

/// The fits of a whole campaign, sensor by sensor.
using SensorFits = std::array<std::optional<SensorFit>, kSensorCount>;

/// Fits parts of a campaign (fewer runs, every second to fourth plateau, one sweep) and judges each by the runs that it
/// did not contain, at all plateaus of both sweeps, skipped ones included.
///
/// A part is fitted with the family and the rules that the whole campaign led to (fewer rules where it has too few
/// temperatures) and its variance components; biases only. With r_b the errors of held-out run b, own mean removed,
/// the squared error of a curve is the mean over pairs of held-out runs and over plateaus of r_b·r_b': the noise of
/// different runs is independent, so that it drops out of the product without being known. What remains is what the
/// runs share: what the curve misses between plateaus, its own noise, and hysteresis. Averaged over seeded choices of
/// runs; the interval is from leaving out one held-out run after the other (jackknife) and from the scatter of the
/// fits, Student's t with one degree of freedom less than runs. Nothing forces the error to fall with hours.
///
/// Recommended is the shortest option of at least three runs of which rmse_shape_high is, for every sensor, at most 1.1
/// times rmse_shape of the whole campaign, which itself does not count. Fewer than four runs with plateaus: no options.
///
/// `rows` are make_rows(input), `fits` those of the rows.
[[nodiscard]] ChamberTime study_chamber_time(const UnitInput& input, const UnitRows& rows, const SensorFits& fits);

/// The value of `chamber_time` in the document of `soak fit --chamber-time --json` (docs/schema/fit.schema.json):
/// errors in deg/s and m/s².
[[nodiscard]] nlohmann::json chamber_time_json(const ChamberTime& study);

}  // namespace soak::calib
