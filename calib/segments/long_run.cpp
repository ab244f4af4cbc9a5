// SPDX-License-Identifier: Apache-2.0
#include "calib/segments/long_run.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <utility>

#include "calib/segments/detail/gate.h"
#include "calib/segments/detail/sample_scan.h"
#include "calib/segments/detail/segment_maker.h"

namespace soak::calib {
namespace {

/// Rows that are read at once where nothing else says how many.
constexpr std::size_t kRowsAtOnce = 65536;

/// Passes over a run: where its segments lie, their statistics, their findings. Each holds one segment's rows at most.
class LongRunReader {
 public:
  LongRunReader(RunRows& rows, const UnitType& type, const GateLimits& limits)
      : rows_(rows), type_(type), limits_(limits) {}

  /// False where it needs the whole recording.
  base::Result<bool> find_pieces() {
    const auto gap_s = longest_gap_s();
    if (!gap_s) return base::forward_error(gap_s);
    cutting::PieceCutter cutter(true, *gap_s);
    gate::ThermometerJumps jumps;
    for (std::size_t first = 0; first < rows_.rows(); first += kRowsAtOnce) {
      const auto r = rows_.axes(first, std::min(first + kRowsAtOnce, rows_.rows()));
      if (!r) return base::forward_error(r);
      if (!fits(*r)) return false;
      cut(*r, cutter);
      jumps.add(r->t_s, r->temp_c);
      if (first == 0) begin_s_ = r->t_s.front();
      end_s_ = r->t_s.back();
    }
    facts_.temp_step_c = jumps.step_c();
    pieces_ = cutter.finish();
    return has_plateau_ && !positions_.empty();
  }

  /// Statistics of all segments, and the facts that the findings need.
  base::Status describe(std::string_view visit_channel) {
    if (auto found = find_steps(); !found) return found;
    cutting::Visits visits;
    std::size_t without_temperature = 0;
    std::vector<double> visit_numbers;
    for (const cutting::Piece& piece : pieces_) {
      auto r = rows_.axes(piece.first, piece.last);
      if (!r) return base::forward_error(r);
      cutting::Place place;
      auto segment = maker_.make(*r, local(piece), true, false, place);
      if (!segment) {
        ++without_temperature;
        continue;
      }
      const auto away = went_away(visits.between(piece));
      if (!away) return base::forward_error(away);
      visits.assign(piece, r->sweep.empty() ? Sweep::unknown : r->sweep.front(), *away, *segment);
      if (auto described = describe_sensors(piece, *r, place, *segment); !described) return described;
      row_intervals_.add(r->t_s);
      visit_numbers.push_back(visit_of(*r, visit_channel));
      result_.segments.push_back(*std::move(segment));
      kept_.push_back(piece);
    }
    cutting::add_warnings(result_, without_temperature);
    gate::note_differences(result_.segments, facts_);
    number_visits(visit_numbers, result_.segments);
    return {};
  }

  base::Status examine() {
    for (const Sensor sensor : kSensors) {
      const std::size_t s = index_of(sensor);
      if (rows_.has(sensor)) facts_.sensor[s] = gatherers_[s].facts(row_intervals_.usual_s());
    }
    facts_.attitude = gate::attitude_facts(result_.segments, type_);
    std::vector<std::vector<Finding>> findings(kept_.size());
    for (std::size_t i = 0; i < kept_.size(); ++i) {
      if (auto found = examine_segment(i, findings[i]); !found) return found;
    }
    for (std::size_t i = 0; i < kept_.size(); ++i) result_.segments[i].findings = std::move(findings[i]);
    return {};
  }

  LongRun take() { return {std::move(result_), end_s_ - begin_s_}; }

 private:
  base::Result<double> longest_gap_s() {
    const auto r = rows_.axes(0, std::min(cutting::kTimesLooked, rows_.rows()));
    if (!r) return base::forward_error(r);
    return cutting::longest_gap_s(r->t_s);
  }

  static bool fits(const Recording& r) {
    const auto& own = r.sensor_temp_c;
    return !r.plateau_c.empty() && !r.position.empty() && !r.temp_c.empty() &&
           std::ranges::all_of(own, [](const std::vector<double>& temp_c) { return temp_c.empty(); });
  }

  void cut(const Recording& r, cutting::PieceCutter& cutter) {
    std::vector<std::int32_t> numbers;
    for (const Position& position : r.positions) numbers.push_back(number_of(position));
    for (std::size_t i = 0; i < r.rows(); ++i) {
      const bool soak = r.phase.empty() || r.phase[i] == Phase::soak;
      has_plateau_ = has_plateau_ || !std::isnan(r.plateau_c[i]);
      cutter.add(r.t_s[i], r.plateau_c[i], r.position[i] < 0 ? -1 : numbers[static_cast<std::size_t>(r.position[i])],
                 soak);
    }
  }

