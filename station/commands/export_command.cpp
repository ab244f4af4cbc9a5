// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <algorithm>
#include <cmath>
#include "base/hash.h"
#include "calib/deploy/calibration_file.h"
#include "calib/deploy/export.h"
#include "calib/deploy/signature.h"
#include "calib/deploy/table_form.h"
#include "calib/model/model_document.h"
#include "station/commands/command.h"
#include "station/commands/shared.h"
#include "station/io/data_folder.h"
#include "station/io/host.h"
#include "station/io/output.h"
#include "station/io/text_file.h"
#include "station/records/calibration_reader.h"
#include "station/records/key_file.h"
#include "station/records/signing.h"
#include "station/runs/signal_source.h"
#include "station/runs/still_segment.h"

namespace soak::station {
namespace {

/// soak export --unit SN --format FORMAT -o FILE
struct ExportCommand final : CatalogCommand {
  std::string unit;
  std::string format;
  std::string file;
  std::optional<int> model;              ///< version; absent = the newest
  bool simulated = false;                ///< the user knows that the model comes from simulated data
  std::optional<int> instance;           ///< px4, ardupilot: which of the vehicle's units, from 0; absent = 0
  std::optional<std::int32_t> accel_id;  ///< px4: device ids; absent = left to the user
  std::optional<std::int32_t> gyro_id;
  std::optional<int> table;  ///< blob, c: curves as tables of at most so many points; absent = as fitted
  std::string sign;          ///< blob: secret key file to sign with; empty = unsigned

