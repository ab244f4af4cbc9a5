// SPDX-License-Identifier: Apache-2.0
#include "calib/estimate/certificates.h"

#include <algorithm>
#include <cmath>

namespace soak::calib {
namespace {

constexpr double kPerPpm = 1e-6;

bool was_used_in(const ReferenceUse& use, std::string_view campaign) {
  return use.campaigns.empty() || std::ranges::find(use.campaigns, campaign) != use.campaigns.end();
}

}  // namespace

CertifiedReading certified_reading(std::span<const ReferenceUse> references, ReferenceKind kind,
                                   std::string_view campaign) {
  CertifiedReading reading;
  double without_correction = 0.0;
  for (const ReferenceUse& use : references) {
    const Reference& reference = use.reference;
    if (reference.kind != kind || !was_used_in(use, campaign)) continue;
    const double correction = reference.correction.value_or(0.0);
    const double u = reference.standard_uncertainty;
    if (!reading.standard_uncertainty) reading.correction = correction;
    reading.undecided = reading.undecided || correction != reading.correction;
    reading.standard_uncertainty = std::max(reading.standard_uncertainty.value_or(0.0), u);
    without_correction = std::max(without_correction, std::hypot(u, correction));
  }
  if (reading.undecided) return {0.0, without_correction, true};
  return reading;
}

void correct_rates(std::span<Segment> segments, std::span<const ReferenceUse> references, std::string_view campaign) {
  const double factor = 1.0 + kPerPpm * certified_reading(references, ReferenceKind::rate, campaign).correction;
  for (Segment& segment : segments) {
    if (turns(segment)) *segment.position->rate_dps *= factor;
  }
}

void correct_supply(std::span<double> supply_v, std::span<const ReferenceUse> references, std::string_view campaign) {
  const double correction_v = certified_reading(references, ReferenceKind::supply, campaign).correction;
  for (double& reading_v : supply_v) reading_v += correction_v;
}

}  // namespace soak::calib
