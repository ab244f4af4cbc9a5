// SPDX-License-Identifier: Apache-2.0
#include "station/lab/rate_watch.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "base/units.h"

namespace soak::station {
namespace {

constexpr double kWindow_s = 2.0;
constexpr double kOffset_dps = 2.0;
constexpr double kShareAlong = 0.02;
constexpr double kShareAcross = 0.05;

}  // namespace

void RateWatch::expect(const calib::Position& position, double rate_dps) {
  up_ = position.up;
  expected_dps_ = rate_dps;
  expects_ = true;
  right_ = false;
  seen_dps_.reset();
  samples_ = 0;
}

void RateWatch::begin_window(double t_s) {
  begun_s_ = t_s;
  sum_rps_ = {};
  samples_ = 0;
}

void RateWatch::add(const hal::ImuSample& sample) {
  if (!expects_) return;
  // Time that begins anew (a restart) begins the window anew.
  if (samples_ == 0 || sample.t_s < last_s_) begin_window(sample.t_s);
  last_s_ = sample.t_s;
  for (std::size_t i = 0; i < 3; ++i) sum_rps_[i] += static_cast<double>(sample.rate_rps[i]);
  ++samples_;
  if (sample.t_s - begun_s_ < kWindow_s) return;
  judge();
  samples_ = 0;
}

void RateWatch::judge() {
  double along = 0.0;
  double square = 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    const double mean_dps = sum_rps_[i] / samples_ * base::kDegPerRad;
    along += mean_dps * up_[i];
    square += mean_dps * mean_dps;
  }
  const double across = std::sqrt(std::max(square - along * along, 0.0));
  const double size = std::abs(expected_dps_);
  seen_dps_ = along;
  right_ = std::abs(along - expected_dps_) <= kOffset_dps + kShareAlong * size &&
           across <= kOffset_dps + kShareAcross * size;
}

}  // namespace soak::station
