// SPDX-License-Identifier: Apache-2.0
#include "hal/maps/detail/axes_reader.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "calib/vocabulary/position.h"
#include "hal/maps/detail/axis_geometry.h"
#include "hal/maps/detail/map_check.h"
#include "hal/maps/detail/quantity_reader.h"

namespace soak::hal {
namespace {

constexpr double kCosineOfOneDegree = 0.99984770;
/// The units judge a position within 5°: what the fixture calls reached must be well inside.
constexpr Limits kTolerance_deg{0.001, 2.0};
constexpr Limits kRateTolerance_dps{0.001, 5.0};

calib::Vector3 read_direction(const SettingsTable& axes, std::string_view key) {
  std::vector<std::pair<std::string_view, calib::Vector3>> words;
  for (const std::string_view label : calib::kSixPositionLabels) {
    words.emplace_back(label, calib::position_named(label)->up);
  }
  return axes.choice<calib::Vector3>(key, words);
}

/// What of its quantities a fixture of two axes lacks.
std::vector<std::string> needs_of(const RegisterMap& map, bool spins) {
  std::vector<std::string> needs;
  const auto note = [&needs](const base::Status& status) {
    if (!status) needs.push_back(status.error().message);
    return status.has_value();
  };
  const auto request = [&](const std::string& name, std::string_view why) {
    if (!note(require_writable(map, name))) return;
    const Quantity& quantity = map.quantities.at(name);
    if (!quantity.min || !quantity.max)
      needs.push_back(fmt::format("[quantity.{}] needs 'min' and 'max': {}", name, why));
  };
  request("outer_request", "the angles that its cables bear");
  request("inner_request", "the angles that its cables bear");
  for (const char* name : {"outer_position", "inner_position"}) note(require_quantity(map, name));
  for (const char* code : {"standing", "moving", "fault"}) {
    if (!note(require_code(map, "status", code))) break;
  }
  if (spins) {
    request("rate_request", "the rates that it may turn at");
    note(require_quantity(map, "rate"));
  }
  return needs;
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
  AnglesReader(const SettingsTable& table, const AxisDirections& directions, const RegisterMap& map)
      : table_(table), directions_(directions), map_(map) {}

  /// Nothing where it is a mistake.
  std::optional<AxisAngles> read(const std::string& label) const {
    const auto numbers = table_.numbers(label, kAnyNumber);
    const auto position = calib::position_named(label);
    if (!position || position->label != label) {
      table_.refuse(
          label, fmt::format("'{}' is no position: known are {}", label, fmt::join(calib::kSixPositionLabels, ", ")));
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

  const SettingsTable& table_;
  const AxisDirections& directions_;
  const RegisterMap& map_;
};

std::optional<FixtureAxis> read_spinning_axis(const SettingsTable& axes) {
  if (!axes.has("spins")) return std::nullopt;
  return axes.choice<FixtureAxis>("spins", {{"outer", FixtureAxis::outer}, {"inner", FixtureAxis::inner}});
}

void read_angles(const SettingsTable& axes, const AxisDirections& directions, RegisterMap& map) {
  constexpr bool required = true;
  const auto table = axes.table("angles_deg", required);
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

void refuse_what_belongs_elsewhere(const SettingsTable& root, const SettingsTable& axes, const RegisterMap& map) {
  (void)root.texts("positions");
  (void)root.numbers("azimuths_deg", kAnyNumber);
  for (const char* key : {"positions", "azimuths_deg"}) {
    if (root.has(key))
      root.refuse(key, fmt::format("'{}' is of fixtures without [axes]: here the angles tell it", key));
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

Vocabulary two_axis_vocabulary() {
  return {{"outer_request", "outer_position", "inner_request", "inner_position", "status", "rate_request", "rate"},
          {"go", "spin"}};
}

void read_axes(const SettingsTable& root, RegisterMap& map) {
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
  const auto needs = needs_of(map, map.axes->spins.has_value());
  if (!needs.empty()) root.refuse("axes", fmt::format("{}", fmt::join(needs, "; ")));
}

}  // namespace soak::hal
