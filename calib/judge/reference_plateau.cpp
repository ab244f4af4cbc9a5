// SPDX-License-Identifier: Apache-2.0
#include "calib/judge/reference_plateau.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "calib/estimate/unit_input.h"
#include "calib/segments/statistics.h"

namespace soak::calib {
namespace {

constexpr double kSlopeReach_c = 12.5;
constexpr double kSlopeSpan_c = 2.0;
constexpr double kUncarried_c = 0.5;

/// A stay at a plateau.
struct Visit {
  std::int32_t number = 0;
  double plateau_c = 0.0;

  [[nodiscard]] double distance_c() const { return std::abs(plateau_c - kReferencePlateau_c); }
};

/// In the order of time, which is that of their numbers. Rejected segments count too: what is wrong with a visit's
/// samples does not make another one the first.
std::vector<Visit> visits_of(const RunInput& run) {
  std::map<std::int32_t, double> plateaus_c;
  for (const Segment& segment : run.segments) {
    if (segment.plateau_c && segment.phase == Phase::soak) plateaus_c.emplace(segment.key.visit, *segment.plateau_c);
  }
  std::vector<Visit> visits;
  for (const auto& [number, plateau_c] : plateaus_c) visits.push_back({number, plateau_c});
  return visits;
}

bool begins_and_ends_there(const std::vector<Visit>& visits) {
  if (visits.size() < 3) return false;
  const Visit& first = visits.front();
  const Visit& last = visits.back();
  const bool went_away = std::ranges::any_of(
      visits, [&first](const Visit& visit) { return std::abs(visit.plateau_c - first.plateau_c) > kSameSetPoint_c; });
  return went_away && std::abs(last.plateau_c - first.plateau_c) <= kSameSetPoint_c &&
         std::max(first.distance_c(), last.distance_c()) <= kReferenceReach_c;
}

std::vector<std::int32_t> nearest_visits(const std::vector<Visit>& visits) {
  const auto nearest = std::ranges::min_element(visits, {}, &Visit::distance_c);
  std::vector<std::int32_t> numbers;
  if (nearest == visits.end() || nearest->distance_c() > kReferenceReach_c) return numbers;
  for (const Visit& visit : visits) {
    if (std::abs(visit.plateau_c - nearest->plateau_c) <= kSameSetPoint_c) numbers.push_back(visit.number);
  }
  return numbers;
}

const PlateauEstimate* find(const SensorEstimate& estimate, std::int32_t visit) {
  const auto found = std::ranges::find(estimate.plateaus, visit, &PlateauEstimate::visit);
  return found == estimate.plateaus.end() ? nullptr : &*found;
}

std::optional<double> slope_about(const SensorEstimate& estimate, double temp_c) {
  std::vector<double> temps_c;
  std::vector<double> biases;
  for (const PlateauEstimate& plateau : estimate.plateaus) {
    if (std::abs(plateau.temp_c - temp_c) > kSlopeReach_c) continue;
    temps_c.push_back(plateau.temp_c);
    biases.push_back(plateau.bias);
  }
  if (temps_c.empty()) return std::nullopt;
  const auto [coldest, warmest] = std::ranges::minmax(temps_c);
  if (warmest - coldest < kSlopeSpan_c) return std::nullopt;
  return fit_line(temps_c, biases).slope;
}

/// b + (dT)·slope; without a slope, b over a short way.
std::optional<Estimate> carried(const Estimate& bias, double by_c, const std::optional<double>& slope_per_k) {
  if (slope_per_k) return Estimate{bias.value + by_c * *slope_per_k, bias.standard_error};
  return std::abs(by_c) <= kUncarried_c ? std::optional(bias) : std::nullopt;
}

std::optional<SensorReference> mean_of(const SensorEstimate& estimate, const std::vector<std::int32_t>& visits) {
  std::vector<const PlateauEstimate*> there;
  for (const std::int32_t visit : visits) {
    if (const PlateauEstimate* plateau = find(estimate, visit)) there.push_back(plateau);
  }
  if (there.empty()) return std::nullopt;
  SensorReference reference;
  const double share = 1.0 / static_cast<double>(there.size());
  double variance = 0.0;
  for (const PlateauEstimate* plateau : there) {
    reference.bias.value += share * plateau->bias;
    reference.temp_c += share * plateau->temp_c;
    variance += share * share * plateau->bias_se * plateau->bias_se;
  }
  reference.bias.standard_error = std::sqrt(variance);
  reference.slope_per_k = slope_about(estimate, reference.temp_c);
  return reference;
}

void add_drift(const SensorEstimate& estimate, std::int32_t first_visit, std::int32_t last_visit,
               SensorReference& reference) {
  const PlateauEstimate* first = find(estimate, first_visit);
  const PlateauEstimate* last = find(estimate, last_visit);
  if (first != nullptr) reference.first = Estimate{first->bias, first->bias_se};
  if (last != nullptr) reference.last = Estimate{last->bias, last->bias_se};
  if (first == nullptr || last == nullptr) return;
  const auto end = carried(*reference.last, first->temp_c - last->temp_c, reference.slope_per_k);
  if (!end) return;
  reference.drift = Estimate{end->value - first->bias, std::hypot(first->bias_se, last->bias_se)};
}

}  // namespace

RunAtReference reference_plateau(const RunInput& run, const UnitType& type) {
  RunAtReference result;
  const std::vector<Visit> visits = visits_of(run);
  result.at_both_ends = begins_and_ends_there(visits);
  result.visits =
      result.at_both_ends ? std::vector{visits.front().number, visits.back().number} : nearest_visits(visits);
  if (result.visits.empty()) return result;
  const SixPositionEstimate estimate = estimate_six_positions(accepted(run.segments), run.site, type);
  for (std::size_t s = 0; s < kSensorCount; ++s) {
    result.sensor[s] = mean_of(estimate.sensor[s], result.visits);
    if (!result.sensor[s] || !result.at_both_ends) continue;
    add_drift(estimate.sensor[s], result.visits.front(), result.visits.back(), *result.sensor[s]);
  }
  return result;
}

std::optional<Estimate> carried_to(const SensorReference& reference, double temp_c) {
  return carried(reference.bias, temp_c - reference.temp_c, reference.slope_per_k);
}

}  // namespace soak::calib
