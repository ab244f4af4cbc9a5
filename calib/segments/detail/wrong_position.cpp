// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <string>

#include "base/statistics.h"
#include "base/units.h"
#include "calib/segments/detail/gate.h"

namespace soak::calib::gate {
namespace {

/// Part of the up vector that the recorded accelerometers must see for a judgement.
constexpr double kSeen = 0.5;
/// Of the six positions as many must be there to tell the bias: of an axis' readings the middle one is of a position in
/// which it lies level, whatever the labels say.
constexpr std::size_t kFewestPositions = 4;
constexpr double kReversed_deg = 150.0;  ///< from the label: upside down
constexpr std::size_t kFewestReversed = 2;

/// Mean specific force as far as it was recorded, less a bias.
struct Force {
  Vector3 value{};
  std::array<bool, 3> seen{};
};

Force force_of(const Segment& segment, const Vector3& bias) {
  Force force;
  for (std::size_t i = 0; i < 3; ++i) {
    const SensorStatistics& accel = segment.sensor[3 + i];
    force.seen[i] = accel.count > 0;
    if (force.seen[i]) force.value[i] = accel.mean - bias[i];
  }
  return force;
}

/// Angle between a force and where it should point, both as the recorded axes see them: cos = u·f / (|u|·|f|). Nothing
/// where they see too little.
std::optional<double> angle_to_up_deg(const Force& force, const Vector3& up, int sign_at_rest) {
  double along = 0.0;
  double seen = 0.0;
  double squares = 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    if (!force.seen[i]) continue;
    along += up[i] * sign_at_rest * force.value[i];
    seen += up[i] * up[i];
    squares += force.value[i] * force.value[i];
  }
  if (std::sqrt(seen) < kSeen || squares <= 0.0) return std::nullopt;
  return base::kDegPerRad * std::acos(std::clamp(along / std::sqrt(seen * squares), -1.0, 1.0));
}

/// The one of the six positions that a force is nearest to.
std::string nearest_position(const Force& force, int sign_at_rest) {
  std::size_t axis = 0;
  for (std::size_t i = 1; i < 3; ++i) {
    if (std::abs(force.value[i]) > std::abs(force.value[axis])) axis = i;
  }
  return {force.value[axis] * sign_at_rest < 0.0 ? '-' : '+', static_cast<char>('X' + axis)};
}

/// Whether no other of the six positions is nearer than the labelled one.
bool is_nearest(const Force& force, const Vector3& up, int sign_at_rest, double label_deg) {
  return std::none_of(kSixPositionLabels.begin(), kSixPositionLabels.end(), [&](std::string_view label) {
    const Vector3 other = position_named(label)->up;
    return other != up && angle_to_up_deg(force, other, sign_at_rest).value_or(360.0) < label_deg;
  });
}

/// Middle of an axis' readings, one per label of the six positions; 0 where it is not known.
double middle_of_labels(std::span<const Segment> segments, std::size_t axis) {
  std::map<std::string, std::vector<double>> readings;
  for (const Segment& segment : segments) {
    const SensorStatistics& accel = segment.sensor[3 + axis];
    if (segment.position && position_named(segment.position->label) && accel.count > 0) {
      readings[segment.position->label].push_back(accel.mean);
    }
  }
  if (readings.size() < kFewestPositions) return 0.0;
  std::vector<double> middles;
  for (const auto& [label, values] : readings) middles.push_back(base::median(values));
  return base::median(middles);
}

bool all_reversed(std::span<const Segment> segments, const Vector3& bias, int sign_at_rest) {
  std::size_t reversed = 0;
  for (const Segment& segment : segments) {
    if (!segment.position) continue;
    const auto angle = angle_to_up_deg(force_of(segment, bias), segment.position->up, sign_at_rest);
    if (angle && *angle < kReversed_deg) return false;
    reversed += angle ? 1 : 0;
  }
  return reversed >= kFewestReversed;
}

std::string label_remedy(const View& view) {
  if (!view.facts.attitude.reversed) return "check the label, and the signs and order of the axes";
  if (&view.segment != view.segments.data()) return "as in every segment of the run";
  return fmt::format(
      "so it is in every segment of the run: the accelerometers read {} where their axis points up; state sign_at_rest "
      "= {} in the unit's type, or scale = -1 for them in the columns map",
      view.type.sign_at_rest > 0 ? "-g" : "+g", -view.type.sign_at_rest);
}

}  // namespace

AttitudeFacts attitude_facts(std::span<const Segment> segments, const UnitType& type) {
  AttitudeFacts facts;
  for (std::size_t i = 0; i < 3; ++i) facts.bias[i] = middle_of_labels(segments, i);
  facts.reversed = all_reversed(segments, facts.bias, type.sign_at_rest);
  return facts;
}

void wrong_position(const View& view, std::vector<Finding>& findings) {
  if (!view.segment.position) return;
  const Force force = force_of(view.segment, view.facts.attitude.bias);
  const auto& [label, up, azimuth, rate] = *view.segment.position;
  const auto label_deg = angle_to_up_deg(force, up, view.type.sign_at_rest);
  if (!label_deg || *label_deg <= view.limits.position_deg) return;
  if (is_nearest(force, up, view.type.sign_at_rest, *label_deg)) {
    findings.push_back({"wrong_position", Severity::warn, std::nullopt,
                        fmt::format("labelled {}, and gravity points {:.0f} deg away from there (limit {:.0f} deg), "
                                    "but no other position fits better: a large bias, or a fixture that is not square",
                                    label, *label_deg, view.limits.position_deg)});
    return;
  }
  findings.push_back(
      {"wrong_position", Severity::reject, std::nullopt,
       fmt::format(
           "labelled {}, but gravity points {:.0f} deg away from there (limit {:.0f} deg): it looks like {}; {}", label,
           *label_deg, view.limits.position_deg, nearest_position(force, view.type.sign_at_rest), label_remedy(view))});
}

}  // namespace soak::calib::gate
