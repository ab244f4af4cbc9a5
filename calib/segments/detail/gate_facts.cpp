// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "base/statistics.h"
#include "calib/segments/detail/gate.h"
#include "calib/segments/detail/sample_scan.h"

namespace soak::calib::gate {
namespace {

// The level of a sensor from stretch to stretch.

constexpr double kStretch_s = 10.0;
constexpr std::size_t kFewestStretches = 6;
constexpr std::size_t kSamplesPerStretch = 100;  ///< whose median stands for all
constexpr double kSigmaPerMad = 1.4826;          ///< of a Gaussian
constexpr double kLongestBurst_s = 0.25;
constexpr std::size_t kLongestBurstRows = 3;

std::vector<Hit> hits_in(std::span<const double> values, const Stretch& stretch, double middle, double limit) {
  std::vector<Hit> hits;
  for (std::size_t row = stretch.first; row < stretch.last; ++row) {
    if (std::abs(values[row] - middle) > limit) hits.push_back({row, values[row] - middle});
  }
  return hits;
}

/// Sum and count of the residuals of the hits that belong to short bursts.
struct Bursts {
  double sum = 0.0;
  double count = 0.0;
};

Bursts short_bursts(std::span<const double> t_s, std::span<const Hit> hits) {
  Bursts bursts;
  for (std::size_t first = 0; first < hits.size();) {
    std::size_t last = first + 1;
    double sum = hits[first].residual;
    for (; last < hits.size(); ++last) {
      const bool next_row = hits[last].row == hits[last - 1].row + 1;
      if (!next_row && t_s[hits[last].row] - t_s[hits[last - 1].row] > kBurstGap_s) break;
      sum += hits[last].residual;
    }
    const bool brief = t_s[hits[last - 1].row] - t_s[hits[first].row] <= kLongestBurst_s;
    if (brief || last - first <= kLongestBurstRows) {
      bursts.sum += sum;
      bursts.count += static_cast<double>(last - first);
    }
    first = last;
  }
  return bursts;
}

double count_present(std::span<const double> values) {
  return static_cast<double>(std::count_if(values.begin(), values.end(), [](double v) { return !std::isnan(v); }));
}

double sum_present(std::span<const double> values, double middle) {
  double sum = 0.0;
  for (const double v : values) sum += std::isnan(v) ? 0.0 : v - middle;
  return sum;
}

/// Mean of a stretch less short bursts; its hits are appended to `levels`.
double mean_in(std::span<const double> t_s, std::span<const double> values, const Stretch& stretch, double middle,
               double limit, Levels& levels) {
  if (std::isnan(middle)) return middle;
  const auto part = values.subspan(stretch.first, stretch.last - stretch.first);
  const Deviation deviation = deviation_from(part, middle);
  const bool gaps = std::isnan(deviation.sum);
  double sum = gaps ? sum_present(part, middle) : deviation.sum;
  double count = gaps ? count_present(part) : static_cast<double>(part.size());
  if (deviation.peak > limit) {
    const std::vector<Hit> hits = hits_in(values, stretch, middle, limit);
    const Bursts bursts = short_bursts(t_s, hits);
    sum -= bursts.sum;
    count -= bursts.count;
    levels.hits.insert(levels.hits.end(), hits.begin(), hits.end());
  }
  return count > 0.0 ? middle + sum / count : middle;
}

// What a whole recording shows of a sensor.

constexpr std::size_t kFactStretch = 20;           ///< samples, or intervals between them
constexpr std::size_t kStretchesPerSegment = 500;  ///< whose noise stands for all
constexpr double kRareRepeats = 0.005;             ///< share up to which 99 % of the runs are single samples
constexpr std::size_t kIntervalsLooked = 100000;
constexpr std::size_t kLongestRunCounted = 4096;
constexpr double kUsualRunShare = 0.99;
constexpr double kManyCodes = 1.5;  ///< steps between extremes: three codes or more
/// A thermometer that stands in thermal mass cannot jump further between two samples; a larger jump is a gap.
constexpr double kLargestJump_c = 3.0;
constexpr double kLongestJump_s = 10.0;
constexpr int kFewestJumps = 3;
constexpr double kOffStep = 0.02;
constexpr std::size_t kJumpsLooked = 10000;

/// Standard deviation of white noise from the differences of neighbours, which pass over drift; 0 for a constant.
double noise_of(std::span<const double> x) {
  double sum = 0.0;
  double squares = 0.0;
  for (std::size_t i = 1; i < x.size(); ++i) {
    const double d = x[i] - x[i - 1];
    sum += d;
    squares += d * d;
  }
  const auto n = static_cast<double>(x.size() - 1);
  return std::sqrt(std::max(0.0, (squares - sum * sum / n) / (n - 1.0))) / std::numbers::sqrt2;
}

/// The median of intervals; but where a typical stretch seems to have lost more than half of its samples, they come in
/// bursts, and the stretch's mean stands.
double usual_interval_s(const std::vector<double>& intervals) {
  if (intervals.empty()) return 0.0;
  const double middle_s = base::median(intervals);
  std::vector<double> means;
  for (std::size_t first = 0; first + kFactStretch <= intervals.size(); first += kFactStretch) {
    means.push_back(mean_of({intervals.data() + first, kFactStretch}));
  }
  if (means.empty()) return middle_s;
  const double mean_s = base::median(means);
  return mean_s > 2.0 * middle_s ? mean_s : middle_s;
}

/// Gathers one sensor's facts segment by segment.
class Gatherer {
 public:
  void add(const Present& present) {
    const std::span<const double> x = present.values();
    if (x.empty()) return;
    first_ = any_ ? first_ : x.front();
    any_ = true;
    add_noise(x);
    add_runs(x);
  }

