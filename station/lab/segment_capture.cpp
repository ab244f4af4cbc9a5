// SPDX-License-Identifier: Apache-2.0
#include "station/lab/segment_capture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "base/units.h"

namespace soak::station {
namespace {

constexpr double kLongestGap_s = 5.0;

constexpr std::size_t kFewSamples = 20;
constexpr double kLostShare = 1e-3;
constexpr double kWrongRate = 1.5;  ///< too fast or too slow by this factor

/// A sensor's figures over the positions of one unit, in the sensor's display unit.
struct SensorFigures {
  double noise_density = 0.0;  ///< largest
  double bias = 0.0;           ///< mean over the positions (gravity cancels over ± pairs)
  bool stuck = false;          ///< not a digit changed in any position
  bool numbers = true;         ///< all of its readings
};

double to_display(calib::Sensor sensor, double value) {
  return calib::is_gyro(sensor) ? value * base::kDegPerRad : value;
}

SensorFigures figures_of(const std::vector<const PreflightRecord*>& records, calib::Sensor sensor) {
  SensorFigures figures;
  figures.stuck = true;
  for (const PreflightRecord* record : records) {
    const SampleSpread& spread = record->spread[calib::index_of(sensor)];
    const double sigma = to_display(sensor, spread.sigma);
    figures.numbers = figures.numbers && std::isfinite(spread.mean) && std::isfinite(spread.sigma);
    if (record->rate_hz > 0.0)
      figures.noise_density = std::max(figures.noise_density, sigma * std::sqrt(2.0 / record->rate_hz));
    figures.bias += to_display(sensor, spread.mean) / static_cast<double>(records.size());
    figures.stuck = figures.stuck && spread.sigma == 0.0;
  }
  return figures;
}

void judge_sensor(const std::vector<const PreflightRecord*>& records, calib::Sensor sensor,
                  std::vector<PreflightFinding>& findings) {
  const PreflightRecord& any = *records.front();
  const bool gyro = calib::is_gyro(sensor);
  const SensorFigures figures = figures_of(records, sensor);
  const auto finding = [&](PreflightFault fault, const std::string& text) {
    findings.push_back({fault, fmt::format("unit {}, {}: {}", any.unit, calib::name_of(sensor), text)});
  };
  if (!figures.numbers) {
    finding(PreflightFault::not_finite, "some readings are not finite (NaN or infinite)");
    return;
  }
  if (figures.stuck) {
    finding(PreflightFault::stuck, "the reading never changes: the sensor is stuck or missing");
    return;
  }
  const std::string_view unit = gyro ? "deg/s" : "m/s2";
  const auto noise_limit = gyro ? any.type.gyro_noise_max_dps_rthz : any.type.accel_noise_max_mps2_rthz;
  if (noise_limit && figures.noise_density > *noise_limit) {
    finding(PreflightFault::noise,
            fmt::format("noise {:.4g} {}/√Hz, the type allows {:.4g}", figures.noise_density, unit, *noise_limit));
  }
  const auto bias_limit = gyro ? any.type.gyro_bias_max_dps : any.type.accel_bias_max_mps2;
  if (bias_limit && std::abs(figures.bias) > *bias_limit) {
    finding(PreflightFault::bias,
            fmt::format("bias {:.4g} {}, the type allows {:.4g}", figures.bias, unit, *bias_limit));
  }
}

/// A position whose recording broke off shows too low a rate: the best one counts.
void judge_rate(const std::vector<const PreflightRecord*>& records, std::vector<PreflightFinding>& findings) {
  const PreflightRecord& fastest = **std::ranges::max_element(records, {}, &PreflightRecord::rate_hz);
  const double asked_hz = fastest.asked_rate_hz;
  if (fastest.rate_hz <= kWrongRate * asked_hz && asked_hz <= kWrongRate * fastest.rate_hz) return;
  findings.push_back(
      {PreflightFault::wrong_rate, fmt::format("unit {}: sends {:.4g} samples per second instead of {:.4g}",
                                               fastest.unit, fastest.rate_hz, asked_hz)});
}

void judge_unit(const std::vector<const PreflightRecord*>& records, std::vector<PreflightFinding>& findings) {
  const std::string& serial = records.front()->unit;
  std::size_t samples = 0;
  std::size_t clipped = 0;
  std::uint64_t lost = 0;
  for (const PreflightRecord* record : records) {
    samples += record->samples;
    clipped += record->clipped;
    lost = std::max(lost, record->lost_packets);
    if (record->samples < kFewSamples) {
      findings.push_back({PreflightFault::few_samples,
                          fmt::format("unit {}: only {} samples in {}", serial, record->samples, record->position)});
    }
  }
  if (clipped > 0)
    findings.push_back({PreflightFault::clipped,
                        fmt::format("unit {}: {} samples at the end of the range while at rest", serial, clipped)});
  if (static_cast<double>(lost) > kLostShare * static_cast<double>(samples)) {
    findings.push_back(
        {PreflightFault::lost_packets, fmt::format("unit {}: {} packets lost of {}", serial, lost, samples + lost)});
  }
  judge_rate(records, findings);
  for (const calib::Sensor sensor : calib::kSensors) judge_sensor(records, sensor, findings);
}

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

std::vector<PreflightFinding> preflight_findings(const std::vector<PreflightRecord>& records) {
  std::map<std::string, std::vector<const PreflightRecord*>> by_unit;
  for (const PreflightRecord& record : records) by_unit[record.unit].push_back(&record);
  std::vector<PreflightFinding> findings;
  for (const auto& [serial, of_unit] : by_unit) judge_unit(of_unit, findings);
  return findings;
}

}  // namespace soak::station
