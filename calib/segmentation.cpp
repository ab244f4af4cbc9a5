// SPDX-License-Identifier: Apache-2.0
#include "calib/segmentation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <span>

#include "base/statistics.h"
#include "calib/plateaus.h"
#include "calib/statistics.h"

namespace soak::calib {
namespace {

constexpr double kBlock_s = 60.0;
constexpr double kBlockWithoutPlateau_s = 30.0;
constexpr double kLongestGap_s = 10.0;
constexpr double kLongestGapIntervals = 20.0;
constexpr double kExcursion_c = 2.0;
constexpr double kAstray_c = 30.0;  ///< no unit warms itself so far above its chamber
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// Rows [first, last) of one plateau and one position; plateau NaN where there is none.
struct Piece {
  std::size_t first = 0;
  std::size_t last = 0;
  double plateau_c = kNone;
  std::int32_t position = -1;
};

bool same(double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); }

bool has_value(const std::vector<double>& values) {
  return std::any_of(values.begin(), values.end(), [](double v) { return !std::isnan(v); });
}

double median_interval_s(const std::vector<double>& t_s) {
  const std::size_t count = std::min<std::size_t>(t_s.size(), 10001);
  std::vector<double> intervals;
  for (std::size_t i = 1; i < count; ++i) intervals.push_back(t_s[i] - t_s[i - 1]);
  return intervals.empty() ? 0.0 : base::median(intervals);
}

/// Plateau of each row found from the temperature, stretch by stretch of soak rows; NaN outside plateaus.
std::vector<double> found_plateaus(const Recording& r) {
  std::vector<double> plateau_c(r.rows(), kNone);
  const auto is_soak = [&](std::size_t i) { return r.phase.empty() || r.phase[i] == Phase::soak; };
  for (std::size_t first = 0; first < r.rows();) {
    std::size_t last = first;
    while (last < r.rows() && is_soak(last)) ++last;
    if (last > first) {
      const std::span<const double> t(r.t_s.data() + first, last - first);
      const std::span<const double> temp(r.temp_c.data() + first, last - first);
      for (const Plateau& p : find_plateaus(t, temp)) {
        const double rounded = std::round(p.temp_c * 10.0) / 10.0;
        std::fill(plateau_c.begin() + static_cast<std::ptrdiff_t>(first + p.first),
                  plateau_c.begin() + static_cast<std::ptrdiff_t>(first + p.last), rounded);
      }
    }
    first = last + 1;
  }
  return plateau_c;
}

std::vector<Piece> cut(const Recording& r, const std::vector<double>& plateau_c, bool with_plateaus) {
  const double longest_gap_s = std::max(kLongestGap_s, kLongestGapIntervals * median_interval_s(r.t_s));
  std::vector<Piece> pieces;
  bool open = false;
  for (std::size_t i = 0; i < r.rows(); ++i) {
    const std::int32_t position = r.position.empty() ? 0 : r.position[i];
    const double plateau = with_plateaus ? plateau_c[i] : kNone;
    const bool soak = r.phase.empty() || r.phase[i] == Phase::soak;
    const bool usable = position >= 0 && (!with_plateaus || (soak && !std::isnan(plateau)));
    if (!usable) {
      open = false;
      continue;
    }
    const bool continues = open && pieces.back().position == position && same(pieces.back().plateau_c, plateau) &&
                           r.t_s[i] - r.t_s[i - 1] <= longest_gap_s;
    if (!continues) pieces.push_back({i, i, plateau, position});
    pieces.back().last = i + 1;
    open = true;
  }
  return pieces;
}

/// Least-squares mean and slope of a temperature over rows [first, last); NaN mean where there is no value.
Line temperature_line(const std::vector<double>& t_s, const std::vector<double>& temp_c, std::size_t first,
                      std::size_t last) {
  std::vector<double> minutes;
  std::vector<double> values;
  for (std::size_t i = first; i < last; ++i) {
    if (std::isnan(temp_c[i])) continue;
    minutes.push_back((t_s[i] - t_s[first]) / 60.0);
    values.push_back(temp_c[i]);
  }
  Line line = fit_line(minutes, values);
  if (values.empty()) line.mean_y = kNone;
  return line;
}

/// Coarser output steps are none: a simulation without noise shows few numbers, gravity apart.
constexpr double kCoarsestAccel_mps2 = 0.5;
constexpr double kCoarsestGyro_dps = 5.0;

/// Output step of each sensor: a segment may show one number only, the whole recording shows more.
using Steps = std::array<double, kSensorCount>;

Steps output_steps(const Recording& r) {
  Steps steps{};
  for (const Sensor sensor : kSensors) {
    const double step = output_step(r.sensor[index_of(sensor)]);
    const double coarsest = is_gyro(sensor) ? kCoarsestGyro_dps / printed_per_si(sensor) : kCoarsestAccel_mps2;
    steps[index_of(sensor)] = step <= coarsest ? step : 0.0;
  }
  return steps;
}

std::array<SensorStatistics, kSensorCount> describe_sensors(const Recording& r, const Steps& steps, std::size_t first,
                                                            std::size_t last) {
  std::array<SensorStatistics, kSensorCount> statistics;
  for (std::size_t s = 0; s < kSensorCount; ++s) {
    if (r.sensor[s].empty()) continue;
    // A sample at an unknown temperature says nothing of a thermal curve.
    const std::vector<double>& temp_c = r.sensor_temp_c[s].empty() ? r.temp_c : r.sensor_temp_c[s];
    std::vector<double> samples(r.sensor[s].begin() + static_cast<std::ptrdiff_t>(first),
                                r.sensor[s].begin() + static_cast<std::ptrdiff_t>(last));
    for (std::size_t i = first; i < last; ++i) {
      if (std::isnan(temp_c[i])) samples[i - first] = kNone;
    }
    statistics[s] = describe(samples, steps[s]);
  }
  return statistics;
}

/// Mean of each sensor's own thermometer over rows [first, last), `temp_c` where it has none or it gave no value.
std::array<double, kSensorCount> sensor_temperatures(const Recording& r, std::size_t first, std::size_t last,
                                                     double temp_c) {
  std::array<double, kSensorCount> temps_c;
  temps_c.fill(temp_c);
  for (std::size_t s = 0; s < kSensorCount; ++s) {
    if (r.sensor_temp_c[s].empty()) continue;
    const double own = temperature_line(r.t_s, r.sensor_temp_c[s], first, last).mean_y;
    if (!std::isnan(own)) temps_c[s] = own;
  }
  return temps_c;
}

std::vector<Block> make_blocks(const Recording& r, const Steps& steps, const Piece& piece, double length_s) {
  std::vector<Block> blocks;
  const double start_s = r.t_s[piece.first];
  const double total_s = r.t_s[piece.last - 1] - start_s;
  for (std::size_t first = piece.first; first < piece.last;) {
    const double index = std::floor((r.t_s[first] - start_s) / length_s);
    std::size_t last = first;
    while (last < piece.last && r.t_s[last] - start_s < (index + 1.0) * length_s) ++last;
    const double covered_s = r.t_s[last - 1] - r.t_s[first];
    // A short rest would be a block with a far larger variance than its neighbours.
    if (covered_s >= 0.5 * length_s || total_s < length_s) {
      const Line temp = temperature_line(r.t_s, r.temp_c, first, last);
      if (!std::isnan(temp.mean_y)) {
        blocks.push_back({0.5 * (r.t_s[first] + r.t_s[last - 1]), std::min(length_s, std::max(covered_s, 0.0)),
                          temp.mean_y, temp.slope, sensor_temperatures(r, first, last, temp.mean_y),
                          describe_sensors(r, steps, first, last)});
      }
    }
    first = last;
  }
  return blocks;
}

/// Numbers the visits, attempts and sweeps of the pieces in the order of time.
class Visits {
 public:
  explicit Visits(const Recording& recording) : r_(recording) {}

