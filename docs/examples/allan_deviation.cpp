// SPDX-License-Identifier: Apache-2.0
// Overlapping Allan deviations of white noise, whose angle random walk is known: N = sigma / sqrt(rate).
#include <cmath>
#include <cstdio>
#include <vector>

#include "base/random.h"
#include "calib/signal/allan/allan.h"

namespace signal = soak::calib::signal;

int main() {
  constexpr double kRateHz = 100.0;
  constexpr double kSigma = 0.02;  // deg/s
  soak::base::Random random(1);
  std::vector<double> rate(100'000);
  for (double& sample : rate) sample = kSigma * random.gaussian();

  const auto record = signal::PhaseRecord::from_rate(rate, kRateHz);
  if (!record) {
    std::fprintf(stderr, "%s: %s\n", record.error().where.c_str(), record.error().message.c_str());
    return 1;
  }
  const double expected = kSigma / std::sqrt(kRateHz);  // deg/s/sqrt(Hz)
  for (const std::size_t multiple : {10, 100, 1000}) {
    const signal::AllanPoint point = signal::allan_point(*record, signal::AllanKind::overlapping, multiple);
    const double tau_s = static_cast<double>(multiple) / kRateHz;
    std::printf("tau %6.2f s: %.6f deg/s, %.6f expected\n", tau_s, point.deviation, expected / std::sqrt(tau_s));
    if (std::abs(point.deviation * std::sqrt(tau_s) / expected - 1.0) > 0.2) return 1;
  }
  return 0;
}
