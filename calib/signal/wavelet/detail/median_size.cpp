// SPDX-License-Identifier: Apache-2.0
#include "calib/signal/wavelet/detail/median_size.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

namespace soak::calib::signal::denoising {
namespace {

constexpr std::size_t kStride = 256;         // one value in so many belongs to the sample
constexpr std::size_t kWorthwhile = 16'384;  // below, all values are partitioned at once

/// Mean of the values of rank (n - 1)/2 and n/2 among n, of which `values` holds those from rank `below` on.
double middle(std::vector<double>& values, std::size_t below, std::size_t n) {
  const auto upper = values.begin() + static_cast<std::ptrdiff_t>(n / 2 - below);
  std::nth_element(values.begin(), upper, values.end());
  const double lower = n % 2 == 1 ? *upper : *std::max_element(values.begin(), upper);
  return 0.5 * lower + 0.5 * *upper;
}

std::vector<double> sizes(std::span<const double> values, std::size_t stride) {
  std::vector<double> size;
  size.reserve(values.size() / stride + 1);
  for (std::size_t i = 0; i < values.size(); i += stride) size.push_back(std::abs(values[i]));
  return size;
}

/// Two sizes that most likely have the median between them: in a sample of m its rank scatters by sqrt(m)/2, the
/// bracket reaches four times as far.
std::pair<double, double> bracket(std::span<const double> values) {
  std::vector<double> sample = sizes(values, kStride);
  std::sort(sample.begin(), sample.end());
  const auto reach = static_cast<std::size_t>(2.0 * std::sqrt(static_cast<double>(sample.size())));
  const std::size_t centre = sample.size() / 2;
  return {sample[centre - reach], sample[centre + reach]};
}

/// The sizes from `low` to `high`, and how many are below.
struct Between {
  std::vector<double> inside;
  std::size_t below = 0;
};

/// Adds those of a block of at most kStride values; no branch depends on them.
void add_block(std::span<const double> values, double low, double high, Between& found) {
  std::array<double, kStride> inside;
  std::size_t count = 0;
  for (const double v : values) {
    const double size = std::abs(v);
    inside[count] = size;
    found.below += static_cast<std::size_t>(size < low);
    count += static_cast<std::size_t>(size >= low) & static_cast<std::size_t>(size <= high);
  }
  found.inside.insert(found.inside.end(), inside.begin(), inside.begin() + static_cast<std::ptrdiff_t>(count));
}

Between between(std::span<const double> values, double low, double high) {
  Between found;
  for (std::size_t i = 0; i < values.size(); i += kStride) {
    add_block(values.subspan(i, std::min(kStride, values.size() - i)), low, high, found);
  }
  return found;
}

}  // namespace

double median_size(std::span<const double> values) {
  const std::size_t n = values.size();
  if (n == 0) return 0.0;
  if (n >= kWorthwhile) {
    const auto [low, high] = bracket(values);
    Between found = between(values, low, high);
    const bool holds_both = found.below <= (n - 1) / 2 && n / 2 < found.below + found.inside.size();
    if (holds_both) return middle(found.inside, found.below, n);
  }
  std::vector<double> all = sizes(values, 1);
  return middle(all, 0, n);
}

}  // namespace soak::calib::signal::denoising