  /// All but the interval.
  [[nodiscard]] SensorFacts facts() const {
    SensorFacts facts;
    facts.step = step_;
    facts.noise = noises_.empty() ? 0.0 : base::median(noises_);
    facts.many_codes =
        2 * std::count_if(ranges_.begin(), ranges_.end(), [&](double range) { return range > kManyCodes * step_; }) >=
        static_cast<std::ptrdiff_t>(ranges_.size());
    facts.usual_run = usual_run();
    facts.one_number = any_ && !varies_;
    return facts;
  }

 private:
  void add_noise(std::span<const double> x) {
    const std::size_t length = std::min(kFactStretch, x.size());
    if (length < 5) return;
    const std::size_t stride = length * (x.size() / (length * kStretchesPerSegment) + 1);
    for (std::size_t first = 0; first + length <= x.size(); first += stride) {
      const auto stretch = x.subspan(first, length);
      const auto [low, high] = std::ranges::minmax(stretch);
      if (low == high) continue;
      noises_.push_back(noise_of(stretch));
      ranges_.push_back(high - low);
    }
  }

  void add_runs(std::span<const double> x) {
    const Changes changes = changes_of(x);
    if (changes.smallest > 0.0) step_ = step_ > 0.0 ? std::min(step_, changes.smallest) : changes.smallest;
    varies_ = varies_ || step_ > 0.0 || x.front() != first_;
    if (static_cast<double>(changes.none) <= kRareRepeats * static_cast<double>(x.size())) {
      runs_[1] += x.size();
      return;
    }
    for (std::size_t first = 0; first < x.size();) {
      std::size_t last = first + 1;
      while (last < x.size() && x[last] == x[first]) ++last;
      ++runs_[std::min(last - first, kLongestRunCounted)];
      first = last;
    }
  }

  [[nodiscard]] std::size_t usual_run() const {
    double total = 0.0;
    for (const std::size_t count : runs_) total += static_cast<double>(count);
    double below = 0.0;
    for (std::size_t length = 1; length < runs_.size(); ++length) {
      below += static_cast<double>(runs_[length]);
      if (below >= kUsualRunShare * total) return length;
    }
    return 0;
  }

  bool any_ = false;
  bool varies_ = false;
  double first_ = 0.0;
  double step_ = 0.0;
  std::vector<double> noises_;
  std::vector<double> ranges_;
  std::vector<std::size_t> runs_ = std::vector<std::size_t>(kLongestRunCounted + 1, 0);
};

}  // namespace

void Intervals::add(std::span<const double> times) {
  for (std::size_t i = 1; i < times.size() && intervals_.size() < kIntervalsLooked; ++i) {
    intervals_.push_back(times[i] - times[i - 1]);
  }
}

double Intervals::usual_s() const { return usual_interval_s(intervals_); }

void ThermometerJumps::add(std::span<const double> t_s, std::span<const double> temp_c) {
  for (std::size_t i = 0; i < temp_c.size() && jumps_.size() < kJumpsLooked; ++i) {
    if (last_) {
      const double jump = std::abs(temp_c[i] - last_->second);
      if (jump > 0.0 && jump <= kLargestJump_c && t_s[i] - last_->first <= kLongestJump_s) jumps_.push_back(jump);
    }
    last_ = {t_s[i], temp_c[i]};
  }
}

double ThermometerJumps::step_c() const {
  if (jumps_.size() < kFewestJumps) return 0.0;
  const double step = *std::min_element(jumps_.begin(), jumps_.end());
  const bool lattice = std::all_of(jumps_.begin(), jumps_.end(), [&](double jump) {
    return std::abs(jump / step - std::round(jump / step)) < kOffStep;
  });
  return lattice ? step : 0.0;
}

struct FactGatherer::Impl {
  Gatherer gatherer;
  Intervals intervals;
  bool complete = true;
};

FactGatherer::FactGatherer() : impl_(std::make_unique<Impl>()) {}
FactGatherer::FactGatherer(FactGatherer&&) noexcept = default;
FactGatherer& FactGatherer::operator=(FactGatherer&&) noexcept = default;
FactGatherer::~FactGatherer() = default;

void FactGatherer::add(const Present& present) {
  impl_->gatherer.add(present);
  impl_->intervals.add(present.t_s());
  impl_->complete = impl_->complete && present.complete();
}

SensorFacts FactGatherer::facts(double row_interval_s) const {
  SensorFacts facts = impl_->gatherer.facts();
  facts.interval_s = impl_->complete ? row_interval_s : impl_->intervals.usual_s();
  return facts;
}

Present::Present(std::span<const double> t_s, std::span<const double> values, bool complete)
    : values_(values), t_s_(t_s) {
  // One NaN makes the sum NaN; infinities may too, and then there is nothing to leave out.
  if (complete || !std::isnan(deviation_from(values, 0.0).sum)) return;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (std::isnan(values[i])) continue;
    own_values_.push_back(values[i]);
    own_t_s_.push_back(t_s[i]);
  }
  complete_ = own_values_.size() == values.size();
  values_ = own_values_;
  t_s_ = own_t_s_;
}

