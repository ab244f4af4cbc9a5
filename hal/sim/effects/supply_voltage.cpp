// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/effects/supply_voltage.h"

#include <cmath>

#include "base/random.h"
#include "hal/sim/unit/draws.h"

namespace soak::hal::sim {
namespace {

constexpr double kNominal_v = 5.0;
constexpr double kOffsetSigma_v = 0.03;
constexpr double kWanderingSigma_v = 0.02;
constexpr double kCorrelationTime_s = 400.0;

}  // namespace

double SupplyVoltage::at(double time_s, int run) {
  const double decay = moment_ == 0 ? 0.0 : std::exp(-(time_s - time_s_) / kCorrelationTime_s);
  const double innovation = base::hashed_gaussian(seed_, stream_of(Purpose::supply, 1), moment_++);
  wandering_ = decay * wandering_ + std::sqrt(1.0 - decay * decay) * innovation;
  time_s_ = time_s;
  const double offset = base::hashed_gaussian(seed_, stream_of(Purpose::supply, 0), static_cast<std::uint64_t>(run));
  return kNominal_v + kOffsetSigma_v * offset + kWanderingSigma_v * wandering_;
}

}  // namespace soak::hal::sim
