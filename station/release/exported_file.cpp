// SPDX-License-Identifier: Apache-2.0
#include "station/release/exported_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <string_view>

#include "base/hash.h"
#include "calib/deploy/calibration_file.h"
#include "calib/deploy/export.h"
#include "calib/deploy/export_kalibr.h"
#include "calib/deploy/signature.h"
#include "calib/deploy/table_form.h"
#include "calib/model/model_document.h"
#include "station/io/host.h"
#include "station/io/output.h"
#include "station/records/calibration_reader.h"
#include "station/records/key_file.h"
#include "station/records/signing.h"
#include "station/release/release_rule.h"
#include "station/runs/still_segment.h"

namespace soak::station {
namespace {

struct Format {
  std::string_view name;
  std::string_view ending;
};
constexpr std::array<Format, 6> kFormats = {{{"blob", ".soakcal"},
                                             {"c", ".h"},
                                             {"json", ".json"},
                                             {"px4", ".params"},
                                             {"ardupilot", ".parm"},
                                             {"kalibr", ".yaml"}}};

/// The members "cubic" and "notes" of docs/schema/export.schema.json: what the cubics lose, in deg/s and m/s².
nlohmann::json losses_json(const calib::AutopilotFile& file) {
  nlohmann::json sensors = nlohmann::json::object();
  for (const calib::CubicLoss& loss : file.losses) {
    const double factor = calib::printed_per_si(loss.sensor);
    sensors[std::string(calib::name_of(loss.sensor))] = {
        {"unit", calib::printed_unit(loss.sensor)},
        {"temp_min_c", loss.temp_min_c},
        {"temp_max_c", loss.temp_max_c},
        {"reference_c", loss.reference_c},
        {"rms", loss.rms * factor},
        {"worst", loss.worst * factor},
        {"worst_temp_c", loss.worst_temp_c},
        {"ci95_at_worst", loss.ci95_at_worst * factor},
        {"beyond_ci95", loss.beyond_ci95},
        {"steepest_per_c", loss.steepest_per_c * factor},
        {"scale_ppm", loss.scale_ppm ? nlohmann::json(*loss.scale_ppm) : nlohmann::json()}};
  }
  return {{"cubic", std::move(sensors)}, {"notes", file.notes}};
}

/// The same as a table with the notes under it.
std::string losses_text(const calib::AutopilotFile& file) {
  std::vector<std::vector<std::string>> table = {
      {"loss of the cubic", "rms", "worst", "at degC", "ci95 there", "beyond ci95", "unit"}};
  for (const calib::CubicLoss& loss : file.losses) {
    const double factor = calib::printed_per_si(loss.sensor);
    table.push_back({std::string(calib::name_of(loss.sensor)), fmt::format("{:.3g}", loss.rms * factor),
                     fmt::format("{:.3g}", loss.worst * factor), fmt::format("{:.1f}", loss.worst_temp_c),
                     fmt::format("{:.3g}", loss.ci95_at_worst * factor),
                     fmt::format("{:.0f} %", 100.0 * loss.beyond_ci95), std::string(calib::printed_unit(loss.sensor))});
  }
  std::string text = text_table(table);
  for (const std::string& note : file.notes) text += "- " + note + '\n';
  return text;
}

/// The member "noise": the values that kalibr reads.
nlohmann::json noise_json(const calib::KalibrSource& source, const calib::KalibrFile& file) {
  nlohmann::json values = nlohmann::json::object();
  for (const calib::KalibrValue& value : file.values) {
    values[value.key] = {
        {"value", value.value}, {"worst_axis", calib::name_of(value.worst)}, {"upper_bound", value.bound}};
  }
  return {{"noise",
           {{"run", source.run},
            {"temp_c", source.temp_c},
            {"temp_range_c", {source.least_temp_c, source.most_temp_c}},
            {"values", std::move(values)}}}};
}

std::string noise_text(const calib::KalibrSource& source, const calib::KalibrFile& file) {
  std::vector<std::vector<std::string>> table = {{"run " + source.run, "SI", "worst axis", ""}};
  for (const calib::KalibrValue& value : file.values) {
    table.push_back({value.key, fmt::format("{:.4g}", value.value), std::string(calib::name_of(value.worst)),
                     value.bound ? "upper bound" : "measured"});
  }
  std::string text = text_table(table);
  const double swing_k = source.most_temp_c - source.least_temp_c;
  if (swing_k > calib::kKalibrMostSwing_k) {
    text += fmt::format("note: the temperature swings by {:.1f} K in this segment; drift passes for random walk\n",
                        swing_k);
  }
  return text;
}

struct LoadedModel {
  calib::Calibration calibration;
  bool relative_accel = false;
  std::vector<calib::Warning> warnings;  ///< of the fit, that whoever uses the bands must know
};

/// Warnings of a fit that say what its bands leave out.
constexpr std::array<std::string_view, 3> kOfBands = {"few_runs", "one_way", "hysteresis"};

/// Those that the fit gave then, each sentence once.
std::vector<calib::Warning> band_warnings(const std::string& document) {
  std::vector<calib::Warning> warnings;
  const auto json = nlohmann::json::parse(document, nullptr, false);
  const nlohmann::json::json_pointer sensors("/fit/sensors");
  if (json.is_discarded() || !json.contains(sensors)) return warnings;
  for (const auto& sensor : json[sensors]) {
    for (const auto& entry : sensor.value("warnings", nlohmann::json::array())) {
      calib::Warning warning{entry.value("code", ""), entry.value("text", "")};
      if (std::ranges::find(kOfBands, warning.code) == kOfBands.end()) continue;
      if (std::ranges::find(warnings, warning.text, &calib::Warning::text) != warnings.end()) continue;
      warnings.push_back(std::move(warning));
    }
  }
  return warnings;
}

/// Whether the bias of an accelerometer is known up to a constant only.
bool has_relative_accel(const std::string& document) {
  const auto json = nlohmann::json::parse(document, nullptr, false);
  const nlohmann::json::json_pointer sensors("/fit/sensors");
  if (json.is_discarded() || !json.contains(sensors)) return false;
  for (const auto& [name, sensor] : json[sensors].items()) {
    if (name.starts_with("accel") && sensor.value("relative", false)) return true;
  }
  return false;
}

/// Refuses what the request does not accept: simulated data, a model that is not released or breaks the rule of release
/// now; marks the latter.
base::Status accept(const db::Catalog& catalog, const ExportRequest& request, calib::Calibration& calibration) {
  if (calibration.simulated && !request.simulated) {
    return base::bad_input(
        fmt::format("model {} of unit {} was made from SIMULATED data; use --simulated to export it anyway",
                    calibration.model_version, request.unit));
  }
  const auto head = model_head(catalog, request.unit, calibration.model_version);
  if (!head) return base::forward_error(head);
  if (head->state == "released") {
    const auto release = judge_release(catalog, *head, now_utc_s());
    if (!release) return base::forward_error(release);
    calibration.unreleased = !release->obstacles.empty();
    if (!calibration.unreleased || request.unreleased) return {};
    return base::bad_input(
        fmt::format("model {} of unit {} is released and does not keep the rule of release any more: {}; or export it "
                    "with --unreleased, which marks the file",
                    head->version, head->unit, fmt::join(release->obstacles, "; ")));
  }
  calibration.unreleased = true;
  if (request.unreleased) return {};
  const auto text = not_released_text(catalog, *head);
  return text ? base::bad_input(*text) : base::forward_error(text);
}

base::Result<LoadedModel> load_model(const db::Catalog& catalog, const ExportRequest& request) {
  const auto row = usable_model(catalog, request.unit, request.model);
  if (!row) return base::forward_error(row);
  auto calibration = calib::calibration_of(row->document);
  if (!calibration) return base::forward_error(calibration);
  if (auto accepted = accept(catalog, request, *calibration); !accepted) return base::forward_error(accepted);
  return LoadedModel{*std::move(calibration), has_relative_accel(row->document), band_warnings(row->document)};
}

base::Result<calib::Calibration> table_or_curves(const calib::Calibration& calibration, const ExportRequest& request) {
  if (!request.table) return calibration;
  return calib::table_form(calibration, *request.table);
}

base::Result<base::Bytes> blob(const calib::Calibration& calibration, const std::string& key_path) {
  auto bytes = calib::encode(calibration);
  if (!bytes || key_path.empty()) return bytes;
  const auto key = read_secret_key(key_path);
  if (!key) return base::forward_error(key);
  return signed_file(*bytes, key->key);
}

base::Result<std::string> calibration_content(const calib::Calibration& calibration, const ExportRequest& request) {
  if (request.format == "json") return calib::export_json(calibration);
  if (request.format == "c") return calib::export_c(calibration);
  const auto bytes = blob(calibration, request.sign);
  if (!bytes) return base::forward_error(bytes);
  return std::string(bytes->begin(), bytes->end());
}

base::Result<calib::AutopilotFile> render_autopilot(const LoadedModel& model, const ExportRequest& request) {
  if (request.format == "px4") {
    return calib::export_px4(model.calibration,
                             {request.instance.value_or(0), request.accel_id, request.gyro_id, model.relative_accel});
  }
  return calib::export_ardupilot(model.calibration, {request.instance.value_or(0), model.relative_accel});
}

}  // namespace

std::vector<std::string_view> export_formats() {
  std::vector<std::string_view> names;
  for (const Format& format : kFormats) names.push_back(format.name);
  return names;
}

std::string_view ending_of(std::string_view format) {
  const auto known = std::ranges::find(kFormats, format, &Format::name);
  return known == kFormats.end() ? std::string_view() : known->ending;
}

std::string content_sha256(std::string_view content) {
  base::Sha256 hash;
  hash.update(content);
  return base::to_hex(hash.finish());
}

base::Result<ExportedFile> export_model(const db::Catalog& catalog, const ExportRequest& request) {
  const auto model = load_model(catalog, request);
  if (!model) return base::forward_error(model);
  ExportedFile made;
  made.model = model->calibration.model_version;
  made.simulated = model->calibration.simulated;
  made.unreleased = model->calibration.unreleased;
  made.references = model->calibration.references;
  const auto since = withdrawn_since(catalog, model->calibration);
  if (!since) return base::forward_error(since);
  made.warnings = model->warnings;
  std::ranges::copy(*since, std::back_inserter(made.warnings));
  if (request.format == "px4" || request.format == "ardupilot") {
    auto file = render_autopilot(*model, request);
    if (!file) return base::forward_error(file);
    made.content = file->text;
    made.members = losses_json(*file);
    made.text = losses_text(*file);
    return made;
  }
  const auto calibration = table_or_curves(model->calibration, request);
  if (!calibration) return base::forward_error(calibration);
  auto content = calibration_content(*calibration, request);
  if (!content) return base::forward_error(content);
  made.content = *std::move(content);
  if (request.format == "blob") {
    const auto section = calib::signature_of(base::Bytes(made.content.begin(), made.content.end()));
    made.members = {{"key_id", section ? nlohmann::json(base::to_hex(section->key_id)) : nlohmann::json()}};
  }
  return made;
}

base::Result<ExportedFile> export_noise(const db::Catalog& catalog, const ExportRequest& request) {
  const auto noise = unit_noise(catalog, request.unit, request.simulated);
  if (!noise) return base::forward_error(noise);
  const auto file = calib::export_kalibr(noise->source, noise->axes);
  if (!file) return base::forward_error(file);
  return ExportedFile{file->text,
                      std::nullopt,
                      noise->source.simulated,
                      false,
                      noise_json(noise->source, *file),
                      noise_text(noise->source, *file),
                      {},
                      {}};
}

}  // namespace soak::station
