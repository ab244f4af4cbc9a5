// SPDX-License-Identifier: Apache-2.0
#include "calib/estimate/detail/missing.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <string_view>

namespace soak::calib::six_position {
namespace {

constexpr std::array<char, 3> kAxisLetters = {'x', 'y', 'z'};
constexpr double kHorizontal = 0.045;  ///< |up_i| under which axis i counts as horizontal: that of kOnAxis across

bool seen(const Problem& problem, std::size_t axis, double sign) {
  return std::any_of(problem.rows.begin(), problem.rows.end(),
                     [&](const Row& row) { return sign * row.up[axis] > kOnAxis; });
}

/// Those of the six positions in which the sensor has no segment.
std::vector<std::string_view> missing_labels(const Problem& problem) {
  std::vector<std::string_view> missing;
  for (std::size_t i = 0; i < kSixPositionLabels.size(); ++i) {
    if (!seen(problem, i / 2, i % 2 == 0 ? 1.0 : -1.0)) missing.push_back(kSixPositionLabels[i]);
  }
  return missing;
}

/// Whether gravity acts along the sensor's axis in a visit that does not show its scale error.
bool scale_in_bias(const Problem& problem) {
  const std::size_t axis = axis_of(problem.sensor);
  return std::any_of(problem.rows.begin(), problem.rows.end(), [&](const Row& row) {
    return !problem.visits[row.visit].with_scale && std::abs(row.up[axis]) > kHorizontal;
  });
}

/// Where an even-order term stays that counted as 0. With the axis up and down, two opposite horizontal positions would
/// show it, so a misalignment that is known comes from one of them alone.
std::string_view even_order_words(const Problem& problem, const SensorEstimate& estimate, bool any_scale) {
  const std::size_t axis = axis_of(problem.sensor);
  if (!any_scale) return "its even-order term";
  if (!seen(problem, axis, 1.0) || !seen(problem, axis, -1.0)) {
    return "its even-order term (which stays in the scale error; its bias is that at 0 g)";
  }
  const bool misaligned = estimate.coupling[(axis + 1) % 3] || estimate.coupling[(axis + 2) % 3];
  return misaligned ? "its even-order term (which stays in the misalignment)" : "its even-order term";
}

/// Whole °C of the visits that do not show the scale error.
std::set<int> temps_without_scale_c(const SensorEstimate& estimate) {
  std::set<int> temps_c;
  for (const PlateauEstimate& plateau : estimate.plateaus) {
    if (!plateau.scale_ppm) temps_c.insert(static_cast<int>(std::lround(plateau.temp_c)));
  }
  return temps_c;
}

std::vector<std::string> accelerometer_lacks(const Problem& problem, const SensorEstimate& estimate) {
  std::vector<std::string> lacks;
  const auto with_scale = std::count_if(estimate.plateaus.begin(), estimate.plateaus.end(),
                                        [](const PlateauEstimate& plateau) { return plateau.scale_ppm.has_value(); });
  const auto visits = static_cast<std::ptrdiff_t>(estimate.plateaus.size());
  if (with_scale < visits) {
    lacks.push_back(fmt::format("its scale error{}{}",
                                with_scale == 0
                                    ? ""
                                    : fmt::format(" at {} of {} plateau visits ({} °C)", visits - with_scale, visits,
                                                  fmt::join(temps_without_scale_c(estimate), ", ")),
                                scale_in_bias(problem) ? " (which stays in the bias)" : ""));
  }
  if (!estimate.even_order) lacks.emplace_back(even_order_words(problem, estimate, with_scale > 0));
  for (std::size_t j = 0; j < 3; ++j) {
    if (!estimate.coupling[j]) lacks.push_back(fmt::format("its misalignment along {}", kAxisLetters[j]));
  }
  return lacks;
}

std::vector<std::string> gyro_lacks(const Problem& problem, const SensorEstimate& estimate) {
  std::vector<std::string> lacks;
  const std::size_t axis = axis_of(problem.sensor);
  if (!seen(problem, axis, 1.0) || !seen(problem, axis, -1.0)) {
    lacks.emplace_back("its g-sensitivity (which stays in the bias, with the Earth's rotation)");
  } else {
    for (std::size_t j = 0; j < 3; ++j) {
      if (!estimate.coupling[j]) lacks.push_back(fmt::format("its g-sensitivity along {}", kAxisLetters[j]));
    }
  }
  const bool any_scale = std::any_of(estimate.plateaus.begin(), estimate.plateaus.end(),
                                     [](const PlateauEstimate& plateau) { return plateau.scale_ppm.has_value(); });
  if (problem.reference_rate_rps > 0.0 && !any_scale) {
    lacks.emplace_back("its scale error (no plateau visit has two rates about its axis in one position)");
  }
  return lacks;
}

}  // namespace

void warn_of_missing(const Problem& problem, const SensorEstimate& estimate, std::vector<Warning>& warnings) {
  if (!problem.with_position) return;
  const auto lacks = is_gyro(problem.sensor) ? gyro_lacks(problem, estimate) : accelerometer_lacks(problem, estimate);
  const auto missing = missing_labels(problem);
  const std::string without = missing.empty() ? "" : fmt::format("without {} ", fmt::join(missing, ", "));
  if (!lacks.empty()) {
    warnings.push_back({"missing_position", fmt::format("{}: {}one cannot see {}", name_of(problem.sensor), without,
                                                        fmt::join(lacks, "; "))});
  }
  const std::size_t lost = problem.visits.size() - estimate.plateaus.size();
  if (lost > 0) {
    warnings.push_back(
        {"missing_position", fmt::format("{}: {} plateau visits were left out: their positions do not show the bias",
                                         name_of(problem.sensor), lost)});
  }
}

}  // namespace soak::calib::six_position
