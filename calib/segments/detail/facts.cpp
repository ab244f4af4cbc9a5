// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/statistics.h"
#include "calib/segments/detail/scan.h"
#include "calib/segments/detail/view.h"

namespace soak::calib::gate {
namespace {

constexpr std::size_t kStretch = 20;               ///< samples, or intervals between them
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
constexpr double kOffLattice = 0.02;
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
  for (std::size_t first = 0; first + kStretch <= intervals.size(); first += kStretch) {
    means.push_back(mean_of({intervals.data() + first, kStretch}));
  }
  if (means.empty()) return middle_s;
  const double mean_s = base::median(means);
  return mean_s > 2.0 * middle_s ? mean_s : middle_s;
}

/// Gathers intervals of times, segment by segment.
class Intervals {
 public:
  void add(std::span<const double> times) {
    for (std::size_t i = 1; i < times.size() && intervals_.size() < kIntervalsLooked; ++i) {
      intervals_.push_back(times[i] - times[i - 1]);
    }
  }
  [[nodiscard]] double usual_s() const { return usual_interval_s(intervals_); }

 private:
  std::vector<double> intervals_;
};

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
    const std::size_t length = std::min(kStretch, x.size());
    if (length < 5) return;
    const std::size_t stride = length * (x.size() / (length * kStretchesPerSegment) + 1);
    for (std::size_t first = 0; first + length <= x.size(); first += stride) {
      const auto stretch = x.subspan(first, length);
      double low = stretch.front();
      double high = stretch.front();
      for (const double value : stretch) {
        low = std::min(low, value);
        high = std::max(high, value);
      }
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

/// Jumps of a thermometer between neighbouring rows.
std::vector<double> jumps_of(std::span<const double> t_s, const std::vector<double>& temp_c) {
  std::vector<double> jumps;
  for (std::size_t i = 1; i < temp_c.size() && jumps.size() < kJumpsLooked; ++i) {
    const double jump = std::abs(temp_c[i] - temp_c[i - 1]);
    if (jump > 0.0 && jump <= kLargestJump_c && t_s[i] - t_s[i - 1] <= kLongestJump_s) jumps.push_back(jump);
  }
  return jumps;
}

/// Step of a thermometer that only ever jumps by multiples of one number; 0 for any other.
double lattice_step(std::span<const double> t_s, const std::vector<double>& temp_c) {
  const std::vector<double> jumps = jumps_of(t_s, temp_c);
  if (jumps.size() < kFewestJumps) return 0.0;
  const double step = *std::min_element(jumps.begin(), jumps.end());
  const bool lattice = std::all_of(jumps.begin(), jumps.end(), [&](double jump) {
    return std::abs(jump / step - std::round(jump / step)) < kOffLattice;
  });
  return lattice ? step : 0.0;
}

}  // namespace

double row_interval_s(const Recording& recording, std::span<const SegmentState> states) {
  Intervals rows;
  for (const SegmentState& state : states) {
    rows.add({recording.t_s.data() + state.first, state.last - state.first});
  }
  return rows.usual_s();
}

SensorFacts sensor_facts(std::span<const Present> presents, double row_interval_s) {
  Gatherer gatherer;
  Intervals intervals;
  bool complete = true;
  for (const Present& present : presents) {
    gatherer.add(present);
    intervals.add(present.t_s());
    complete = complete && present.complete();
  }
  SensorFacts facts = gatherer.facts();
  facts.interval_s = complete ? row_interval_s : intervals.usual_s();
  return facts;
}

Facts run_facts(const Recording& recording, std::span<const Segment> segments) {
  Facts facts;
  for (const Sensor sensor : kSensors) {
    const std::size_t s = index_of(sensor);
    facts.sensor_temp_step_c[s] = lattice_step(recording.t_s, recording.sensor_temp_c[s]);
  }
  for (const Segment& segment : segments) {
    facts.positions_differ = facts.positions_differ || segment.key.position != segments.front().key.position;
    facts.plateaus_differ = facts.plateaus_differ || segment.plateau_c != segments.front().plateau_c;
  }
  facts.temp_step_c = lattice_step(recording.t_s, recording.temp_c);
  return facts;
}

}  // namespace soak::calib::gate
