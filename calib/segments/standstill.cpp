// SPDX-License-Identifier: Apache-2.0
#include "calib/segments/standstill.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/statistics.h"
#include "base/units.h"
#include "calib/segments/statistics.h"

namespace soak::calib {
namespace {

constexpr double kHop_s = 0.1;
constexpr std::size_t kHopsPerWindow = 10;
constexpr double kFewestInWindow = 5.0;  ///< samples of a sensor
constexpr double kSpreadFactor = 3.0;    ///< of the quietest windows' spread up to which the unit rests
constexpr double kQuietest = 0.125;      ///< share of the windows below the one that stands for rest
constexpr double kTurning_dps = 1.0;
constexpr double kTurningSigmas = 6.0;
constexpr double kShortest_s = 1.0;
constexpr double kLongestGap = 2.0;  ///< in nominal windows: a window that lasts longer has a gap

constexpr double kLongestSession_s = 6.0 * 3600.0;
constexpr double kOneTemperature_c = 10.0;
constexpr double kApart_deg = 10.0;
constexpr std::size_t kFewestAttitudes = 3;
constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();

double standstill_interval_s(std::span<const double> t_s) {
  std::vector<double> intervals;
  const std::size_t looked = std::min<std::size_t>(t_s.size(), 10001);
  for (std::size_t i = 1; i < looked; ++i) intervals.push_back(t_s[i] - t_s[i - 1]);
  return intervals.empty() ? kHop_s : base::median(intervals);
}

/// The value that a share of the finite ones lies below; NaN where there is none.
double quantile(std::vector<double> values, double share) {
  std::erase_if(values, [](double v) { return std::isnan(v); });
  if (values.empty()) return kMissing;
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

double cosine(const Vector3& a, const Vector3& b) {
  const double lengths = std::hypot(a[0], a[1], a[2]) * std::hypot(b[0], b[1], b[2]);
  return lengths > 0.0 ? (a[0] * b[0] + a[1] * b[1] + a[2] * b[2]) / lengths : 1.0;
}

}  // namespace

StandstillFinder::StandstillFinder(std::span<const double> t_s)
    : t_s_(t_s),
      rows_per_hop_(std::max<std::size_t>(1, static_cast<std::size_t>(kHop_s / standstill_interval_s(t_s)))) {
  const std::size_t hops = t_s.size() / rows_per_hop_;
  windows_ = hops >= kHopsPerWindow ? hops - kHopsPerWindow + 1 : 0;
}

void StandstillFinder::add(Sensor sensor, std::span<const double> samples) {
  Channel& channel = channels_[index_of(sensor)];
  const auto first = std::ranges::find_if(samples, [](double v) { return !std::isnan(v); });
  if (first == samples.end()) return;
  channel.origin = *first;
  channel.step = output_step(samples);
  channel.sums.assign(samples.size() / rows_per_hop_ + 1, {});
  for (std::size_t hop = 0; hop + 1 < channel.sums.size(); ++hop) {
    Sums sums = channel.sums[hop];
    for (const double sample : samples.subspan(hop * rows_per_hop_, rows_per_hop_)) {
      if (std::isnan(sample)) continue;
      const double x = sample - channel.origin;
      sums.count += 1.0;
      sums.x += x;
      sums.squares += x * x;
    }
    channel.sums[hop + 1] = sums;
  }
}

StandstillFinder::Moments StandstillFinder::moments(const Channel& channel, std::size_t first_hop,
                                                    std::size_t last_hop) const {
  const Sums& begin = channel.sums[first_hop];
  const Sums& end = channel.sums[last_hop];
  const double count = end.count - begin.count;
  if (count < kFewestInWindow) return {kMissing, kMissing};
  const double sum = end.x - begin.x;
  const double squares = end.squares - begin.squares - sum * sum / count;
  return {channel.origin + sum / count, std::max(0.0, squares / (count - 1.0))};
}

/// v_x + v_y + v_z of each window of three sensors; empty where one of them was not recorded.
std::vector<double> StandstillFinder::spreads(std::size_t first_sensor) const {
  std::vector<double> all(windows_, 0.0);
  for (std::size_t s = first_sensor; s < first_sensor + 3; ++s) {
    if (channels_[s].sums.empty()) return {};
    for (std::size_t w = 0; w < windows_; ++w) all[w] += moments(channels_[s], w, w + kHopsPerWindow).variance;
  }
  return all;
}

/// Spread (a variance) up to which three sensors rest. A reading that goes to and fro between two codes has a variance
/// of a quarter of the output step's square, however quiet the rest.
double StandstillFinder::threshold(const std::vector<double>& spreads, std::size_t first_sensor) const {
  double rounding = 0.0;
  for (std::size_t s = first_sensor; s < first_sensor + 3; ++s) rounding += 0.25 * std::pow(channels_[s].step, 2);
  return kSpreadFactor * kSpreadFactor * std::max(rounding, quantile(spreads, kQuietest));
}

/// A steady turn has no more spread than rest: windows in which a gyro is away from its usual reading at rest.
void StandstillFinder::drop_turning(std::vector<bool>& quiet, double gyro_threshold) const {
  for (std::size_t s = 0; s < 3; ++s) {
    const Channel& gyro = channels_[s];
    std::vector<double> means(windows_, kMissing);
    for (std::size_t w = 0; w < windows_; ++w) {
      if (quiet[w]) means[w] = moments(gyro, w, w + kHopsPerWindow).mean;
    }
    const double usual = quantile(means, 0.5);
    const auto samples = static_cast<double>(kHopsPerWindow * rows_per_hop_);
    const double noise = std::sqrt(gyro_threshold / samples) / kSpreadFactor;
    const double limit = kTurning_dps * base::kRadPerDeg + kTurningSigmas * noise;
    for (std::size_t w = 0; w < windows_; ++w) quiet[w] = quiet[w] && std::abs(means[w] - usual) <= limit;
  }
}

std::vector<Standstill> StandstillFinder::collect(const std::vector<bool>& quiet) const {
  std::vector<Standstill> found;
  for (std::size_t w = 0; w < windows_; ++w) {
    if (!quiet[w]) continue;
    std::size_t end = w;
    while (end < windows_ && quiet[end]) ++end;
    // From the middle of the first quiet window to that of the last.
    const std::size_t first_hop = w + kHopsPerWindow / 2;
    const std::size_t last_hop = end + kHopsPerWindow / 2;
    Standstill rest{first_hop * rows_per_hop_, last_hop * rows_per_hop_, {}};
    for (std::size_t i = 0; i < 3; ++i) rest.force[i] = moments(channels_[3 + i], w, end - 1 + kHopsPerWindow).mean;
    if (t_s_[rest.last - 1] - t_s_[rest.first] >= kShortest_s) found.push_back(rest);
    w = end;
  }
  return found;
}

std::vector<Standstill> StandstillFinder::find() const {
  const std::vector<double> force = spreads(3);
  if (force.empty() || windows_ == 0) return {};
  const std::vector<double> rate = spreads(0);
  const double force_threshold = threshold(force, 3);
  const double rate_threshold = rate.empty() ? 0.0 : threshold(rate, 0);
  const double nominal_s = standstill_interval_s(t_s_) * static_cast<double>(kHopsPerWindow * rows_per_hop_);
  std::vector<bool> quiet(windows_);
  for (std::size_t w = 0; w < windows_; ++w) {
    const std::size_t first = w * rows_per_hop_;
    const double lasts_s = t_s_[first + kHopsPerWindow * rows_per_hop_ - 1] - t_s_[first];
    quiet[w] = lasts_s <= kLongestGap * nominal_s && force[w] <= force_threshold &&
               (rate.empty() || rate[w] <= rate_threshold);
  }
  if (!rate.empty()) drop_turning(quiet, rate_threshold);
  return collect(quiet);
}

bool may_be_bench_session(const Recording& recording) {
  if (!recording.position.empty() || recording.rows() == 0) return false;
  if (recording.t_s.back() - recording.t_s.front() > kLongestSession_s) return false;
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  for (const double temp_c : recording.temp_c) {
    if (std::isnan(temp_c)) continue;
    low = std::min(low, temp_c);
    high = std::max(high, temp_c);
  }
  return high - low <= kOneTemperature_c;
}

bool show_attitudes(std::span<const Standstill> standstills) {
  const double apart = std::cos(kApart_deg * base::kRadPerDeg);
  std::vector<Vector3> attitudes;
  for (const Standstill& rest : standstills) {
    const bool known =
        std::ranges::any_of(attitudes, [&](const Vector3& other) { return cosine(rest.force, other) > apart; });
    if (!known) attitudes.push_back(rest.force);
  }
  return attitudes.size() >= kFewestAttitudes;
}

}  // namespace soak::calib
