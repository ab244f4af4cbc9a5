// SPDX-License-Identifier: Apache-2.0
#include "hal/maps/detail/fixture_axes.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/units.h"
#include "hal/maps/detail/device_needs.h"
#include "hal/maps/detail/map_format.h"

namespace soak::hal {
namespace {

using calib::Vector3;

constexpr double kCosineOfOneDegree = 0.99984770;

Vector3 cross(const Vector3& a, const Vector3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// Rodrigues: v cos t + (k x v) sin t + k (k . v)(1 - cos t)
Vector3 turned(const Vector3& v, const Vector3& k, double angle_deg) {
  const double cosine = std::cos(angle_deg * base::kRadPerDeg);
  const double sine = std::sin(angle_deg * base::kRadPerDeg);
  const Vector3 sideways = cross(k, v);
  const double along = dot(k, v) * (1.0 - cosine);
  Vector3 result{};
  for (std::size_t i = 0; i < 3; ++i) result[i] = v[i] * cosine + sideways[i] * sine + k[i] * along;
  return result;
}

/// The axis that follows, cyclically, the one nearest to `up`.
Vector3 axis_after(const Vector3& up) {
  std::size_t nearest = 0;
  for (std::size_t i = 1; i < 3; ++i) {
    if (std::abs(up[i]) > std::abs(up[nearest])) nearest = i;
  }
  Vector3 axis{};
  axis[(nearest + 1) % 3] = 1.0;
  return axis;
}

}  // namespace

double dot(const Vector3& a, const Vector3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

Vector3 up_at(const AxisDirections& axes, const AxisAngles& angles) {
  return turned(turned(axes.up, axes.outer, -angles.outer_deg), axes.inner, -angles.inner_deg);
}

double heading_deg(const AxisDirections& axes, const AxisAngles& angles) {
  const Vector3 own = axis_after(up_at(axes, angles));
  const Vector3 in_room = turned(turned(own, axes.inner, angles.inner_deg), axes.outer, angles.outer_deg);
  const Vector3 forward = axis_after(axes.up);
  const Vector3 left = cross(axes.up, forward);
  return -std::atan2(dot(in_room, left), dot(in_room, forward)) * base::kDegPerRad;
}

int sense_about_up(const AxisDirections& axes, FixtureAxis axis, const AxisAngles& angles) {
  // The outer axis stands still in the room, the inner one in the fixture.
  const double cosine = axis == FixtureAxis::outer ? dot(axes.outer, axes.up) : dot(axes.inner, up_at(axes, angles));
  if (std::abs(cosine) < kCosineOfOneDegree) return 0;
  return cosine > 0.0 ? 1 : -1;
}

// --- the section [axes] of a map

namespace {

/// The units judge a position within 5°: what the fixture calls reached must be well inside.
constexpr settings::Limits kTolerance_deg{0.001, 2.0};
constexpr settings::Limits kRateTolerance_dps{0.001, 5.0};

calib::Vector3 read_direction(const settings::Table& axes, std::string_view key) {
  std::vector<std::pair<std::string_view, calib::Vector3>> words;
  for (const std::string_view label : calib::kSixPositionLabels) {
    words.emplace_back(label, calib::position_named(label)->up);
  }
  return axes.choice<calib::Vector3>(key, words);
}

/// What of its quantities a fixture of two axes lacks.
std::vector<std::string> axes_needs(const DeviceMap& map, bool spins) {
  Needs needs(map);
  const auto request = [&](const std::string& name, std::string_view why) {
    if (!needs.writable(name)) return;
    const Quantity& quantity = map.quantities.at(name);
    if (!quantity.min || !quantity.max) needs.note(fmt::format("[quantity.{}] needs 'min' and 'max': {}", name, why));
  };
  request("outer_request", "the angles that its cables allow");
  request("inner_request", "the angles that its cables allow");
  for (const char* name : {"outer_position", "inner_position"}) needs.quantity(name);
  for (const char* code : {"standing", "moving", "fault"}) {
    if (!needs.code("status", code)) break;
  }
  if (spins) {
    request("rate_request", "the rates that it may turn at");
    needs.quantity("rate");
  }
  return needs.sentences();
}

std::string direction_text(const calib::Vector3& up) {
  for (const std::string_view label : calib::kSixPositionLabels) {
    if (dot(up, calib::position_named(label)->up) >= kCosineOfOneDegree) return std::string(label);
  }
  return fmt::format("({:.3f}, {:.3f}, {:.3f})", up[0], up[1], up[2]);
}

/// Whether all three were read: what else is wrong with the angles follows from a mistake that is told already.
bool known(const AxisDirections& directions) {
  const auto is_unit = [](const calib::Vector3& v) { return dot(v, v) > 0.5; };
  return is_unit(directions.up) && is_unit(directions.outer) && is_unit(directions.inner);
}

/// The pairs of angles, one by one.
class AnglesReader {
 public:
  AnglesReader(const settings::Table& table, const AxisDirections& directions, const DeviceMap& map)
      : table_(table), directions_(directions), map_(map) {}

  /// Nothing where it is a mistake.
  std::optional<AxisAngles> read(const std::string& label) const {
    const auto numbers = table_.numbers(label, kAnyNumber);
    const auto position = calib::position_named(label);
    if (!position || position->label != label) {
      table_.refuse(label, fmt::format("'{}' is not a position: known are {}", label,
                                       fmt::join(calib::kSixPositionLabels, ", ")));
      return std::nullopt;
    }
    if (numbers.size() != 2) {
      table_.refuse(label, fmt::format("'{}' must be two angles in degrees, [outer, inner]", label));
      return std::nullopt;
    }
    const AxisAngles angles{numbers[0], numbers[1]};
    if (!within(label, "outer", angles.outer_deg) || !within(label, "inner", angles.inner_deg)) return std::nullopt;
    const calib::Vector3 up = up_at(directions_, angles);
    if (dot(up, position->up) >= kCosineOfOneDegree || !known(directions_)) return angles;
    table_.refuse(label, fmt::format("at [{}, {}] {} points up, not {}", angles.outer_deg, angles.inner_deg,
                                     direction_text(up), label));
    return std::nullopt;
  }

 private:
  bool within(const std::string& label, const std::string& axis, double angle_deg) const {
    const auto found = map_.quantities.find(axis + "_request");
    if (found == map_.quantities.end() || !found->second.min || !found->second.max) return true;
    const Quantity& request = found->second;
    if (angle_deg >= *request.min && angle_deg <= *request.max) return true;
    table_.refuse(label, fmt::format("the {} angle of '{}', {}, is beyond the limits of '{}_request', {} to {}", axis,
                                     label, angle_deg, axis, *request.min, *request.max));
    return false;
  }

  const settings::Table& table_;
  const AxisDirections& directions_;
  const DeviceMap& map_;
};

std::optional<FixtureAxis> read_spinning_axis(const settings::Table& axes) {
  if (!axes.has("spins")) return std::nullopt;
  return axes.choice<FixtureAxis>("spins", {{"outer", FixtureAxis::outer}, {"inner", FixtureAxis::inner}});
}

void read_angles(const settings::Table& axes, const AxisDirections& directions, DeviceMap& map) {
  const auto table = axes.table("angles_deg", settings::kRequired);
  if (!table) return;
  const AnglesReader reader(*table, directions, map);
  for (const std::string& label : table->keys()) {
    const auto angles = reader.read(label);
    if (!angles) continue;
    map.positions.push_back(label);
    map.azimuths_deg.push_back(heading_deg(directions, *angles));
    map.axes->angles_deg.push_back(*angles);
    map.axes->spin_sign.push_back(map.axes->spins ? sense_about_up(directions, *map.axes->spins, *angles) : 0);
  }
  if (table->keys().empty()) axes.refuse("angles_deg", "'axes.angles_deg' names no position");
}

void refuse_what_belongs_elsewhere(const settings::Table& root, const settings::Table& axes, const DeviceMap& map) {
  (void)root.texts("positions");
  (void)root.numbers("azimuths_deg", kAnyNumber);
  (void)root.table("leans_deg");
  for (const char* key : {"positions", "azimuths_deg", "leans_deg"}) {
    if (root.has(key))
      root.refuse(key, fmt::format("'{}' is for fixtures without [axes]: here the angles define it", key));
  }
  if (map.axes->spins) return;
  if (axes.has("rate_tolerance_dps")) {
    axes.refuse("rate_tolerance_dps", "'axes.rate_tolerance_dps' needs 'spins': the axis that turns at a rate");
  }
  for (const char* name : {"rate_request", "rate"}) {
    if (!map.quantities.contains(name)) continue;
    axes.refuse("", fmt::format("[quantity.{}] needs 'axes.spins': the axis that turns at a rate", name));
  }
  if (map.actions.contains("spin")) axes.refuse("", "the action 'spin' needs 'axes.spins'");
}

}  // namespace

void read_axes(const settings::Table& root, DeviceMap& map) {
  const auto axes = root.table("axes");
  if (!axes) return;
  const AxisDirections directions{read_direction(*axes, "up"), read_direction(*axes, "outer"),
                                  read_direction(*axes, "inner")};
  map.axes.emplace();
  map.axes->tolerance_deg = axes->number("tolerance_deg", kTolerance_deg);
  map.axes->spins = read_spinning_axis(*axes);
  if (map.axes->spins) map.axes->rate_tolerance_dps = axes->number("rate_tolerance_dps", kRateTolerance_dps);
  read_angles(*axes, directions, map);
  refuse_what_belongs_elsewhere(root, *axes, map);
  const auto needs = axes_needs(map, map.axes->spins.has_value());
  if (!needs.empty()) root.refuse("axes", fmt::format("{}", fmt::join(needs, "; ")));
}

}  // namespace soak::hal
