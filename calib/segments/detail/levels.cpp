// SPDX-License-Identifier: Apache-2.0
#include "calib/segments/detail/levels.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/statistics.h"
#include "calib/segments/detail/scan.h"

namespace soak::calib::gate {
namespace {

constexpr double kStretch_s = 10.0;
constexpr std::size_t kFewestStretches = 6;
constexpr std::size_t kSamplesPerStretch = 100;  ///< whose median stands for all
constexpr double kSigmaPerMad = 1.4826;          ///< of a Gaussian
constexpr double kLongestBurst_s = 0.25;
constexpr std::size_t kLongestBurstRows = 3;

std::vector<double> thinned(std::span<const double> values) {
  const std::size_t stride = values.size() / kSamplesPerStretch + 1;
  std::vector<double> result;
  result.reserve(kSamplesPerStretch + 1);
  for (std::size_t i = 0; i < values.size(); i += stride) {
    std::size_t row = i;  // of a channel with values in few rows the next one after the row
    while (row + 1 < std::min(i + stride, values.size()) && std::isnan(values[row])) ++row;
    if (!std::isnan(values[row])) result.push_back(values[row]);
  }
  return result;
}

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

}  // namespace

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
    const std::vector<double> samples = thinned(values.subspan(stretch.first, stretch.last - stretch.first));
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

}  // namespace soak::calib::gate
