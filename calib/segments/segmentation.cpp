// SPDX-License-Identifier: Apache-2.0
#include "calib/segments/segmentation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <utility>

#include "base/statistics.h"
#include "calib/segments/detail/sample_scan.h"
#include "calib/segments/detail/segment_maker.h"
#include "calib/segments/statistics.h"

namespace soak::calib {
namespace {

using cutting::Piece;
using cutting::Rows;

// Plateaus of a temperature history.

constexpr double kShortMean_s = 10.0;
constexpr double kShortestPlateau_s = 180.0;
constexpr double kPlateauBand_c = 0.6;
constexpr double kSamePlateauLevel_c = 1.0;

/// Mean temperature of the rows [first, last), all within ten seconds.
struct ShortMean {
  std::size_t first;
  std::size_t last;
  double start_s;
  double end_s;
  double temp_c;
};

std::vector<ShortMean> short_means(std::span<const double> t_s, std::span<const double> temp_c) {
  std::vector<ShortMean> means;
  std::size_t first = 0;
  while (first < t_s.size()) {
    std::size_t last = first;
    double sum = 0.0;
    std::size_t count = 0;
    for (; last < t_s.size() && (last == first || t_s[last] - t_s[first] < kShortMean_s); ++last) {
      if (std::isnan(temp_c[last])) continue;
      sum += temp_c[last];
      ++count;
    }
    if (count > 0) means.push_back({first, last, t_s[first], t_s[last - 1], sum / static_cast<double>(count)});
    first = last;
  }
  return means;
}

/// Number of short means from `start` on that stay within the band.
std::size_t still_length(const std::vector<ShortMean>& means, std::size_t start) {
  double low = means[start].temp_c;
  double high = low;
  std::size_t i = start;
  for (; i < means.size(); ++i) {
    low = std::min(low, means[i].temp_c);
    high = std::max(high, means[i].temp_c);
    if (high - low > kPlateauBand_c) break;
  }
  return i - start;
}

Plateau plateau_of(const std::vector<ShortMean>& means, std::size_t start, std::size_t length) {
  double sum = 0.0;
  for (std::size_t i = start; i < start + length; ++i) sum += means[i].temp_c;
  return {means[start].first, means[start + length - 1].last, sum / static_cast<double>(length)};
}

/// A stretch follows another without a step when no time to speak of lies between them.
bool follows(std::span<const double> t_s, const Plateau& before, const Plateau& after) {
  return t_s[after.first] - t_s[before.last - 1] <= 3.0 * kShortMean_s;
}

// Pieces of a recording.

constexpr double kBlock_s = 60.0;
constexpr double kBlockWithoutPlateau_s = 30.0;
constexpr double kLongestGap_s = 10.0;
constexpr double kLongestGapIntervals = 20.0;
constexpr double kExcursion_c = 2.0;
constexpr double kAstray_c = 30.0;  ///< no unit warms itself so far above its chamber
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
/// A session in which the unit warms up by less than this, on no plateau, is one at a single temperature.
constexpr double kBenchSpan_c = 5.0;

bool same_value(double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); }

bool has_value(const std::vector<double>& values) {
  return std::any_of(values.begin(), values.end(), [](double v) { return !std::isnan(v); });
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

/// Whether soak rows show two plateaus or more.
bool shows_plateaus(const std::vector<double>& plateau_c) {
  const auto first = std::find_if(plateau_c.begin(), plateau_c.end(), [](double v) { return !std::isnan(v); });
  return first != plateau_c.end() &&
         std::any_of(first, plateau_c.end(), [&](double v) { return !std::isnan(v) && v != *first; });
}

/// The one plateau of a session on a bench with positions: the mean temperature of its soak rows in them; nothing where
/// it is none.
std::optional<double> bench_plateau(const Recording& r) {
  if (r.positions.size() < 2) return std::nullopt;
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  double sum = 0.0;
  double count = 0.0;
  for (std::size_t i = 0; i < r.rows(); ++i) {
    const bool soak = r.phase.empty() || r.phase[i] == Phase::soak;
    if (!soak || r.position[i] < 0 || std::isnan(r.temp_c[i])) continue;
    low = std::min(low, r.temp_c[i]);
    high = std::max(high, r.temp_c[i]);
    sum += r.temp_c[i];
    count += 1.0;
  }
  if (count == 0.0 || high - low > kBenchSpan_c) return std::nullopt;
  return std::round(10.0 * sum / count) / 10.0;
}

/// Found plateaus, or the one of a session on a bench; all NaN where there are none.
std::vector<double> plateaus_without_set_points(const Recording& r) {
  std::vector<double> found = found_plateaus(r);
  if (shows_plateaus(found)) return found;
  if (const auto plateau_c = bench_plateau(r)) found.assign(r.rows(), *plateau_c);
  return found;
}

/// The standstills of a session without positions, one piece each, on one plateau.
std::vector<Piece> standstill_pieces(const Recording& r, std::span<const Standstill> standstills) {
  double sum = 0.0;
  double count = 0.0;
  for (const Standstill& rest : standstills) {
    for (std::size_t i = rest.first; i < rest.last; ++i) {
      if (std::isnan(r.temp_c[i])) continue;
      sum += r.temp_c[i];
      count += 1.0;
    }
  }
  std::vector<Piece> pieces;
  for (const Standstill& rest : standstills) {
    const auto number = static_cast<std::int32_t>(pieces.size());
    pieces.push_back({rest.first, rest.last, std::round(10.0 * sum / count) / 10.0, number});
  }
  return pieces;
}

std::vector<Piece> cut_pieces(const Recording& r, const std::vector<double>& plateau_c, bool with_plateaus) {
  cutting::PieceCutter cutter(with_plateaus, cutting::longest_gap_s(r.t_s));
  for (std::size_t i = 0; i < r.rows(); ++i) {
    const bool soak = r.phase.empty() || r.phase[i] == Phase::soak;
    cutter.add(r.t_s[i], with_plateaus ? plateau_c[i] : kNone, r.position.empty() ? 0 : r.position[i], soak);
  }
  return cutter.finish();
}

/// Coarser output steps are none: a simulation without noise shows few numbers, gravity apart.
constexpr double kCoarsestAccel_mps2 = 0.5;
constexpr double kCoarsestGyro_dps = 5.0;

/// Rows of the block that begins with row `first` of a piece: those within the next `length_s` from the piece's start.
std::size_t end_of_block(const Recording& r, const Piece& piece, std::size_t first, double length_s) {
  const double start_s = r.t_s[piece.first];
  const double index = std::floor((r.t_s[first] - start_s) / length_s);
  const auto rows = std::span(r.t_s).subspan(first, piece.last - first);
  const auto end = std::partition_point(rows.begin(), rows.end(),
                                        [&](double t_s) { return t_s - start_s < (index + 1.0) * length_s; });
  return first + static_cast<std::size_t>(end - rows.begin());
}

/// What can be said of a piece before any sensor. `at_rest`: it is a standstill, whose position nobody has named.
Segment identified(const Recording& r, const Piece& piece, bool with_plateaus, bool at_rest) {
  Segment segment;
  segment.key.run_id = r.run_id;
  segment.key.unit = r.unit;
  segment.phase = with_plateaus || r.phase.empty() ? Phase::soak : r.phase[piece.first];
  if (!std::isnan(piece.plateau_c)) segment.plateau_c = piece.plateau_c;
  if (!r.position.empty()) {
    segment.position = r.positions[static_cast<std::size_t>(piece.position)];
    segment.key.position = segment.position->label;
  } else if (at_rest) {
    segment.key.position = fmt::format("rest {}", piece.position + 1);
  }
  segment.t_start_s = r.t_s[piece.first];
  segment.t_end_s = r.t_s[piece.last - 1];
  return segment;
}

std::span<const double> part_of(const std::vector<double>& values, Rows rows) {
  return {values.data() + rows.first, rows.last - rows.first};
}

void warn_of_astray(Segmentation& result) {
  const auto astray = std::find_if(result.segments.begin(), result.segments.end(), [](const Segment& segment) {
    return segment.plateau_c && std::abs(segment.temp_c - *segment.plateau_c) > kAstray_c;
  });
  if (astray == result.segments.end()) return;
  result.warnings.push_back(
      fmt::format("the unit's thermometer reads {:.1f} °C at the {:.1f} °C plateau: check the unit of the temperature "
                  "(temp_k for kelvin)",
                  astray->temp_c, *astray->plateau_c));
}

}  // namespace

std::vector<Plateau> find_plateaus(std::span<const double> t_s, std::span<const double> temp_c) {
  const std::vector<ShortMean> means = short_means(t_s, temp_c);
  std::vector<Plateau> still;
  for (std::size_t start = 0; start < means.size();) {
    const std::size_t length = still_length(means, start);
    const bool long_enough = means[start + length - 1].end_s - means[start].start_s >= kShortestPlateau_s;
    if (!long_enough) {
      ++start;
      continue;
    }
    const Plateau found = plateau_of(means, start, length);
    if (!still.empty() && std::abs(still.back().temp_c - found.temp_c) < kSamePlateauLevel_c &&
        follows(t_s, still.back(), found)) {
      const double n = static_cast<double>(still.back().last - still.back().first);
      const double m = static_cast<double>(found.last - found.first);
      still.back().temp_c = (n * still.back().temp_c + m * found.temp_c) / (n + m);
      still.back().last = found.last;
    } else {
      still.push_back(found);
    }
    start += length;
  }
  // Whatever joins the next without a step between, and differs from it, is part of a slow ramp.
  std::vector<Plateau> plateaus;
  for (std::size_t i = 0; i < still.size(); ++i) {
    const bool joins_next = i + 1 < still.size() && follows(t_s, still[i], still[i + 1]);
    const bool joins_previous = i > 0 && follows(t_s, still[i - 1], still[i]);
    if (!joins_next && !joins_previous) plateaus.push_back(still[i]);
  }
  return plateaus;
}

namespace cutting {

double longest_gap_s(std::span<const double> t_s) {
  const std::size_t count = std::min<std::size_t>(t_s.size(), kTimesLooked);
  std::vector<double> intervals;
  for (std::size_t i = 1; i < count; ++i) intervals.push_back(t_s[i] - t_s[i - 1]);
  return std::max(kLongestGap_s, kLongestGapIntervals * (intervals.empty() ? 0.0 : base::median(intervals)));
}

void PieceCutter::close() {
  if (piece_.last > piece_.first) pieces_.push_back(piece_);
  piece_.last = piece_.first;
}

void PieceCutter::add(double t_s, double plateau_c, std::int32_t position, bool soak) {
  const bool usable = position >= 0 && (!with_plateaus_ || (soak && !std::isnan(plateau_c)));
  const bool continues = usable && piece_.last > piece_.first && piece_.position == position &&
                         same_value(piece_.plateau_c, plateau_c) && t_s - last_t_s_ <= longest_gap_s_;
  if (!continues) {
    close();
    piece_ = {row_, row_, plateau_c, position};
  }
  ++row_;
  last_t_s_ = t_s;
  if (usable) piece_.last = row_;
}

std::vector<Piece> PieceCutter::finish() {
  close();
  return std::move(pieces_);
}

std::optional<Visits::Between> Visits::between(const Piece& piece) const {
  if (visit_ < 0 || std::isnan(piece.plateau_c) || !same_value(piece.plateau_c, plateau_c_)) return std::nullopt;
  return Between{previous_last_, piece.first, previous_temp_c_};
}

bool Visits::went_away(std::span<const double> temp_c, double from_c) {
  return std::ranges::any_of(temp_c, [&](double value) { return std::abs(value - from_c) > kExcursion_c; });
}

void Visits::assign(const Piece& piece, Sweep given, bool went_away, Segment& segment) {
  if (visit_ < 0 || !same_value(piece.plateau_c, plateau_c_) || went_away) {
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

double plausible_step(Sensor sensor, double step) {
  const double coarsest = is_gyro(sensor) ? kCoarsestGyro_dps / printed_per_si(sensor) : kCoarsestAccel_mps2;
  return step <= coarsest ? step : 0.0;
}

/// Least-squares mean and slope of a temperature over rows; NaN mean where there is no value.
Line SegmentMaker::line(std::span<const double> t_s, std::span<const double> temp_c) {
  minutes_.resize(t_s.size());
  minutes_since(t_s, t_s.front(), minutes_);
  if (!has_gap(temp_c)) return fit_line(minutes_, temp_c);
  values_.clear();
  for (std::size_t i = 0; i < temp_c.size(); ++i) {
    if (std::isnan(temp_c[i])) continue;
    minutes_[values_.size()] = minutes_[i];
    values_.push_back(temp_c[i]);
  }
  Line line = fit_line(std::span(minutes_).first(values_.size()), values_);
  if (values_.empty()) line.mean_y = kNone;
  return line;
}

/// Mean of each sensor's own thermometer over the rows, `temp_c` where it has none or it gave no value.
std::array<double, kSensorCount> SegmentMaker::sensor_temperatures(const Recording& r, Rows rows, double temp_c) {
  std::array<double, kSensorCount> temps_c;
  temps_c.fill(temp_c);
  for (std::size_t s = 0; s < kSensorCount; ++s) {
    if (r.sensor_temp_c[s].empty()) continue;
    const double own = line(part_of(r.t_s, rows), part_of(r.sensor_temp_c[s], rows)).mean_y;
    if (!std::isnan(own)) temps_c[s] = own;
  }
  return temps_c;
}

void SegmentMaker::make_blocks(const Recording& r, const Piece& piece, double length_s, Segment& segment,
                               Place& place) {
  const double total_s = r.t_s[piece.last - 1] - r.t_s[piece.first];
  Rows rows{piece.first, piece.first};
  for (; rows.first < piece.last; rows.first = rows.last) {
    rows.last = end_of_block(r, piece, rows.first, length_s);
    const double covered_s = r.t_s[rows.last - 1] - r.t_s[rows.first];
    // A short rest would be a block with a far larger variance than its neighbours.
    if (covered_s < 0.5 * length_s && total_s >= length_s) continue;
    const Line temp = line(part_of(r.t_s, rows), part_of(r.temp_c, rows));
    if (std::isnan(temp.mean_y)) continue;
    place.blocks.push_back(rows);
    segment.blocks.push_back({0.5 * (r.t_s[rows.first] + r.t_s[rows.last - 1]),
                              std::min(length_s, std::max(covered_s, 0.0)),
                              temp.mean_y,
                              temp.slope,
                              sensor_temperatures(r, rows, temp.mean_y),
                              {}});
  }
}

std::optional<Segment> SegmentMaker::make(const Recording& r, const Piece& piece, bool with_plateaus, bool at_rest,
                                          Place& place) {
  place = {{piece.first, piece.last}, {}, false};
  const Line temp = line(part_of(r.t_s, place.rows), part_of(r.temp_c, place.rows));
  if (std::isnan(temp.mean_y)) return std::nullopt;
  Segment segment = identified(r, piece, with_plateaus, at_rest);
  segment.temp_c = temp.mean_y;
  segment.temp_rate_kpmin = temp.slope;
  segment.sensor_temp_c = sensor_temperatures(r, place.rows, segment.temp_c);
  make_blocks(r, piece, with_plateaus ? kBlock_s : kBlockWithoutPlateau_s, segment, place);
  place.temp_gaps = has_gap(part_of(r.temp_c, place.rows));
  return segment;
}

/// A sample at an unknown temperature says nothing of a thermal curve. `gaps`: whether there may be such.
SensorStatistics SegmentMaker::describe(std::span<const double> samples, std::span<const double> temp_c, Rows rows,
                                        bool gaps, double step) {
  const auto own = samples.subspan(rows.first, rows.last - rows.first);
  if (!gaps) return calib::describe(own, step);
  scratch_.assign(own.begin(), own.end());
  for (std::size_t i = 0; i < scratch_.size(); ++i) {
    if (std::isnan(temp_c[rows.first + i])) scratch_[i] = kNone;
  }
  return calib::describe(scratch_, step);
}

void SegmentMaker::describe(const Recording& r, const Place& place, Sensor sensor, std::span<const double> samples,
                            double step, Segment& segment) {
  const std::size_t s = index_of(sensor);
  const bool own_thermometer = !r.sensor_temp_c[s].empty();
  const std::vector<double>& temp_c = own_thermometer ? r.sensor_temp_c[s] : r.temp_c;
  const bool gaps = own_thermometer || place.temp_gaps;
  segment.sensor[s] = describe(samples, temp_c, place.rows, gaps, step);
  for (std::size_t b = 0; b < place.blocks.size(); ++b) {
    segment.blocks[b].sensor[s] = describe(samples, temp_c, place.blocks[b], gaps, step);
  }
}

void add_warnings(Segmentation& result, std::size_t without_temperature) {
  warn_of_astray(result);
  if (result.segments.empty()) {
    result.warnings.emplace_back(
        "no segment was found: all rows are of ramps or moves, so that no fit can use this run");
  }
  if (without_temperature > 0) {
    result.warnings.push_back(
        fmt::format("{} segments without a value of the thermometer were left out", without_temperature));
  }
}

}  // namespace cutting

struct Segmenter::Impl {
  Impl(const Recording& recording, std::span<const Standstill> found) : r(recording), standstills(found) {}

  void cut_into_segments();

  const Recording& r;
  std::span<const Standstill> standstills;  ///< used in cut_into_segments() only
  Segmentation result;
  std::vector<cutting::Place> places;  ///< of each segment
  cutting::SegmentMaker maker;
};

void Segmenter::Impl::cut_into_segments() {
  const bool given = has_value(r.plateau_c);
  const bool at_rest = show_attitudes(standstills);
  const std::vector<double> found = given || at_rest ? std::vector<double>() : plateaus_without_set_points(r);
  const std::vector<double>& plateau_c = given ? r.plateau_c : found;
  const bool with_plateaus = given || at_rest || has_value(found);
  cutting::Visits visits;
  std::size_t without_temperature = 0;
  const auto pieces = at_rest ? standstill_pieces(r, standstills) : cut_pieces(r, plateau_c, with_plateaus);
  for (const Piece& piece : pieces) {
    cutting::Place place;
    auto segment = maker.make(r, piece, with_plateaus, at_rest, place);
    if (!segment) {
      ++without_temperature;
      continue;
    }
    const auto between = visits.between(piece);
    const bool away =
        between && cutting::Visits::went_away(part_of(r.temp_c, {between->first, between->last}), between->temp_c);
    visits.assign(piece, r.sweep.empty() ? Sweep::unknown : r.sweep[piece.first], away, *segment);
    result.segments.push_back(*std::move(segment));
    places.push_back(std::move(place));
  }
  if (!with_plateaus) {
    result.warnings.emplace_back(
        "no plateau was given and none found in the temperature: 30-second blocks are used instead");
  }
  cutting::add_warnings(result, without_temperature);
}

base::Result<Segmenter> Segmenter::begin(const Recording& recording, std::span<const Standstill> standstills) {
  if (recording.rows() == 0) return base::bad_input("the recording has no rows", recording.unit);
  auto impl = std::make_unique<Impl>(recording, standstills);
  impl->cut_into_segments();
  return Segmenter(std::move(impl));
}

Segmenter::Segmenter(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Segmenter::Segmenter(Segmenter&&) noexcept = default;
Segmenter& Segmenter::operator=(Segmenter&&) noexcept = default;
Segmenter::~Segmenter() = default;

void Segmenter::describe(Sensor sensor, std::span<const double> samples) {
  const double step = cutting::plausible_step(sensor, output_step(samples));
  for (std::size_t i = 0; i < impl_->places.size(); ++i) {
    impl_->maker.describe(impl_->r, impl_->places[i], sensor, samples, step, impl_->result.segments[i]);
  }
}

Segmentation& Segmenter::result() { return impl_->result; }

base::Result<Segmentation> segment(const Recording& recording) {
  std::vector<Standstill> standstills;
  if (may_be_bench_session(recording)) {
    StandstillFinder finder(recording.t_s);
    for (const Sensor sensor : kSensors) {
      const std::vector<double>& samples = recording.sensor[index_of(sensor)];
      if (!samples.empty()) finder.add(sensor, samples);
    }
    standstills = finder.find();
  }
  auto segmenter = Segmenter::begin(recording, standstills);
  if (!segmenter) return base::forward_error(segmenter);
  for (const Sensor sensor : kSensors) {
    const std::vector<double>& samples = recording.sensor[index_of(sensor)];
    if (!samples.empty()) segmenter->describe(sensor, samples);
  }
  return std::move(segmenter->result());
}

}  // namespace soak::calib