  void declare(OptionList& options) override;
  base::Status run_with(db::Catalog& catalog, Output& output) override;
};

/// ACCEL_ID or ACCEL_ID,GYRO_ID; one number is both.
base::Status read_device_ids(const std::string& list, ExportCommand& command) {
  static const std::string kMustBe = "one or two whole numbers from 1 to 2147483647: ACCEL_ID or ACCEL_ID,GYRO_ID";
  std::vector<double> ids;
  if (auto read = number_list(ids, 1.0, 2147483647.0, kMustBe)(list); !read) return read;
  const bool whole = std::ranges::all_of(ids, [](double id) { return id == std::floor(id); });
  if (!whole || ids.size() > 2) return base::bad_input("must be " + kMustBe);
  command.accel_id = static_cast<std::int32_t>(ids.front());
  command.gyro_id = static_cast<std::int32_t>(ids.back());
  return {};
}

void ExportCommand::declare(OptionList& options) {
  options.add("--unit SN", &unit, "Serial number of the unit").required();
  options
      .add("--format FORMAT", &format,
           "blob: for the deployment runtime; c: the same as a C header; json: for people and scripts; px4, ardupilot: "
           "autopilot parameters; kalibr: noise values for imu.yaml")
      .required()
      .one_of({"blob", "c", "json", "px4", "ardupilot", "kalibr"});
  options.add("-o,--output FILE", &file, "File to write").required();
  options.add("--model V", &model, "Model version (default: the newest)");
  options.add("--simulated", &simulated, "Export even if the model was made from simulated data");
  options.add("--table N", &table, "blob, c: every curve as a table of at most N points, for small controllers")
      .range(calib::kFewestTablePoints, calib::kMostTablePoints);
  options.add("--sign KEY", &sign, "blob: sign with this secret key ('soak key new' makes one)");
  options.add("--instance N", &instance, "px4, ardupilot: which of the vehicle's units, from 0 (default: 0)");
  options.add(
      "--device-id ACCEL[,GYRO]", [this](const std::string& list) { return read_device_ids(list, *this); },
      "px4: CAL_ACCn_ID of the unit, and CAL_GYROn_ID if it differs");
}

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

/// What is exported: the file's content, and what the command prints about it.
struct Export {
  std::string content;
  std::optional<std::int32_t> model;  ///< version; absent: made of runs
  bool simulated = false;
  nlohmann::json members = nlohmann::json::object();  ///< of the document beyond those of every format
  std::string text;
  std::vector<calib::ReferenceUse> references;  ///< that the model's data were measured with
  std::vector<calib::Warning> warnings;         ///< of its fit, and what of its data was withdrawn afterwards
};

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

base::Result<LoadedModel> load_model(const db::Catalog& catalog, const ExportCommand& command) {
  const auto unit = find_unit(catalog, command.unit);
  if (!unit) return base::forward_error(unit);
  const auto row = catalog.model(command.unit, command.model);
  if (!row) return base::forward_error(row);
  if (!*row) {
    return base::bad_input(command.model ? fmt::format("unit {} has no model version {}", command.unit, *command.model)
                                         : fmt::format("unit {} has no model yet; run 'soak fit --unit {}' first",
                                                       command.unit, command.unit));
  }
  auto calibration = calib::calibration_of((*row)->document);
  if (!calibration) return base::forward_error(calibration);
  if ((*row)->epoch != unit->epoch) {
    return base::bad_input(
        fmt::format("model {} of unit {} belongs to epoch {}, but the unit is now in epoch {}: fit again",
                    (*row)->version, command.unit, (*row)->epoch, unit->epoch));
  }
  if (calibration->simulated && !command.simulated) {
    return base::bad_input(
        fmt::format("model {} of unit {} was made from SIMULATED data; use --simulated to export it anyway",
                    (*row)->version, command.unit));
  }
  return LoadedModel{*std::move(calibration), has_relative_accel((*row)->document), band_warnings((*row)->document)};
}

base::Result<calib::Calibration> table_or_curves(const calib::Calibration& calibration, const ExportCommand& command) {
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

base::Result<std::string> calibration_content(const calib::Calibration& calibration, const ExportCommand& command) {
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
  const auto since = withdrawn_since(catalog, model->calibration);
  if (!since) return base::forward_error(since);
  made.warnings = model->warnings;
  std::ranges::copy(*since, std::back_inserter(made.warnings));
  if (command.format == "px4" || command.format == "ardupilot") {
    auto file = render_autopilot(*model, command);
    if (!file) return base::forward_error(file);
    made.content = file->text;
    made.members = losses_json(*file);
    made.text = losses_text(*file);
    return made;
  }
  const auto calibration = table_or_curves(model->calibration, command);
  if (!calibration) return base::forward_error(calibration);
  auto content = calibration_content(*calibration, command);
  if (!content) return base::forward_error(content);
  made.content = *std::move(content);
  if (command.format == "blob") {
    const auto section = calib::signature_of(base::Bytes(made.content.begin(), made.content.end()));
    made.members = {{"key_id", section ? nlohmann::json(base::to_hex(section->key_id)) : nlohmann::json()}};
  }
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
                noise_json(noise->source, *file),
                noise_text(noise->source, *file),
                {},
                {}};
}

/// Fails for options that the format does not have.
base::Status check_export_options(const ExportCommand& command) {
  const bool px4 = command.format == "px4";
  if (command.instance && !px4 && command.format != "ardupilot") {
    return base::bad_input("only valid for the formats px4 and ardupilot", "--instance");
  }
  if (!command.sign.empty() && command.format != "blob") {
    return base::bad_input("only valid for the format blob", "--sign");
  }
  if (command.table && command.format != "blob" && command.format != "c") {
    return base::bad_input("only valid for the formats blob and c", "--table");
  }
  if (command.accel_id && !px4) return base::bad_input("only valid for the format px4", "--device-id");
  if (command.model && command.format == "kalibr") {
    return base::bad_input("not valid for the format kalibr: its noise values come from runs, not from a model",
                           "--model");
  }
  return {};
}

base::Status record_export(db::Catalog& catalog, const ExportCommand& command, const Export& made,
                           const std::string& sha256, const std::string& path) {
  if (made.model) {
    return catalog.add_calibration({command.unit, *made.model, now_utc_s(), command.format, sha256, path});
  }
  return catalog.log_event({now_utc_s(), "noise_exported", command.unit, command.format + " to " + path});
}

base::Status ExportCommand::run_with(db::Catalog& catalog, Output& output) {
  if (const auto known = check_export_options(*this); !known) return known;
  const auto made = format == "kalibr" ? export_noise(catalog, *this) : export_model(catalog, *this);
  if (!made) return base::forward_error(made);
  if (const auto written = write_text_file(file, made->content); !written) return written;

  base::Sha256 hash;
  hash.update(made->content);
  const std::string sha256 = base::to_hex(hash.finish());
  const std::string path = std::filesystem::absolute(file).string();
  for (const calib::Warning& warning : made->warnings) output.note("warning: " + warning.text);
  note_waivers(made->references, output);
  std::vector<calib::Warning> warnings = made->warnings;
  std::ranges::copy(waiver_warnings(made->references), std::back_inserter(warnings));
  if (auto recorded = record_export(catalog, *this, *made, sha256, path); !recorded) return recorded;
  if (output.json()) {
    nlohmann::json document = {{"unit", unit},
                               {"model", made->model ? nlohmann::json(*made->model) : nlohmann::json()},
                               {"format", format},
                               {"file", path},
                               {"bytes", made->content.size()},
                               {"sha256", sha256},
                               {"simulated", made->simulated},
                               {"warnings", warnings_json(warnings)}};
    document.update(made->members);
    return output.print_json(document);
  }
  output.print(fmt::format("{}: unit {}, {}{} bytes{}\n{}", file, unit,
                           made->model ? fmt::format("model {}, ", *made->model) : "", made->content.size(),
                           made->simulated ? ", SIMULATED" : "", made->text));
  return {};
}

}  // namespace

CommandGroup export_commands() {
  return {"",
          "",
          {{"export", "Write a unit's calibration file", "soak export --unit SN0042 --format blob -o SN0042.soakcal",
            std::make_shared<ExportCommand>()}}};
}

}  // namespace soak::station
