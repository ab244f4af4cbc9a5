// SPDX-License-Identifier: Apache-2.0
#include "nav/scenario/spline.h"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace soak::nav {

MonotoneSpline::MonotoneSpline(std::vector<double> t_s, std::vector<double> values)
    : t_s_(std::move(t_s)), values_(std::move(values)), slopes_(t_s_.size(), 0.0) {
  for (std::size_t k = 1; k + 1 < t_s_.size(); ++k) {
    const double before_s = t_s_[k] - t_s_[k - 1];
    const double after_s = t_s_[k + 1] - t_s_[k];
    const double before = (values_[k] - values_[k - 1]) / before_s;
    const double after = (values_[k + 1] - values_[k]) / after_s;
    if (before * after <= 0.0) continue;
    // Weighted harmonic mean of the two chords: at most three times the flatter one.
    const double w1 = 2.0 * after_s + before_s;
    const double w2 = after_s + 2.0 * before_s;
    slopes_[k] = (w1 + w2) / (w1 / before + w2 / after);
  }
}

MonotoneSpline::Point MonotoneSpline::at(double t_s) const {
  if (t_s <= t_s_.front()) return {values_.front(), 0.0};
  if (t_s >= t_s_.back()) return {values_.back(), 0.0};
  const auto k = static_cast<std::size_t>(std::ranges::upper_bound(t_s_, t_s) - t_s_.begin()) - 1;
  const double h = t_s_[k + 1] - t_s_[k];
  const double x = (t_s - t_s_[k]) / h;
  const double y = 1.0 - x;
  const double rise = values_[k + 1] - values_[k];
  // Hermite's form: value and slope at both ends.
  return {values_[k] + rise * x * x * (3.0 - 2.0 * x) + h * x * y * (slopes_[k] * y - slopes_[k + 1] * x),
          6.0 * rise / h * x * y + slopes_[k] * y * (1.0 - 3.0 * x) + slopes_[k + 1] * x * (3.0 * x - 2.0)};
}

}  // namespace soak::nav
