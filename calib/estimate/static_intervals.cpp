// SPDX-License-Identifier: Apache-2.0
#include "calib/estimate/multi_position.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "calib/segments/statistics.h"

namespace soak::calib {
namespace {

/// Running sums of samples about the first one, so that differences of large sums keep their digits.
class SampleSpread {
 public:
  explicit SampleSpread(std::span<const Vector3> samples) : sums_(samples.size() + 1) {
    for (std::size_t n = 0; n < samples.size(); ++n) {
      sums_[n + 1] = sums_[n];
      for (std::size_t i = 0; i < 3; ++i) {
        const double x = samples[n][i] - samples[0][i];
        sums_[n + 1].x[i] += x;
        sums_[n + 1].squares += x * x;
      }
    }
  }

  /// v_x + v_y + v_z over samples [first, last).
  [[nodiscard]] double variance(std::size_t first, std::size_t last) const {
    const auto count = static_cast<double>(last - first);
    double squares = sums_[last].squares - sums_[first].squares;
    for (std::size_t i = 0; i < 3; ++i) {
      const double sum = sums_[last].x[i] - sums_[first].x[i];
      squares -= sum * sum / count;
    }
    return std::max(0.0, squares / (count - 1.0));
  }

 private:
  struct Sums {
    Vector3 x{};
    double squares = 0.0;
  };
  std::vector<Sums> sums_;
};

base::Status check_samples(std::span<const Vector3> samples, const StaticIntervalOptions& options) {
  if (options.window < 2 || options.initial < options.window || options.shortest < 1 || !(options.factor > 1.0)) {
    return base::bad_input(
        fmt::format("static intervals: window {} must be 2 or more and at most the initial stretch {}, the shortest "
                    "interval {} 1 or more, the factor {} above 1",
                    options.window, options.initial, options.shortest, options.factor));
  }
  if (samples.size() < options.initial) {
    return base::bad_input(
        fmt::format("{} samples are fewer than the initial stretch at rest of {}", samples.size(), options.initial));
  }
  for (std::size_t n = 0; n < samples.size(); ++n) {
    for (const double x : samples[n]) {
      if (!std::isfinite(x)) return base::bad_input("samples must be finite", fmt::format("sample {}", n + 1));
    }
  }
  return {};
}

}  // namespace

base::Result<std::vector<StaticInterval>> find_static_intervals(std::span<const Vector3> samples,
                                                                const StaticIntervalOptions& options) {
  if (const auto sound = check_samples(samples, options); !sound) return base::forward_error(sound);
  const SampleSpread spread(samples);
  const double at_rest = spread.variance(0, options.initial);
  if (!(at_rest > 0.0)) {
    return base::bad_input("the initial stretch shows no noise: samples that never change give no threshold");
  }
  const double threshold = options.factor * options.factor * at_rest;
  std::vector<StaticInterval> intervals;
  bool resting = false;
  for (std::size_t first = 0; first + options.window <= samples.size(); ++first) {
    const bool quiet = spread.variance(first, first + options.window) < threshold;
    const std::size_t centre = first + options.window / 2;
    if (quiet && !resting) intervals.push_back({centre, centre});
    if (quiet) intervals.back().last = centre + 1;
    resting = quiet;
  }
  std::erase_if(intervals, [&](const StaticInterval& i) { return i.last - i.first < options.shortest; });
  return intervals;
}

std::vector<AttitudeMean> attitude_means(std::span<const Vector3> samples, std::span<const StaticInterval> intervals) {
  std::vector<AttitudeMean> attitudes;
  for (const StaticInterval& interval : intervals) {
    AttitudeMean attitude;
    for (std::size_t i = 0; i < 3; ++i) {
      std::vector<double> axis;
      axis.reserve(interval.last - interval.first);
      for (std::size_t n = interval.first; n < interval.last; ++n) axis.push_back(samples[n][i]);
      const SensorStatistics statistics = describe(axis);
      attitude.mean[i] = statistics.mean;
      attitude.standard_error[i] = statistics.standard_error;
    }
    attitudes.push_back(attitude);
  }
  return attitudes;
}

}  // namespace soak::calib