  void assign(const Piece& piece, Segment& segment) {
    if (begins_visit(piece)) {
      const Sweep given = r_.sweep.empty() ? Sweep::unknown : r_.sweep[piece.first];
      const bool changed = visit_ >= 0 && !std::isnan(piece.plateau_c) && piece.plateau_c != plateau_c_;
      if (changed) sweep_ = piece.plateau_c > plateau_c_ ? Sweep::up : Sweep::down;
      if (given != Sweep::unknown) sweep_ = given;
      ++visit_;
      plateau_c_ = piece.plateau_c;
      seen_.clear();
    }
    segment.key.visit = visit_;
    segment.sweep = sweep_;
    segment.key.attempt = static_cast<std::int32_t>(std::count(seen_.begin(), seen_.end(), piece.position));
    seen_.push_back(piece.position);
    previous_last_ = piece.last;
    previous_temp_c_ = segment.temp_c;
  }

 private:
  [[nodiscard]] bool begins_visit(const Piece& piece) const {
    if (visit_ < 0 || !same(piece.plateau_c, plateau_c_)) return true;
    if (std::isnan(piece.plateau_c)) return false;
    for (std::size_t i = previous_last_; i < piece.first; ++i) {
      if (std::abs(r_.temp_c[i] - previous_temp_c_) > kExcursion_c) return true;
    }
    return false;
  }

