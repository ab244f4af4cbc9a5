// SPDX-License-Identifier: Apache-2.0
#include "station/report/fleet_overview.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "base/text.h"
#include "calib/judge/fleet.h"
#include "calib/vocabulary/sensor.h"

namespace soak::station {
namespace {

using base::Result;
using nlohmann::json;

constexpr std::size_t kUnitsOfATurn = 20;

/// A curve that is compared: keys of a point of `soak fit --json`.
struct CurveKind {
  const char* name;
  const char* value;
  const char* ci95;
};
constexpr std::array<CurveKind, 2> kCurves = {{{"bias", "bias", "ci95"}, {"scale", "scale_ppm", "scale_ci95_ppm"}}};

struct Curves {
  calib::FleetMember member;
  bool tells_drift = true;  ///< no model is of one run
};

using CurvesOfUnit = std::array<std::array<Curves, kCurves.size()>, calib::kSensorCount>;

/// A unit with what its last two models state.
struct ListedUnit {
  json head;
  CurvesOfUnit curves;
};

calib::FleetCurve curve_of(const json& points, const CurveKind& kind) {
  calib::FleetCurve curve;
  for (const json& point : points) {
    const json value = point.value(kind.value, json());
    const json ci95 = point.value(kind.ci95, json());
    if (value.is_number() && ci95.is_number()) curve.push_back({point.at("temp_c"), value, ci95});
  }
  std::ranges::sort(curve, {}, &calib::FleetPoint::temp_c);
  return curve;
}

/// Takes the curves that a model states into `member` of each of a unit's. The bands of one run do not hold how a unit
/// differs from power-on to power-on, so such a curve is not compared with another model's.
void take_curves(const std::string& document, calib::FleetCurve calib::FleetMember::* which, CurvesOfUnit& curves) {
  const json model = json::parse(document, nullptr, false);
  const json sensors = model.value("/fit/sensors"_json_pointer, json::object());
  for (const auto& [name, part] : sensors.items()) {
    const auto sensor = calib::sensor_named(name);
    if (!sensor) continue;
    const json runs = part.value("runs", json());
    const bool tells_scatter = runs.is_array() && runs.size() > 1;
    for (std::size_t k = 0; k < kCurves.size(); ++k) {
      Curves& of = curves[calib::index_of(*sensor)][k];
      of.tells_drift = of.tells_drift && tells_scatter;
      of.member.*which = curve_of(part.value("curve", json::array()), kCurves[k]);
    }
  }
}

/// Leaves out what tells no drift, and says of the rest how many they are.
void share_false_alarms(CurvesOfUnit& curves) {
  std::size_t compared = 0;
  for (auto& sensor : curves) {
    for (Curves& of : sensor) {
      if (!of.tells_drift) of.member.before.clear();
      if (!of.member.newest.empty() && !of.member.before.empty()) ++compared;
    }
  }
  for (auto& sensor : curves) {
    for (Curves& of : sensor) of.member.curves = compared;
  }
}

/// Reads a unit's newest model and the one before it, of the same epoch: a repaired unit is another one.
base::Status read_models(const db::Catalog& catalog, const std::string& serial, ListedUnit& unit) {
  const auto newest = catalog.model(serial);
  if (!newest) return base::forward_error(newest);
  if (!*newest) return {};
  unit.head["model"] = {
      {"version", (*newest)->version}, {"epoch", (*newest)->epoch}, {"created_utc_s", (*newest)->created_utc_s}};
  take_curves((*newest)->document, &calib::FleetMember::newest, unit.curves);
  if ((*newest)->version < 2) return {};
  const auto before = catalog.model(serial, (*newest)->version - 1);
  // What is wrong with an older model is no trouble of the newest: only what has moved is not known.
  if (!before || !*before || (*before)->epoch != (*newest)->epoch) return {};
  unit.head["before"] = (*before)->version;
  take_curves((*before)->document, &calib::FleetMember::before, unit.curves);
  share_false_alarms(unit.curves);
  return {};
}

ListedUnit listed_unit(const db::Catalog& catalog, const FleetSources& sources, const db::UnitRow& row) {
  ListedUnit unit;
  unit.head = {{"unit", row.serial}, {"epoch", row.epoch}, {"model", nullptr},
               {"before", nullptr},  {"trouble", nullptr}, {"verdict", nullptr}};
  // One that is damaged must not keep the others from being seen.
  if (const auto read = read_models(catalog, row.serial, unit); !read) {
    unit.head["trouble"] = read.error().message;
    unit.curves = {};
    return unit;
  }
  auto verdict = sources.verdict(catalog, unit.head);
  if (verdict) {
    unit.head["verdict"] = *std::move(verdict);
  } else {
    unit.head["trouble"] = verdict.error().message;
  }
  return unit;
}

/// Six digits are more than a drawing shows.
json rounded(double value) { return base::parse_double(fmt::format("{:.6g}", value)).value_or(value); }

json rounded(const std::optional<double>& value) { return value ? rounded(*value) : json(); }

json list_of(const std::vector<std::optional<double>>& values) {
  json list = json::array();
  for (const auto& value : values) list.push_back(rounded(value));
  return list;
}

json drift_json(const std::optional<calib::FleetDrift>& drift) {
  if (!drift) return {};
  return {{"temp_c", drift->temp_c},
          {"change", rounded(drift->change)},
          {"band", rounded(drift->band)},
          {"beyond_band", drift->is_beyond_band()}};
}

/// Which units' values are told: outliers first, of the others evenly many.
std::vector<bool> drawn_units(const std::vector<calib::FleetPlace>& units) {
  std::vector<bool> drawn;
  for (const auto& unit : units) drawn.push_back(unit.is_outlier());
  const auto outliers = static_cast<std::size_t>(std::ranges::count(drawn, true));
  const std::size_t room = kMostCurvesDrawn > outliers ? kMostCurvesDrawn - outliers : 0;
  const std::size_t others = units.size() - outliers;
  for (std::size_t u = 0, seen = 0; u < units.size(); ++u) {
    if (drawn[u]) continue;
    drawn[u] = others <= room || (seen + 1) * room / others > seen * room / others;
    ++seen;
  }
  return drawn;
}

json curve_json(const std::vector<ListedUnit>& units, std::size_t sensor, std::size_t kind) {
  std::vector<calib::FleetMember> members;
  for (const ListedUnit& unit : units) members.push_back(unit.curves[sensor][kind].member);
  const calib::FleetSpread fleet = calib::compare_fleet(members);
  if (fleet.temp_c.empty()) return {};
  const std::vector<bool> drawn = drawn_units(fleet.units);
  json lines = json::array();
  for (std::size_t u = 0; u < units.size(); ++u) {
    if (members[u].newest.empty()) continue;
    const calib::FleetPlace& place = fleet.units[u];
    lines.push_back({{"unit", units[u].head["unit"]},
                     {"values", drawn[u] ? list_of(place.values) : json()},
                     {"distance", rounded(place.distance)},
                     {"farthest_c", rounded(place.farthest_c)},
                     {"outlier", place.is_outlier()},
                     {"drift", drift_json(place.drift)}});
  }
  return {{"temp_c", fleet.temp_c},
          {"median", list_of(fleet.median)},
          {"spread", list_of(fleet.spread)},
          {"units", std::move(lines)}};
}

/// The units of a type, in the order of their serial numbers.
Result<std::vector<db::UnitRow>> units_of(const FleetSources& sources, const std::string& type) {
  std::vector<db::UnitRow> found;
  const auto read = sources.in_turn([&](const db::Catalog& catalog) -> Result<json> {
    auto units = catalog.units();
    if (!units) return base::forward_error(units);
    std::ranges::copy_if(*units, std::back_inserter(found), [&](const auto& unit) { return unit.type == type; });
    return json();
  });
  if (!read) return base::forward_error(read);
  if (found.empty()) return base::bad_input("no unit is of this type; /api/v1/units lists units and types", "type");
  return found;
}

Result<std::vector<ListedUnit>> read_units(const FleetSources& sources, const std::vector<db::UnitRow>& rows) {
  std::vector<ListedUnit> units;
  while (units.size() < rows.size()) {
    const auto read = sources.in_turn([&](const db::Catalog& catalog) -> Result<json> {
      const std::size_t end = std::min(rows.size(), units.size() + kUnitsOfATurn);
      while (units.size() < end) {
        units.push_back(listed_unit(catalog, sources, rows[units.size()]));
      }
      return json();
    });
    if (!read) return base::forward_error(read);
  }
  return units;
}

}  // namespace

Result<json> fleet_overview(const FleetSources& sources, const std::string& type) {
  auto rows = units_of(sources, type);
  if (!rows) return base::forward_error(rows);
  const std::size_t left_out = rows->size() - std::min(rows->size(), kMostUnitsOfFleet);
  rows->erase(rows->begin(), rows->begin() + static_cast<std::ptrdiff_t>(left_out));
  const auto units = read_units(sources, *rows);
  if (!units) return base::forward_error(units);
  json document = {{"type", type},
                   {"rule", {{"outlier_distance", calib::kOutlierDistance}, {"fewest_units", calib::kFewestForSpread}}},
                   {"units", json::array()},
                   {"not_listed", left_out},
                   {"sensors", json::object()}};
  for (const ListedUnit& unit : *units) document["units"].push_back(unit.head);
  for (const calib::Sensor sensor : calib::kSensors) {
    json part = {{"unit", calib::printed_unit(sensor)}};
    for (std::size_t k = 0; k < kCurves.size(); ++k) {
      part[kCurves[k].name] = curve_json(*units, calib::index_of(sensor), k);
    }
    if (!part["bias"].is_null()) document["sensors"][std::string(calib::name_of(sensor))] = std::move(part);
  }
  return document;
}

}  // namespace soak::station
