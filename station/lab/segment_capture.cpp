// SPDX-License-Identifier: Apache-2.0
#include "station/lab/segment_capture.h"

#include <algorithm>
#include <cmath>

#include "station/lab/sample_reading.h"

namespace soak::station {
namespace {

constexpr double kLongestGap_s = 5.0;

}  // namespace

bool SegmentCapture::takes(const hal::ImuSample& sample) {
  if (complete_ || broken_) return false;
  if (!passed_first_) {
    passed_first_ = true;
    return false;
  }
  if (!start_s_) start_s_ = sample.t_s;
  const double t_s = sample.t_s - *start_s_;
  broken_ = t_s - end_s_ > kLongestGap_s;
  if (broken_) return false;
  if (t_s >= seconds_) {
    complete_ = true;
    return false;
  }
  end_s_ = t_s;
  ++samples_;
  clipped_ += sample.clipped ? 1 : 0;
  for (std::size_t s = 0; s < calib::kSensorCount; ++s) {
    if (samples_ == 1) sums_[s].first = reading_of(sample, s);
    const double offset = reading_of(sample, s) - sums_[s].first;
    sums_[s].sum += offset;
    sums_[s].squares += offset * offset;
  }
  if (sample.temp_c) {
    if (temps_++ == 0) first_temp_c_ = static_cast<double>(*sample.temp_c);
    const double offset = static_cast<double>(*sample.temp_c) - first_temp_c_;
    sum_t_ += t_s;
    sum_temp_ += offset;
    sum_tt_ += t_s * t_s;
    sum_t_temp_ += t_s * offset;
  }
  return true;
}

double SegmentCapture::temp_change_c() const {
  if (temps_ < 3) return 0.0;
  const auto n = static_cast<double>(temps_);
  const double spread = n * sum_tt_ - sum_t_ * sum_t_;
  return spread > 0.0 ? (n * sum_t_temp_ - sum_t_ * sum_temp_) / spread * end_s_ : 0.0;
}

SampleSpread SegmentCapture::spread(calib::Sensor sensor) const {
  const Sums& sums = sums_[calib::index_of(sensor)];
  if (samples_ < 2) return {sums.first, 0.0};
  const auto n = static_cast<double>(samples_);
  const double variance = (sums.squares - sums.sum * sums.sum / n) / (n - 1.0);
  return {sums.first + sums.sum / n, std::sqrt(std::max(variance, 0.0))};
}

}  // namespace soak::station