  const Recording& r_;
  std::int32_t visit_ = -1;
  double plateau_c_ = kNone;
  Sweep sweep_ = Sweep::unknown;
  std::vector<std::int32_t> seen_;
  std::size_t previous_last_ = 0;
  double previous_temp_c_ = 0.0;
};

Segment describe_piece(const Recording& r, const Steps& steps, const Piece& piece, bool with_plateaus) {
  Segment segment;
  segment.key.run_id = r.run_id;
  segment.key.unit = r.unit;
  segment.phase = with_plateaus || r.phase.empty() ? Phase::soak : r.phase[piece.first];
  if (!std::isnan(piece.plateau_c)) segment.plateau_c = piece.plateau_c;
  if (!r.position.empty()) {
    segment.position = r.positions[static_cast<std::size_t>(piece.position)];
    segment.key.position = segment.position->label;
  }
  segment.t_start_s = r.t_s[piece.first];
  segment.t_end_s = r.t_s[piece.last - 1];
  const Line temp = temperature_line(r.t_s, r.temp_c, piece.first, piece.last);
  segment.temp_c = temp.mean_y;
  segment.temp_rate_kpmin = temp.slope;
  segment.sensor_temp_c = sensor_temperatures(r, piece.first, piece.last, segment.temp_c);
  segment.sensor = describe_sensors(r, steps, piece.first, piece.last);
  return segment;
}

}  // namespace

base::Result<Segmentation> segment(const Recording& r) {
  if (r.rows() == 0) return base::bad_input("the recording has no rows", r.unit);
  const bool given = has_value(r.plateau_c);
  const std::vector<double> plateau_c = given ? r.plateau_c : found_plateaus(r);
  const bool with_plateaus = given || has_value(plateau_c);

  const Steps steps = output_steps(r);
  Segmentation result;
  Visits visits(r);
  std::size_t without_temperature = 0;
  for (const Piece& piece : cut(r, plateau_c, with_plateaus)) {
    Segment segment = describe_piece(r, steps, piece, with_plateaus);
    if (std::isnan(segment.temp_c)) {
      ++without_temperature;
      continue;
    }
    visits.assign(piece, segment);
    segment.blocks = make_blocks(r, steps, piece, with_plateaus ? kBlock_s : kBlockWithoutPlateau_s);
    result.segments.push_back(std::move(segment));
  }
  if (!with_plateaus) {
    result.warnings.emplace_back("no plateau was given and none found in the temperature: 30-second blocks stand in");
  }
  const auto astray = std::find_if(result.segments.begin(), result.segments.end(), [](const Segment& segment) {
    return segment.plateau_c && std::abs(segment.temp_c - *segment.plateau_c) > kAstray_c;
  });
  if (astray != result.segments.end()) {
    result.warnings.push_back(
        fmt::format("the unit's thermometer reads {:.1f} °C at the {:.1f} °C plateau: check the unit of "
                    "the temperature (temp_k for kelvin)",
                    astray->temp_c, *astray->plateau_c));
  }
  if (result.segments.empty()) {
    result.warnings.emplace_back(
        "no segment was found: all rows are of ramps or moves, so that no fit can use this run");
  }
  if (without_temperature > 0) {
    result.warnings.push_back(
        fmt::format("{} segments without a value of the thermometer were left out", without_temperature));
  }
  return result;
}

}  // namespace soak::calib
