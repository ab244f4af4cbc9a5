// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "calib/vocabulary/sensor.h"
#include "hal/sim/config/design_config.h"
#include "hal/sim/config/hidden_config.h"
#include "hal/sim/config/lab_magnitudes.h"
#include "hal/sim/config/range.h"

namespace soak::hal::sim {

/// Size of a thermal curve, in the SI unit of the quantity that it describes.
struct CurveMagnitudes {
  Range span;                      ///< largest minus smallest value over the temperature range
  double at_25c_half_width = 0.0;  ///< the value at 25 °C lies between minus and plus this
  Range feature_count;             ///< number of local Gaussian features, whole
  Range feature_height;
  Range feature_sigma_c;
};

/// Shape of all thermal curves; lab.toml says what the terms mean.
struct CurveShape {
  double cold_c = 0.0;  ///< the range of temperature over which spans count
  double hot_c = 0.0;
  Range arctan_centre_c;
  Range arctan_width_c;
  Range activation_energy_ev;
  Range other_weight;
  double feature_margin_c = 0.0;
};

/// Magnitudes of one kind of sensor: rad/s for gyros, m/s² for accelerometers.
struct SensorMagnitudes {
  CurveMagnitudes bias;
  CurveMagnitudes scale_ppm;  ///< all zero for gyros
  double power_on_sigma = 0.0;
  double segment_mean_sigma = 0.0;
  double misalignment_half_width_rad = 0.0;
  Range g_sensitivity;  ///< rad/s per m/s²; zero for accelerometers
};

/// How the unit's own thermometer follows the set points.
struct ThermometerMagnitudes {
  double settling_time_s = 0.0;
  double visit_offset_half_width_c = 0.0;
  double plateau_drift_half_width_c = 0.0;
  double noise_sigma_c = 0.0;
};

struct ChamberMagnitudes {
  double settling_time_s = 0.0;
  double noise_sigma_c = 0.0;
};

struct NoiseMagnitudes {
  double slow_share = 0.0;  ///< of the variance of a segment mean
  std::vector<double> slow_correlation_times_s;
};

/// What decides the simulated rotation of the Earth.
struct EarthFrame {
  double latitude_deg = 0.0;  ///< north positive
  double azimuth_deg = 0.0;   ///< heading of the horizontal reference axis, clockwise from north
};

/// All of lab.toml: what a simulated campaign does with how many units, how large every effect is, and what the
/// laboratory adds. SI and °C.
struct CampaignConfig {
  std::uint64_t seed = 0;
  int units = 0;
  int runs = 0;
  int rows_per_position = 0;
  double row_interval_s = 0.0;
  double start_c = 0.0;
  double turn_c = 0.0;
  double step_c = 0.0;
  double ramp_s = 0.0;
  int ramp_rows = 0;
  int moving_rows = 0;
  ThermometerMagnitudes thermometer;
  ChamberMagnitudes chamber;
  CurveShape curve;
  SensorMagnitudes gyro;
  SensorMagnitudes accel;
  NoiseMagnitudes noise;
  std::optional<EarthFrame> earth;  ///< absent = the Earth stands still
  LabMagnitudes lab;
  std::optional<DesignConfig> design;  ///< absent = the recordings of [campaign]
  std::vector<HiddenSpec> hidden;      ///< effects beyond the measurement equation
  std::vector<HiddenSpec> candidates;  ///< effects that act on nothing: the truth says what they would do

  [[nodiscard]] const SensorMagnitudes& magnitudes(calib::Sensor sensor) const {
    return calib::is_gyro(sensor) ? gyro : accel;
  }
};

/// Largest counts that a file or a command line may ask for.
inline constexpr int kMaxUnits = 9999;
inline constexpr int kMaxRuns = 999;
inline constexpr int kMaxRowsPerPosition = 36000;

/// The configuration that `text`, in the format of lab.toml, describes. Errors (bad_input): the first syntax
/// error; a key that is missing, unknown, of another type or out of its limits; each with "`file`:line".
[[nodiscard]] base::Result<CampaignConfig> parse_campaign_config(std::string_view text, const std::string& file);

/// parse_campaign_config() of a file's content; a file that cannot be read is bad_input too.
[[nodiscard]] base::Result<CampaignConfig> read_campaign_config(const std::string& file);

}  // namespace soak::hal::sim
