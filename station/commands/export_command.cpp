// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "calib/deploy/table_form.h"
#include "station/commands/command.h"
#include "station/commands/shared.h"
#include "station/io/host.h"
#include "station/io/output.h"
#include "station/io/text_file.h"
#include "station/records/signing.h"
#include "station/release/exported_file.h"
#include "station/release/hand_over.h"

namespace soak::station {
namespace {

/// soak export (--unit SN --format FORMAT -o FILE | --all --released --out FOLDER --sign KEY)
struct ExportCommand final : CatalogCommand {
  ExportRequest request;
  std::string file;
  bool all = false;       ///< every unit with a released model that keeps the rule
  bool released = false;  ///< said beside `all`
  std::string folder;     ///< of `all`
  std::string archive;    ///< of `all`: tar file of the folder, too; empty = none

  void declare(OptionList& options) override;
  base::Status run_with(db::Catalog& catalog, Output& output) override;
};

/// ACCEL_ID or ACCEL_ID,GYRO_ID; one number is both.
base::Status read_device_ids(const std::string& list, ExportRequest& request) {
  static const std::string kMustBe = "one or two whole numbers from 1 to 2147483647: ACCEL_ID or ACCEL_ID,GYRO_ID";
  std::vector<double> ids;
  if (auto read = number_list(ids, 1.0, 2147483647.0, kMustBe)(list); !read) return read;
  const bool whole = std::ranges::all_of(ids, [](double id) { return id == std::floor(id); });
  if (!whole || ids.size() > 2) return base::bad_input("must be " + kMustBe);
  request.accel_id = static_cast<std::int32_t>(ids.front());
  request.gyro_id = static_cast<std::int32_t>(ids.back());
  return {};
}

void ExportCommand::declare(OptionList& options) {
  options
      .add("--format FORMAT", &request.format,
           "blob: for the deployment runtime; c: the same as a C header; json: for people and scripts; px4, ardupilot: "
           "autopilot parameters; kalibr: noise values for imu.yaml; with --all by default blob")
      .one_of({"blob", "c", "json", "px4", "ardupilot", "kalibr"});
  options.add("-o,--output FILE", &file, "File to write");
  options.add("--released", &released, "Only released models; said beside --all");
  options.add("--out FOLDER", &folder, "New folder for the files and their signed manifest");
  options.add("--archive FILE.tar", &archive, "With --all: pack all of the folder into this file, too").needs("--all");
  options.add("--sign KEY", &request.sign,
              "blob: sign with this secret key ('soak key new' makes one); with --all the manifest, too");
  options.add("--unit SN", &request.unit, "Serial number of the unit").needs("--format").needs("--output");
  options.add("--all", &all, "Every unit with a released model that keeps the rule of release")
      .excludes("--unit")
      .needs("--released")
      .needs("--out")
      .needs("--sign");
  options.require_one_of({"--unit", "--all"}, "--unit SN or --all --released");
  options.add("--model V", &request.model, "Model version (default: the newest)").excludes("--all");
  options.add("--simulated", &request.simulated, "Export even if the model was made from simulated data");
  options.add("--unreleased", &request.unreleased, "Export even if the model is not released; the file says so")
      .excludes("--all");
  options.add("--table N", &request.table, "blob, c: every curve as a table of at most N points, for small controllers")
      .range(calib::kFewestTablePoints, calib::kMostTablePoints)
      .excludes("--all");
  options.add("--instance N", &request.instance, "px4, ardupilot: which of the vehicle's units, from 0 (default: 0)")
      .excludes("--all");
  options
      .add(
          "--device-id ACCEL[,GYRO]", [this](const std::string& list) { return read_device_ids(list, request); },
          "px4: CAL_ACCn_ID of the unit, and CAL_GYROn_ID if it differs")
      .excludes("--all");
}

/// Fails for options that the format does not have.
base::Status check_export_options(const ExportRequest& request) {
  const bool px4 = request.format == "px4";
  const bool kalibr = request.format == "kalibr";
  if (request.instance && !px4 && request.format != "ardupilot") {
    return base::bad_input("only valid for the formats px4 and ardupilot", "--instance");
  }
  if (!request.sign.empty() && request.format != "blob") {
    return base::bad_input("only valid for the format blob", "--sign");
  }
  if (request.table && request.format != "blob" && request.format != "c") {
    return base::bad_input("only valid for the formats blob and c", "--table");
  }
  if (request.accel_id && !px4) return base::bad_input("only valid for the format px4", "--device-id");
  if (kalibr && (request.model || request.unreleased)) {
    return base::bad_input("not valid for the format kalibr: its noise values come from runs, not from a model",
                           request.model ? "--model" : "--unreleased");
  }
  return {};
}

base::Status record_export(db::Catalog& catalog, const ExportRequest& request, const ExportedFile& made,
                           const std::string& sha256, const std::string& path) {
  if (made.model) {
    return catalog.add_calibration({request.unit, *made.model, now_utc_s(), request.format, sha256, path});
  }
  return catalog.log_event({now_utc_s(), "noise_exported", request.unit, request.format + " to " + path});
}

base::Status export_one(db::Catalog& catalog, const ExportCommand& command, Output& output) {
  const ExportRequest& request = command.request;
  if (auto known = check_export_options(request); !known) return known;
  output.begin("exporting");
  const auto made = request.format == "kalibr" ? export_noise(catalog, request) : export_model(catalog, request);
  if (!made) return base::forward_error(made);
  if (auto written = write_text_file(command.file, made->content); !written) return written;

  const std::string sha256 = content_sha256(made->content);
  const std::string path = std::filesystem::absolute(command.file).string();
  for (const calib::Warning& warning : made->warnings) output.note("warning: " + warning.text);
  note_waivers(made->references, output);
  std::vector<calib::Warning> warnings = made->warnings;
  std::ranges::copy(waiver_warnings(made->references), std::back_inserter(warnings));
  if (auto recorded = record_export(catalog, request, *made, sha256, path); !recorded) return recorded;
  if (output.json()) {
    nlohmann::json document = {{"unit", request.unit},
                               {"model", made->model ? nlohmann::json(*made->model) : nlohmann::json()},
                               {"format", request.format},
                               {"file", path},
                               {"bytes", made->content.size()},
                               {"sha256", sha256},
                               {"simulated", made->simulated},
                               {"unreleased", made->unreleased},
                               {"warnings", warnings_json(warnings)}};
    document.update(made->members);
    return output.print_json(document);
  }
  output.print(fmt::format("{}: unit {}, {}{} bytes{}{}\n{}", command.file, request.unit,
                           made->model ? fmt::format("model {}, ", *made->model) : "", made->content.size(),
                           made->simulated ? ", SIMULATED" : "", made->unreleased ? ", NOT RELEASED" : "", made->text));
  return {};
}

base::Status export_all(db::Catalog& catalog, const ExportCommand& command, Output& output) {
  const std::string format = command.request.format.empty() ? "blob" : command.request.format;
  if (format == "kalibr") {
    return base::bad_input("kalibr cannot be released: its noise values come from runs, not from a model", "--format");
  }
  const auto handed =
      hand_over(catalog, {command.folder, format, command.request.sign, command.request.simulated, command.archive});
  if (!handed) return base::forward_error(handed);
  const std::string folder = std::filesystem::absolute(command.folder).string();
  if (output.json()) {
    nlohmann::json left_out = nlohmann::json::array();
    for (const LeftOut& unit : handed->left_out) {
      left_out.push_back({{"unit", unit.unit}, {"model", unit.model}, {"reasons", unit.reasons}});
    }
    nlohmann::json document = {{"folder", folder}, {"manifest", handed->manifest}, {"left_out", std::move(left_out)}};
    if (!command.archive.empty()) document["archive"] = std::filesystem::absolute(command.archive).string();
    return output.print_json(document);
  }
  for (const LeftOut& unit : handed->left_out) {
    output.note(fmt::format("left out: {}, model {}: {}", unit.unit, unit.model, fmt::join(unit.reasons, "; ")));
  }
  output.print(fmt::format("{}: {} files and their manifest, signed with key {}; {} units left out\n", command.folder,
                           handed->manifest["units"].size(), handed->manifest["key_id"].get<std::string>(),
                           handed->left_out.size()));
  return {};
}

base::Status ExportCommand::run_with(db::Catalog& catalog, Output& output) {
  if (all && !file.empty())
    return base::bad_input("is only valid with --unit: --all writes to --out FOLDER", "--output");
  if (all) return export_all(catalog, *this, output);
  if (released || !folder.empty()) {
    return base::bad_input("is only valid with --all: a single unit is exported with -o FILE",
                           released ? "--released" : "--out");
  }
  return export_one(catalog, *this, output);
}

}  // namespace

CommandGroup export_commands() {
  return {"",
          "",
          {{"export", "Write a unit's calibration file, or those of all released models with a signed manifest",
            "soak export --unit SN0042 --format blob -o SN0042.soakcal", std::make_shared<ExportCommand>()}}};
}

}  // namespace soak::station
