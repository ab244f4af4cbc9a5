// SPDX-License-Identifier: Apache-2.0
#include "station/fit/fleet_hysteresis.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>
#include <vector>

#include "calib/curve/one_way.h"
#include "calib/model/model_document.h"

namespace soak::station {
namespace {

/// Units of this type have nothing in common.
constexpr std::string_view kAnyType = "generic";

/// Sensors that went one way somewhere and of which the type states nothing.
std::vector<std::size_t> open_sensors(const calib::UnitRows& rows) {
  std::vector<std::size_t> open;
  if (rows.unit_type == kAnyType) return open;
  for (std::size_t s = 0; s < calib::kSensorCount; ++s) {
    const bool is_open = rows.bias[s] && rows.hysteresis[s].source == calib::HysteresisSource::none &&
                         !calib::one_way_ranges(*rows.bias[s]).empty();
    if (is_open) open.push_back(s);
  }
  return open;
}

/// The same of a model that is stored.
bool was_open(const calib::SensorCalibration& sensor) {
  return sensor.one_way && sensor.one_way->known.source != calib::HysteresisSource::type;
}

/// Half the gap between heating and cooling, in printed units, that a stored model shows of a sensor; nothing of one
/// that was itself recorded one way somewhere.
std::optional<double> half_gap_of(const nlohmann::json& document, calib::Sensor sensor) {
  const nlohmann::json::json_pointer at("/fit/sensors/" + std::string(name_of(sensor)));
  if (!document.contains(at)) return std::nullopt;
  const nlohmann::json& fit = document[at];
  // Models of earlier versions do not say whether they went both ways.
  const bool both_ways = fit.contains("one_way") && fit["one_way"].is_null();
  if (!both_ways || !fit.contains("sweeps") || !fit["sweeps"].is_object()) return std::nullopt;
  return fit["sweeps"].value("half_rms", 0.0);
}

}  // namespace

bool asks_fleet(const calib::UnitRows& rows) { return !open_sensors(rows).empty(); }

bool asked_fleet(const calib::Calibration& calibration) {
  return calibration.unit_type != kAnyType &&
         std::ranges::any_of(calibration.sensors, [](const auto& sensor) { return was_open(sensor); });
}

bool agrees(const calib::Calibration& calibration, const FleetHysteresis& fleet) {
  return std::ranges::all_of(calibration.sensors, [&](const calib::SensorCalibration& sensor) {
    return !was_open(sensor) || sensor.one_way->known == fleet[index_of(sensor.sensor)];
  });
}

base::Result<FleetHysteresis> hysteresis_of_fleet(const db::Catalog& catalog, const std::string& type, bool simulated,
                                                  const std::set<std::string>& without) {
  std::array<std::vector<double>, calib::kSensorCount> squares;
  const auto units = catalog.units();
  if (!units) return base::forward_error(units);
  for (const db::UnitRow& unit : *units) {
    if (unit.type != type || without.contains(unit.serial)) continue;
    const auto model = catalog.model(unit.serial);
    if (!model) return base::forward_error(model);
    if (!*model) continue;
    const auto calibration = calib::calibration_of((*model)->document);
    if (!calibration) return base::forward_error(calibration);
    if ((calibration->simulated && !simulated) || asked_fleet(*calibration)) continue;
    const auto document = nlohmann::json::parse((*model)->document, nullptr, false);
    for (const calib::Sensor sensor : calib::kSensors) {
      const auto half = half_gap_of(document, sensor);
      if (half) squares[index_of(sensor)].push_back(std::pow(*half / printed_per_si(sensor), 2));
    }
  }
  FleetHysteresis fleet{};
  for (std::size_t s = 0; s < fleet.size(); ++s) {
    if (squares[s].empty()) continue;
    double sum = 0.0;
    for (const double square : squares[s]) sum += square;
    fleet[s] = {std::sqrt(sum / static_cast<double>(squares[s].size())), calib::HysteresisSource::fleet};
  }
  return fleet;
}

void take_from_fleet(const FleetHysteresis& fleet, calib::UnitRows& rows) {
  for (const std::size_t s : open_sensors(rows)) rows.hysteresis[s] = fleet[s];
}

}  // namespace soak::station
