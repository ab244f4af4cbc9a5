// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "base/hash.h"
#include "calib/deploy/calibration_file.h"
#include "calib/deploy/export.h"
#include "calib/deploy/table_form.h"
#include "calib/model/model_document.h"
#include "station/commands/calibration_commands.h"
#include "station/commands/export_noise.h"
#include "station/commands/export_text.h"
#include "station/commands/waiver_note.h"
#include "station/io/data_folder.h"
#include "station/io/host.h"
#include "station/io/text_file.h"
#include "station/records/calibration_reader.h"
#include "station/records/key_file.h"
#include "station/records/signing.h"

namespace soak::station {
namespace {

/// What an export makes: the file's content, and what the command says of it.
struct Export {
  std::string content;
  std::optional<std::int32_t> model;  ///< version; absent: made of runs
  bool simulated = false;
  nlohmann::json members = nlohmann::json::object();  ///< of the document beyond those of every format
  std::string text;
  std::vector<calib::ReferenceUse> references;  ///< that the model rests on
  std::vector<calib::Warning> since;            ///< what of its data was withdrawn after the fit
};

struct LoadedModel {
  calib::Calibration calibration;
  bool relative_accel = false;
};

/// Whether the model says of an accelerometer that its bias has no level of its own.
bool has_relative_accel(const std::string& document) {
  const auto json = nlohmann::json::parse(document, nullptr, false);
  const nlohmann::json::json_pointer sensors("/fit/sensors");
  if (json.is_discarded() || !json.contains(sensors)) return false;
  for (const auto& [name, sensor] : json[sensors].items()) {
    if (name.starts_with("accel") && sensor.value("relative", false)) return true;
  }
  return false;
}

base::Result<LoadedModel> load_model(const db::Catalog& catalog, const ExportCommand& command) {
  const auto unit = catalog.unit(command.unit);
  if (!unit) return base::forward_error(unit);
  if (!*unit)
    return base::bad_input(fmt::format("no unit '{}' in this data folder; 'soak unit list' shows them", command.unit));
  const auto row = catalog.model(command.unit, command.model);
  if (!row) return base::forward_error(row);
  if (!*row) {
    return base::bad_input(command.model ? fmt::format("unit {} has no model version {}", command.unit, *command.model)
                                         : fmt::format("unit {} has no model yet; run 'soak fit --unit {}' first",
                                                       command.unit, command.unit));
  }
  auto calibration = calib::calibration_of((*row)->document);
  if (!calibration) return base::forward_error(calibration);
  if ((*row)->epoch != (*unit)->epoch) {
    return base::bad_input(fmt::format("model {} of unit {} belongs to epoch {}, the unit is in epoch {}: fit again",
                                       (*row)->version, command.unit, (*row)->epoch, (*unit)->epoch));
  }
  if (calibration->simulated && !command.simulated) {
    return base::bad_input(
        fmt::format("model {} of unit {} comes from SIMULATED data; --simulated exports it all the same",
                    (*row)->version, command.unit));
  }
  return LoadedModel{*std::move(calibration), has_relative_accel((*row)->document)};
}

base::Result<calib::Calibration> in_form(const calib::Calibration& calibration, const ExportCommand& command) {
  if (!command.table) return calibration;
  return calib::table_form(calibration, *command.table);
}

base::Result<base::Bytes> blob(const calib::Calibration& calibration, const std::string& key_path) {
  auto bytes = calib::encode(calibration);
  if (!bytes || key_path.empty()) return bytes;
  const auto key = read_secret_key(key_path);
  if (!key) return base::forward_error(key);
  return signed_file(*bytes, key->key);
}

base::Result<std::string> render(const calib::Calibration& calibration, const ExportCommand& command) {
  if (command.format == "json") return calib::export_json(calibration);
  if (command.format == "c") return calib::export_c(calibration);
  const auto bytes = blob(calibration, command.sign);
  if (!bytes) return base::forward_error(bytes);
  return std::string(bytes->begin(), bytes->end());
}

base::Result<calib::AutopilotFile> render_autopilot(const LoadedModel& model, const ExportCommand& command) {
  if (command.format == "px4") {
    return calib::export_px4(model.calibration,
                             {command.instance.value_or(0), command.accel_id, command.gyro_id, model.relative_accel});
  }
  return calib::export_ardupilot(model.calibration, {command.instance.value_or(0), model.relative_accel});
}

base::Result<Export> export_model(const db::Catalog& catalog, const ExportCommand& command) {
  const auto model = load_model(catalog, command);
  if (!model) return base::forward_error(model);
  Export made;
  made.model = model->calibration.model_version;
  made.simulated = model->calibration.simulated;
  made.references = model->calibration.references;
  auto since = withdrawn_since(catalog, model->calibration);
  if (!since) return base::forward_error(since);
  made.since = *std::move(since);
  if (command.format == "px4" || command.format == "ardupilot") {
    auto file = render_autopilot(*model, command);
    if (!file) return base::forward_error(file);
    made.content = file->text;
    made.members = losses_document(*file);
    made.text = losses_text(*file);
    return made;
  }
  const auto calibration = in_form(model->calibration, command);
  if (!calibration) return base::forward_error(calibration);
  auto content = render(*calibration, command);
  if (!content) return base::forward_error(content);
  made.content = *std::move(content);
  return made;
}

base::Result<Export> export_noise(const db::Catalog& catalog, const ExportCommand& command) {
  const auto noise = unit_noise(catalog, command.unit, command.simulated);
  if (!noise) return base::forward_error(noise);
  const auto file = calib::export_kalibr(noise->source, noise->axes);
  if (!file) return base::forward_error(file);
  return Export{file->text,
                std::nullopt,
                noise->source.simulated,
                noise_document(noise->source, *file),
                noise_text(noise->source, *file),
                {},
                {}};
}

/// Refuses formats that are none and options that mean nothing to the format.
base::Status check(const ExportCommand& command) {
  static constexpr std::string_view kFormats = " blob c json px4 ardupilot kalibr ";
  if (kFormats.find(" " + command.format + " ") == std::string_view::npos) {
    return base::bad_input(
        fmt::format("unknown format '{}'; known: blob, c, json, px4, ardupilot, kalibr", command.format), "--format");
  }
  const bool px4 = command.format == "px4";
  if (command.instance && !px4 && command.format != "ardupilot") {
    return base::bad_input("only px4 and ardupilot number their sensors", "--instance");
  }
  if (!command.sign.empty() && command.format != "blob") {
    return base::bad_input("only blob carries a signature", "--sign");
  }
  if (command.table && command.format != "blob" && command.format != "c") {
    return base::bad_input("only blob and c have a table form", "--table");
  }
  if (command.accel_id && !px4) return base::bad_input("only px4 binds parameters to device ids", "--device-id");
  if (command.model && command.format == "kalibr") {
    return base::bad_input("kalibr's noise comes from the runs, not from a model: leave the option out", "--model");
  }
  return {};
}

nlohmann::json warnings_document(const Export& made) {
  nlohmann::json list = nlohmann::json::array();
  for (const auto& warnings : {made.since, waiver_warnings(made.references)}) {
    for (const calib::Warning& warning : warnings) list.push_back({{"code", warning.code}, {"text", warning.text}});
  }
  return list;
}

base::Status record(db::Catalog& catalog, const ExportCommand& command, const Export& made, const std::string& sha256,
                    const std::string& path) {
  if (made.model) {
    return catalog.add_calibration({command.unit, *made.model, now_utc_s(), command.format, sha256, path});
  }
  return catalog.log_event({now_utc_s(), "noise_exported", command.unit, command.format + " to " + path});
}

}  // namespace

base::Status run_export(const ExportCommand& command, Output& output) {
  if (const auto known = check(command); !known) return known;
  auto catalog = open_existing_catalog(command.data);
  if (!catalog) return base::forward_error(catalog);
  const auto made = command.format == "kalibr" ? export_noise(*catalog, command) : export_model(*catalog, command);
  if (!made) return base::forward_error(made);
  if (const auto written = write_text_file(command.file, made->content); !written) return written;

  base::Sha256 hash;
  hash.update(made->content);
  const std::string sha256 = base::to_hex(hash.finish());
  const std::string path = std::filesystem::absolute(command.file).string();
  for (const calib::Warning& warning : made->since) output.note("warning: " + warning.text);
  note_waivers(made->references, output);
  if (auto recorded = record(*catalog, command, *made, sha256, path); !recorded) return recorded;
  if (output.json()) {
    nlohmann::json document = {
        {"unit", command.unit},          {"model", made->model ? nlohmann::json(*made->model) : nlohmann::json()},
        {"format", command.format},      {"file", path},
        {"bytes", made->content.size()}, {"sha256", sha256},
        {"simulated", made->simulated},  {"warnings", warnings_document(*made)}};
    document.update(made->members);
    return output.print_json(document);
  }
  output.print(fmt::format("{}: unit {}, {}{} bytes{}\n{}", command.file, command.unit,
                           made->model ? fmt::format("model {}, ", *made->model) : "", made->content.size(),
                           made->simulated ? ", SIMULATED" : "", made->text));
  return {};
}

}  // namespace soak::station
