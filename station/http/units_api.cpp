// SPDX-License-Identifier: Apache-2.0
#include "station/http/units_api.h"

#include <fmt/format.h>

#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>

#include "base/text.h"
#include "calib/judge/report_json.h"
#include "calib/signal/documents/signal_json.h"
#include "station/config/unit_type_file.h"
#include "station/nav/free_inertial.h"
#include "station/report/drawn_points.h"
#include "station/report/noise_limit.h"
#include "station/report/rows_of_model.h"
#include "station/report/unit_overview.h"
#include "station/runs/rest_record.h"
#include "station/runs/still_segment.h"

namespace soak::station {
namespace {

using base::Result;
using nlohmann::json;

/// A version of a model as a parameter says it.
Result<std::int32_t> version_in(const std::string& text) {
  const auto version = base::parse_int(text);
  if (!version || *version < 1 || *version > std::numeric_limits<std::int32_t>::max()) {
    return base::bad_input("the version of a model is a whole number from 1 on", "version");
  }
  return static_cast<std::int32_t>(*version);
}

/// A version of a unit's model that a question must name.
struct AskedModel {
  std::string unit;
  std::int32_t version = 0;
};

Result<AskedModel> asked_model(const Parameters& parameters) {
  if (auto known = only_parameters(parameters, {"unit", "version"}); !known) return base::forward_error(known);
  auto serial = required(parameters, "unit", "a serial number");
  if (!serial) return base::forward_error(serial);
  const auto text = required(parameters, "version", "the version of a model");
  if (!text) return base::forward_error(text);
  const auto version = version_in(*text);
  if (!version) return base::forward_error(version);
  return AskedModel{*std::move(serial), *version};
}

Result<json> answer_model(RunArchive& runs, const Parameters& parameters) {
  const auto asked = asked_model(parameters);
  if (!asked) return base::forward_error(asked);
  return runs.in_turn([&](const db::Catalog& catalog) { return model_overview(catalog, asked->unit, asked->version); });
}

Result<json> answer_impact(RunArchive& runs, const Parameters& parameters) {
  if (auto known = only_parameters(parameters, {"unit", "version"}); !known) return base::forward_error(known);
  const auto serial = required(parameters, "unit", "a serial number");
  if (!serial) return base::forward_error(serial);
  std::optional<std::int32_t> asked;
  const auto text = single(parameters, "version");
  if (!text) return base::forward_error(text);
  if (*text) {
    const auto version = version_in(**text);
    if (!version) return base::forward_error(version);
    asked = *version;
  }
  std::optional<calib::Calibration> calibration;
  auto answer = runs.in_turn([&](const db::Catalog& catalog) -> Result<json> {
    auto model = calibration_of_model(catalog, *serial, asked);
    if (!model) return base::forward_error(model);
    calibration = std::move(model->calibration);
    return json{{"unit", *serial}, {"model", model->version}};
  });
  if (!answer) return answer;
  auto impact = runs.compute([&] { return Result<json>(impact_with_drives_json(*calibration)); });
  if (!impact) return impact;
  answer->emplace("impact", *std::move(impact));
  return answer;
}

Result<json> answer_rows(RunArchive& runs, const Parameters& parameters) {
  const auto asked = asked_model(parameters);
  if (!asked) return base::forward_error(asked);
  calib::ReportInput input;
  auto answer = runs.in_turn([&](const db::Catalog& catalog) -> Result<json> {
    const auto model = calibration_of_model(catalog, asked->unit, asked->version);
    if (!model) return base::forward_error(model);
    auto rows = rows_of_model(catalog, {.unit = asked->unit, .model = asked->version, .limits = {}, .source = {}});
    if (!rows) return base::forward_error(rows);
    input = std::move(rows->input);
    return json{{"unit", asked->unit}, {"model", asked->version}};
  });
  if (!answer) return answer;
  auto sections = runs.compute([&] { return calib::report_json(input); });
  if (!sections) return sections;
  answer->emplace("sensors", drawn_points((*sections)["sensors"]));
  return answer;
}

/// Where a unit's noise is taken from, and what its type says of it.
struct NoiseSource {
  std::optional<StillSegment> still;
  calib::UnitType type;
};

/// The Allan document of one sensor, or {"reason"}: its readings are read in one turn, and worked on when others have
/// theirs.
Result<json> allan_of(RunArchive& runs, const StillSegment& still, calib::Sensor sensor) {
  std::optional<calib::SignalRecord> record;
  auto read = runs.in_turn([&](const db::Catalog& catalog) -> Result<json> {
    auto found = record_at_rest(catalog, still, sensor);
    if (found) {
      record = *std::move(found);
      return json();
    }
    if (found.error().kind != base::ErrorKind::bad_input) return base::forward_error(found);
    return json{{"reason", found.error().message}};
  });
  if (!read || !record) return read;
  return runs.compute([&]() -> Result<json> {
    const auto allan = calib::allan_json(*record, {});
    return allan ? *allan : json{{"reason", allan.error().message}};
  });
}

/// allan_of() each sensor that a segment has, by its name.
Result<json> allans_of(RunArchive& runs, const StillSegment& still) {
  json sensors = json::object();
  for (const calib::Sensor sensor : calib::kSensors) {
    if (still.segment.sensor[calib::index_of(sensor)].count == 0) continue;
    auto allan = allan_of(runs, still, sensor);
    if (!allan) return allan;
    sensors[std::string(calib::name_of(sensor))] = *std::move(allan);
  }
  return sensors;
}

/// The samples of a sealed run never change: what is in them is found once.
std::string name_of_rest(const StillSegment& still) {
  const calib::SegmentKey& key = still.segment.key;
  return fmt::format("noise {} {} {} {} {} {}", still.run.content_sha256, still.run.run_id, still.run.unit, key.visit,
                     key.position, key.attempt);
}

Result<json> answer_unit_noise(RunArchive& runs, const Parameters& parameters) {
  if (auto known = only_parameters(parameters, {"unit"}); !known) return base::forward_error(known);
  const auto serial = required(parameters, "unit", "a serial number");
  if (!serial) return base::forward_error(serial);
  NoiseSource source;
  auto answer = runs.in_turn([&](const db::Catalog& catalog) -> Result<json> {
    const auto unit = catalog.unit(*serial);
    if (!unit) return base::forward_error(unit);
    if (!*unit) return base::bad_input("there is no such unit; /api/v1/units lists those that there are", "unit");
    auto type = known_unit_type((*unit)->type);
    if (!type) return base::forward_error(type);
    auto still = longest_still_segment(catalog, *serial, (*unit)->epoch);
    if (!still) return base::forward_error(still);
    source = {*std::move(still), *std::move(type)};
    return json{{"unit", *serial},
                {"type", (*unit)->type},
                {"segment", source.still ? still_segment_json(*source.still) : json()},
                {"sensors", json::object()},
                {"reason", source.still ? json() : json(kNothingAtRest)}};
  });
  if (!answer || !source.still) return answer;
  const auto allans = runs.once(name_of_rest(*source.still), [&] { return allans_of(runs, *source.still); });
  if (!allans) return base::forward_error(allans);
  for (const auto& [name, allan] : allans->items()) {
    const calib::Sensor sensor = *calib::sensor_named(name);
    (*answer)["sensors"][name] = judged_noise(allan, sensor, noise_limit(source.type, sensor));
  }
  return answer;
}

}  // namespace

const std::vector<RunQuestion>& unit_questions() {
  static const std::vector<RunQuestion> questions = {{"model", answer_model},
                                                     {"model/rows", answer_rows},
                                                     {"impact", answer_impact},
                                                     {"unit/noise", answer_unit_noise}};
  return questions;
}

}  // namespace soak::station
