// SPDX-License-Identifier: Apache-2.0
#include "station/http/unit_file_api.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "station/io/host.h"
#include "station/io/text.h"
#include "station/release/exported_file.h"
#include "station/release/release_rule.h"

namespace soak::station {
namespace {

using base::Result;
using nlohmann::json;

constexpr std::size_t kLongestFileStem = 60;
constexpr std::size_t kEventsLookedAt = 100;
constexpr const char* kWhereTo = "GET /api/v1/unit/file";

Result<ExportRequest> file_asked_for(const Parameters& parameters) {
  if (auto known = only_parameters(parameters, {"unit", "format", "simulated"}); !known) {
    return base::forward_error(known);
  }
  const auto unit = required(parameters, "unit", "a serial number");
  if (!unit) return base::forward_error(unit);
  const auto format = required(parameters, "format", "blob, c, json, px4 or ardupilot");
  if (!format) return base::forward_error(format);
  if (*format == "kalibr" || ending_of(*format).empty()) {
    return base::bad_input("there is no such format of a model: blob, c, json, px4 or ardupilot", "format");
  }
  const auto simulated = single(parameters, "simulated");
  if (!simulated) return base::forward_error(simulated);
  if (*simulated && **simulated != "true" && **simulated != "false") {
    return base::bad_input("neither true nor false", "simulated");
  }
  ExportRequest request;
  request.unit = *unit;
  request.format = *format;
  request.simulated = *simulated == "true";
  return request;
}

/// The newest released model, which must keep the rule now: an older one is not given in its place, as `soak export
/// --all` does not.
Result<ReleaseCase> model_to_hand_over(const db::Catalog& catalog, const ExportRequest& request) {
  const auto head = newest_released(catalog, request.unit);
  if (!head) return base::forward_error(head);
  if (!*head) return base::bad_input(fmt::format("no model of unit {} is released", request.unit), "state");
  auto release = judge_release(catalog, **head, now_utc_s());
  if (!release || release->obstacles.empty()) return release;
  return base::bad_input(fmt::format("model {} of unit {} is released, but must not be handed over: {}",
                                     (*head)->version, request.unit, fmt::join(release->obstacles, "; ")),
                         "state");
}

/// Once of a model and format, however often it is asked for.
base::Status record_once(db::Catalog& catalog, const ExportRequest& request, const ExportedFile& made,
                         const std::string& user) {
  const auto events = catalog.find_events({.kind = "calibration_exported",
                                           .subject = request.unit,
                                           .user = {},
                                           .from_utc_s = {},
                                           .to_utc_s = {},
                                           .before = {},
                                           .most = kEventsLookedAt});
  if (!events) return base::forward_error(events);
  const std::string text = fmt::format("{} of model {} to {}", request.format, *made.model, kWhereTo);
  if (std::ranges::any_of(*events, [&](const db::EventRow& event) { return event.text == text; })) return {};
  return catalog.add_calibration(
      {request.unit, *made.model, now_utc_s(), request.format, content_sha256(made.content), kWhereTo, user});
}

Result<UnitFile> released_file_of(db::Catalog& catalog, ExportRequest request, const std::string& user) {
  const auto unit = catalog.unit(request.unit);
  if (!unit) return base::forward_error(unit);
  if (!*unit) return base::bad_input("there is no such unit; /api/v1/units lists those that there are", "unit");
  const auto release = model_to_hand_over(catalog, request);
  if (!release) return base::forward_error(release);
  if (release->calibration.simulated && !request.simulated) {
    return base::bad_input(fmt::format("model {} of unit {} is of SIMULATED data: simulated=true gives it all the same",
                                       release->head.version, request.unit),
                           "state");
  }
  request.model = release->head.version;
  const auto made = export_model(catalog, request);
  if (!made) return base::forward_error(made);
  if (auto recorded = record_once(catalog, request, *made, user); !recorded) return base::forward_error(recorded);
  const std::string stem = plain_file_name(request.unit.substr(0, kLongestFileStem));
  return UnitFile{stem + std::string(ending_of(request.format)), made->content};
}

}  // namespace

Result<UnitFile> unit_file(RunArchive& archive, const Parameters& parameters, const std::string& user) {
  const auto request = file_asked_for(parameters);
  if (!request) return base::forward_error(request);
  UnitFile file;
  const auto done = archive.in_turn([&](db::Catalog& catalog) -> Result<json> {
    auto made = released_file_of(catalog, *request, user);
    if (!made) return base::forward_error(made);
    file = *std::move(made);
    return json();
  });
  if (!done) return base::forward_error(done);
  return file;
}

}  // namespace soak::station