  /// A position's number in the whole run.
  std::int32_t number_of(const Position& position) {
    const auto known = std::find(positions_.begin(), positions_.end(), position);
    const auto number = static_cast<std::int32_t>(known - positions_.begin());
    if (known == positions_.end()) positions_.push_back(position);
    return number;
  }

  /// The piece as the rows of its own recording, which has its one position.
  static cutting::Piece local(const cutting::Piece& piece) { return {0, piece.last - piece.first, piece.plateau_c, 0}; }

  base::Status find_steps() {
    for (const Sensor sensor : kSensors) {
      if (!rows_.has(sensor)) continue;
      Thinner thinner(rows_.rows(), kStepSamples);
      for (std::size_t first = 0; first < rows_.rows(); first += kRowsAtOnce) {
        auto read = rows_.samples(sensor, first, std::min(first + kRowsAtOnce, rows_.rows()), samples_);
        if (!read) return read;
        thinner.add(samples_);
      }
      steps_[index_of(sensor)] = cutting::plausible_step(sensor, output_step_of(std::move(thinner.taken())));
    }
    return {};
  }

  base::Result<bool> went_away(const std::optional<cutting::Visits::Between>& between) {
    if (!between) return false;
    for (std::size_t first = between->first; first < between->last; first += kRowsAtOnce) {
      const auto r = rows_.axes(first, std::min(first + kRowsAtOnce, between->last));
      if (!r) return base::forward_error(r);
      if (cutting::Visits::went_away(r->temp_c, between->temp_c)) return true;
    }
    return false;
  }

  base::Status describe_sensors(const cutting::Piece& piece, const Recording& r, const cutting::Place& place,
                                Segment& segment) {
    for (const Sensor sensor : kSensors) {
      if (!rows_.has(sensor)) continue;
      if (auto read = rows_.samples(sensor, piece.first, piece.last, samples_); !read) return read;
      const std::size_t s = index_of(sensor);
      maker_.describe(r, place, sensor, samples_, steps_[s], segment);
      gatherers_[s].add(gate::Present(r.t_s, samples_, segment.sensor[s].count == r.rows()));
    }
    return {};
  }

  static double visit_of(const Recording& r, std::string_view visit_channel) {
    const auto channel = std::ranges::find(r.auxiliary, visit_channel, &AuxiliaryChannel::name);
    return channel == r.auxiliary.end() ? std::numeric_limits<double>::quiet_NaN() : channel->values.front();
  }

  base::Status examine_segment(std::size_t index, std::vector<Finding>& findings) {
    const cutting::Piece& piece = kept_[index];
    const auto r = rows_.axes(piece.first, piece.last);
    if (!r) return base::forward_error(r);
    gate::SegmentState state{0, r->rows(), gate::stretches(r->t_s), {}};
    gate::KnownTimes known;
    const Segment& segment = result_.segments[index];
    const gate::View view{*r, result_.segments, segment, type_, limits_, facts_, state};
    for (const Sensor sensor : kSensors) {
      if (!rows_.has(sensor)) continue;
      if (auto read = rows_.samples(sensor, piece.first, piece.last, samples_); !read) return read;
      const gate::Present present(r->t_s, samples_, segment.sensor[index_of(sensor)].count == r->rows());
      gate::summarise(view, sensor, present, samples_, state, known);
    }
    for (const gate::Check check : gate::kChecks) check(view, findings);
    return {};
  }

  RunRows& rows_;
  UnitType type_;
  GateLimits limits_;
  std::vector<cutting::Piece> pieces_;
  std::vector<cutting::Piece> kept_;  ///< those that are segments
  std::vector<Position> positions_;
  bool has_plateau_ = false;
  double begin_s_ = 0.0;
  double end_s_ = 0.0;
  std::array<double, kSensorCount> steps_{};
  std::array<gate::FactGatherer, kSensorCount> gatherers_;
  gate::Intervals row_intervals_;
  gate::Facts facts_;
  cutting::SegmentMaker maker_;
  Segmentation result_;
  std::vector<double> samples_;
};

}  // namespace

base::Result<std::optional<LongRun>> describe_long_run(RunRows& rows, const UnitType& type,
                                                       std::string_view visit_channel, const GateLimits& limits) {
  if (rows.rows() == 0) return std::nullopt;
  LongRunReader reader(rows, type, limits);
  const auto found = reader.find_pieces();
  if (!found) return base::forward_error(found);
  if (!*found) return std::nullopt;
  if (auto described = reader.describe(visit_channel); !described) return base::forward_error(described);
  if (auto examined = reader.examine(); !examined) return base::forward_error(examined);
  return reader.take();
}

void number_visits(std::span<const double> visits, std::vector<Segment>& segments) {
  std::map<std::pair<std::int32_t, std::string>, std::int32_t> attempts;
  for (std::size_t i = 0; i < segments.size(); ++i) {
    Segment& segment = segments[i];
    if (!std::isnan(visits[i])) segment.key.visit = static_cast<std::int32_t>(visits[i]);
    segment.key.attempt = attempts[{segment.key.visit, segment.key.position}]++;
  }
}

}  // namespace soak::calib
