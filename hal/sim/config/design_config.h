// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "calib/vocabulary/sensor.h"
#include "settings/reader.h"

namespace soak::hal::sim {

/// What the runs of a designed campaign have in common and what not.
enum class DesignKind : std::uint8_t {
  identical,     ///< six runs, one like the other
  mixed,         ///< six runs that differ in ramp, soak, order and positions; in one of them the power is cycled
  three,         ///< as identical, three runs
  one,           ///< as identical, one run
  missing_logs,  ///< as identical, but no rows of the ramps and no log of chamber, compressor and supply
};

/// The kind that a name of the enumeration spells; nothing for another text.
[[nodiscard]] std::optional<DesignKind> design_kind_named(std::string_view name);
[[nodiscard]] std::string_view name_of(DesignKind kind);

/// Standard deviations of one kind of sensor: rad/s for gyros, m/s² for accelerometers.
struct DesignNoise {
  double block_sigma = 0.0;      ///< of the mean of one block of a minute: white noise
  double placement_sigma = 0.0;  ///< of each stay in a position
  double visit_sigma = 0.0;      ///< of each visit of a set point
  double run_sigma = 0.0;        ///< of each power-on

  bool operator==(const DesignNoise&) const = default;
};

/// A campaign of the blind benchmark: all keys of [design] with their defaults. SI and °C.
struct DesignConfig {
  DesignKind kind = DesignKind::identical;
  int runs = 6;            ///< passes through the chamber
  double start_c = -20.0;  ///< lowest set point
  double step_c = 15.0;
  int set_points = 7;  ///< visited up and down: 2n − 1 visits
  int blocks = 3;      ///< of one minute, in each position of a visit
  double ramp_kps = 2.0 * (1.0 / 60.0);
  double soak_s = 600.0;  ///< from the end of a ramp to the first block
  double ramp_row_interval_s = 30.0;
  DesignNoise gyro;
  DesignNoise accel;
  double drift_factor = 1.0;        ///< times the scatter of placements and visits
  double amplitude_spread = 0.0;    ///< standard deviation of the hidden effects' strength between runs, relative
  bool dropped_visit = false;       ///< one visit of one run is not recorded
  bool wrong_position = false;      ///< in one visit one position has the label of its opposite
  double thermometer_step_c = 0.0;  ///< 0 = as fine as it comes
  bool known_effects = false;       ///< false: no g-sensitivity and no rotation of the Earth but a hidden one
  bool contributions = false;       ///< the truth lists what the hidden effects do to each block

  bool operator==(const DesignConfig&) const = default;

  [[nodiscard]] const DesignNoise& noise(calib::Sensor sensor) const { return calib::is_gyro(sensor) ? gyro : accel; }
  [[nodiscard]] double set_point_c(int index) const { return start_c + step_c * index; }
  [[nodiscard]] int visits() const { return 2 * set_points - 1; }
};

/// Most runs, set points and blocks that a design may ask for.
inline constexpr int kMaxDesignRuns = 99;
inline constexpr int kMaxDesignSetPoints = 50;
inline constexpr int kMaxDesignBlocks = 60;

/// Runs of a design that does not say how many.
[[nodiscard]] int usual_runs(DesignKind kind);

/// Weight of accelerometers beside gyros that one effect hits: the ratio of their block standard deviations in printed
/// units.
[[nodiscard]] double mps2_per_dps(const DesignConfig& design);

/// Reads [design]; nothing where it is absent. Mistakes are recorded in it.
[[nodiscard]] std::optional<DesignConfig> read_design(const settings::Table& root);

/// The defaults of lab.toml, of a kind.
[[nodiscard]] DesignConfig default_design(DesignKind kind);

}  // namespace soak::hal::sim