std::pair<std::size_t, std::size_t> rows_of(const Recording& recording, const Segment& segment) {
  const auto& t_s = recording.t_s;
  const auto first = std::lower_bound(t_s.begin(), t_s.end(), segment.t_start_s);
  const auto last = std::upper_bound(first, t_s.end(), segment.t_end_s);
  return {static_cast<std::size_t>(first - t_s.begin()), static_cast<std::size_t>(last - t_s.begin())};
}

bool rejected_as(const std::vector<Finding>& findings, std::string_view code) {
  return std::any_of(findings.begin(), findings.end(), [&](const Finding& finding) {
    return finding.code == code && finding.severity == Severity::reject;
  });
}

double mean_of(std::span<const double> values) {
  const double sum_of_all = deviation_from(values, 0.0).sum;
  if (!std::isnan(sum_of_all) && !values.empty()) return sum_of_all / static_cast<double>(values.size());
  double sum = 0.0;
  double count = 0.0;
  for (const double value : values) {
    if (std::isnan(value)) continue;
    sum += value;
    count += 1.0;
  }
  return count > 0.0 ? sum / count : std::numeric_limits<double>::quiet_NaN();
}

double step_of(const View& view, Sensor sensor) {
  const double stated = is_gyro(sensor) ? view.type.gyro_lsb_dps.value_or(0.0) / printed_per_si(sensor)
                                        : view.type.accel_lsb_mps2.value_or(0.0);
  return std::max(stated, view.facts_of(sensor).step);
}

std::vector<Stretch> stretches(std::span<const double> t_s) {
  const std::size_t rows = t_s.size();
  if (rows < 2 * kFewestStretches) return {};
  const double total_s = t_s.back() - t_s.front();
  const auto wanted = static_cast<std::size_t>(total_s / kStretch_s);
  const std::size_t count = std::clamp(wanted, kFewestStretches, rows / 2);
  const double row_s = total_s / static_cast<double>(rows - 1);
  std::vector<Stretch> result;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t first = i * rows / count;
    const std::size_t last = (i + 1) * rows / count;
    result.push_back({first, last, t_s[last - 1] - t_s[first] + row_s});
  }
  return result;
}

Levels levels_of(std::span<const double> t_s, std::span<const double> values, std::span<const Stretch> stretches,
                 double least_sigma, double sigmas) {
  Levels levels;
  std::vector<double> middles;
  std::vector<double> sizes;
  for (const Stretch& stretch : stretches) {
    const std::vector<double> samples =
        thinned(values.subspan(stretch.first, stretch.last - stretch.first), kSamplesPerStretch);
    middles.push_back(base::median(samples));
    for (const double v : samples) sizes.push_back(std::abs(v - middles.back()));
  }
  levels.sigma = sizes.empty() ? 0.0 : std::max(kSigmaPerMad * base::median(sizes), least_sigma);
  const double limit = levels.sigma > 0.0 ? sigmas * levels.sigma : std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < stretches.size(); ++i) {
    levels.mean.push_back(mean_in(t_s, values, stretches[i], middles[i], limit, levels));
  }
  return levels;
}

double row_interval_s(const Recording& recording, std::span<const SegmentState> states) {
  Intervals rows;
  for (const SegmentState& state : states) {
    rows.add({recording.t_s.data() + state.first, state.last - state.first});
  }
  return rows.usual_s();
}

SensorFacts sensor_facts(std::span<const Present> presents, double row_interval_s) {
  FactGatherer gatherer;
  for (const Present& present : presents) gatherer.add(present);
  return gatherer.facts(row_interval_s);
}

void note_differences(std::span<const Segment> segments, Facts& facts) {
  for (const Segment& segment : segments) {
    facts.positions_differ = facts.positions_differ || segment.key.position != segments.front().key.position;
    facts.plateaus_differ = facts.plateaus_differ || segment.plateau_c != segments.front().plateau_c;
  }
}

Facts run_facts(const Recording& recording, std::span<const Segment> segments) {
  const auto step_c = [&](const std::vector<double>& temp_c) {
    ThermometerJumps jumps;
    jumps.add(recording.t_s, temp_c);
    return jumps.step_c();
  };
  Facts facts;
  for (const Sensor sensor : kSensors) {
    const std::size_t s = index_of(sensor);
    facts.sensor_temp_step_c[s] = step_c(recording.sensor_temp_c[s]);
  }
  note_differences(segments, facts);
  facts.temp_step_c = step_c(recording.temp_c);
  return facts;
}

}  // namespace soak::calib::gate
