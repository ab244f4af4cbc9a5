// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/statistics.h"
#include "calib/gate/view.h"

namespace soak::calib::gate {
namespace {

constexpr std::size_t kStretch = 20;  ///< samples, or intervals between them  ///< samples
constexpr std::size_t kIntervalsLooked = 100000;
constexpr std::size_t kLongestRunCounted = 4096;
constexpr double kUsualRunShare = 0.99;
/// A thermometer that stands in thermal mass cannot jump further between two samples; a larger jump is a gap.
constexpr double kLargestJump_c = 3.0;
constexpr double kLongestJump_s = 10.0;
constexpr int kFewestJumps = 3;
constexpr double kOffLattice = 0.02;

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

/// Gathers one sensor's facts segment by segment.
class Gatherer {
 public:
  void add(std::span<const double> t_s, std::span<const double> values) {
    const std::vector<double> x = present(values);
    if (x.empty()) return;
    first_ = any_ ? first_ : x.front();
    any_ = true;
    add_intervals(times_of(t_s, values));
    add_noise(x);
    add_runs(x);
  }

  [[nodiscard]] SensorFacts facts() {
    SensorFacts facts;
    facts.interval_s = usual_interval_s();
    facts.step = step_;
    facts.noise = noises_.empty() ? 0.0 : base::median(noises_);
    facts.usual_run = usual_run();
    facts.one_number = any_ && !varies_;
    return facts;
  }

 private:
  void add_intervals(const std::vector<double>& times) {
    for (std::size_t i = 1; i < times.size() && intervals_.size() < kIntervalsLooked; ++i) {
      intervals_.push_back(times[i] - times[i - 1]);
    }
  }

  /// The median; but where a typical stretch seems to have lost more than half of its samples, they come in bursts, and
  /// the stretch's mean stands.
  [[nodiscard]] double usual_interval_s() const {
    if (intervals_.empty()) return 0.0;
    const double middle_s = base::median(intervals_);
    std::vector<double> means;
    for (std::size_t first = 0; first + kStretch <= intervals_.size(); first += kStretch) {
      means.push_back(mean_of({intervals_.data() + first, kStretch}));
    }
    if (means.empty()) return middle_s;
    const double mean_s = base::median(means);
    return mean_s > 2.0 * middle_s ? mean_s : middle_s;
  }

  void add_noise(std::span<const double> x) {
    const std::size_t length = std::min(kStretch, x.size());
    if (length < 5) return;
    for (std::size_t first = 0; first + length <= x.size(); first += length) {
      const auto stretch = x.subspan(first, length);
      if (std::adjacent_find(stretch.begin(), stretch.end(), std::not_equal_to<>()) == stretch.end()) continue;
      noises_.push_back(noise_of(stretch));
    }
  }

  void add_runs(std::span<const double> x) {
    std::size_t run = 1;
    for (std::size_t i = 1; i <= x.size(); ++i) {
      if (i < x.size() && x[i] == x[i - 1]) {
        ++run;
        continue;
      }
      ++runs_[std::min(run, kLongestRunCounted)];
      run = 1;
      if (i == x.size()) break;
      const double difference = std::abs(x[i] - x[i - 1]);
      step_ = step_ > 0.0 ? std::min(step_, difference) : difference;
    }
    varies_ = varies_ || step_ > 0.0 || x.front() != first_;
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
  std::vector<double> intervals_;
  std::vector<double> noises_;
  std::vector<std::size_t> runs_ = std::vector<std::size_t>(kLongestRunCounted + 1, 0);
};

/// Jumps of a thermometer between neighbouring rows.
std::vector<double> jumps_of(std::span<const double> t_s, const std::vector<double>& temp_c) {
  std::vector<double> jumps;
  for (std::size_t i = 1; i < temp_c.size(); ++i) {
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

Facts collect_facts(const Recording& recording, std::span<const Segment> segments) {
  Facts facts;
  for (std::size_t s = 0; s < kSensorCount; ++s) {
    const std::vector<double>& values = recording.sensor[s];
    facts.sensor_temp_step_c[s] = lattice_step(recording.t_s, recording.sensor_temp_c[s]);
    if (values.empty()) continue;
    Gatherer gatherer;
    for (const Segment& segment : segments) {
      const auto [first, last] = rows_of(recording, segment);
      gatherer.add({recording.t_s.data() + first, last - first}, {values.data() + first, last - first});
    }
    facts.sensor[s] = gatherer.facts();
  }
  facts.circumstances_differ = std::any_of(segments.begin(), segments.end(), [&](const Segment& segment) {
    return segment.key.position != segments.front().key.position || segment.plateau_c != segments.front().plateau_c;
  });
  facts.temp_step_c = lattice_step(recording.t_s, recording.temp_c);
  return facts;
}

}  // namespace soak::calib::gate
