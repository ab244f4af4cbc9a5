// SPDX-License-Identifier: Apache-2.0
#include "station/jobs/job.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <nlohmann/json.hpp>

#include "base/text.h"
#include "calib/deploy/calibration_file.h"
#include "calib/model/model_document.h"
#include "station/io/data_folder.h"
#include "station/io/text.h"
#include "station/io/text_file.h"
#include "station/records/station_key.h"
#include "station/release/exported_file.h"
#include "station/report/unit_overview.h"

namespace soak::station {
namespace {

using nlohmann::json;

constexpr std::array<std::string_view, 13> kKinds = {"fit",      "verify",     "report",  "release",  kFitAll,
                                                     kVerifyAll, kReleaseAll,  "export",  kExportAll, kReportCampaign,
                                                     "gap_find", "gap_accept", "gap_show"};
constexpr const char* kHandOverFolder = "hand-over";  // in the folder of the job
constexpr std::string_view kProgressEnd = " %";
constexpr std::string_view kNobodyKnows = "...";
constexpr std::size_t kLongestStem = 60;

/// Runs that the model was fitted to cannot judge it.
base::Status check_fresh(const db::Catalog& catalog, const JobRequest& request) {
  const auto unit = unit_overview(catalog, request.unit);
  if (!unit) return base::forward_error(unit);
  const json& fresh = (*unit)["verify_with"];
  if (std::ranges::any_of(fresh, [&](const json& entry) { return entry["campaign"] == request.campaign; })) return {};
  return base::bad_input("the campaign has no runs that the newest model has not seen", "campaign");
}

/// Put into the job's folder here, and not by `soak export`: nothing leaves the laboratory, so nothing is recorded.
base::Result<std::filesystem::path> calibration_file(const db::Catalog& catalog, const JobRequest& request,
                                                     const std::filesystem::path& folder) {
  const auto model = catalog.model(request.unit);
  if (!model) return base::forward_error(model);
  if (!*model) return base::bad_input(fmt::format("unit {} has no model yet: fit it first", request.unit), "unit");
  const auto calibration = calib::calibration_of((*model)->document);
  if (!calibration) return base::forward_error(calibration);
  const auto bytes = calib::encode(*calibration);
  if (!bytes) return base::forward_error(bytes);
  std::filesystem::path file = folder / "verified.soakcal";
  if (auto written = write_text_file(file, std::string(bytes->begin(), bytes->end())); !written) {
    return base::forward_error(written);
  }
  return file;
}

/// The model that an export is asked of; none where the unit has none, or not that version.
base::Result<std::optional<db::ModelHead>> exported_model(const db::Catalog& catalog, const JobRequest& request) {
  const auto heads = catalog.models(request.unit);
  if (!heads) return base::forward_error(heads);
  if (heads->empty()) return std::nullopt;
  if (!request.model) return heads->back();
  const auto found = std::ranges::find(*heads, *request.model, &db::ModelHead::version);
  return found == heads->end() ? std::nullopt : std::optional(*found);
}

/// Whether the file of a model is one that is not released yet, and is marked. `soak export` refuses that of a
/// withdrawn one; kalibr's is of runs, not of a model.
base::Result<bool> is_marked(const db::Catalog& catalog, const JobRequest& request) {
  if (request.format == "kalibr") return false;
  const auto model = exported_model(catalog, request);
  if (!model) return base::forward_error(model);
  return *model && ((*model)->state == "fitted" || (*model)->state == "verified");
}

base::Status check_version(const db::Catalog& catalog, const JobRequest& request) {
  if (!request.model) return {};
  if (request.kind != "export" || request.format == "kalibr") {
    return base::bad_input("only an export that is of a model takes a version", "model");
  }
  const auto model = exported_model(catalog, request);
  if (!model) return base::forward_error(model);
  if (*model) return {};
  return base::bad_input(fmt::format("unit {} has no model {}", request.unit, *request.model), "model");
}

base::Status check_device_ids(const JobRequest& request) {
  const bool is_px4 = request.kind == "export" && request.format == "px4";
  if (request.accel_id && !is_px4) return base::bad_input("only an export as px4 takes device ids", "accel_id");
  if (request.gyro_id && !request.accel_id) {
    return base::bad_input("the id of the accelerometers is missing beside it", "accel_id");
  }
  return {};
}

base::Status check_key(const db::Catalog& catalog) {
  std::error_code unreadable;  // then it is as good as none
  if (std::filesystem::exists(station_key_file(catalog.data_folder()), unreadable)) return {};
  return base::bad_input("the station has no key to sign with: make one first, in Records", "sign");
}

base::Status check_export_all(const db::Catalog& catalog, const JobRequest& request) {
  if (request.format == "kalibr" || ending_of(request.format).empty()) {
    return base::bad_input("there is no such format of a model: blob, c, json, px4 or ardupilot", "format");
  }
  return check_key(catalog);
}

/// A job of several units: of a verification and of a report the campaign is known.
base::Status check_of_all(const db::Catalog& catalog, const JobRequest& request) {
  if (!request.unit.empty()) {
    return base::bad_input(fmt::format("{} is of all units: leave it out", request.kind), "unit");
  }
  if (request.kind == kExportAll) return check_export_all(catalog, request);
  if (request.kind != kVerifyAll && request.kind != kReportCampaign) return {};
  const auto campaigns = catalog.campaigns();
  if (!campaigns) return base::forward_error(campaigns);
  if (std::ranges::find(*campaigns, request.campaign) != campaigns->end()) return {};
  return base::bad_input("the campaign is missing, or there is none of that name", "campaign");
}

JobCommand export_all_command(const db::Catalog& catalog, const JobRequest& request,
                              const std::filesystem::path& folder) {
  const std::string name = fmt::format("{}.tar", kHandOverFolder);
  JobCommand command{
      {"export", "--all", "--released", "--format=" + request.format, "--out=" + (folder / kHandOverFolder).string(),
       "--archive=" + (folder / name).string(), "--sign=" + station_key_file(catalog.data_folder()).string()},
      name};
  if (request.simulated) command.arguments.emplace_back("--simulated");
  return command;
}

JobCommand command_of_all(const db::Catalog& catalog, const JobRequest& request, const std::filesystem::path& folder) {
  if (request.kind == kExportAll) return export_all_command(catalog, request, folder);
  if (request.kind == kReportCampaign) {
    const std::string name = plain_file_name(request.campaign.substr(0, kLongestStem)) + ".html";
    return {{"report", "--campaign=" + request.campaign, "--output=" + (folder / name).string()}, name};
  }
  if (request.kind == kFitAll) return {{"fit", "--all", "--brief"}, ""};
  if (request.kind == kVerifyAll) {
    return {{"verify", "--all", "--campaign=" + request.campaign, "--keep=" + (folder / kKeptVerdicts).string()}, ""};
  }
  return {{"release", "--all"}, ""};
}

/// The step that a line of standard error tells, as Output::progress() and Output::begin() write it; none where it is
/// another line.
std::optional<JobStep> step_of(std::string_view line) {
  constexpr std::string_view kBegin = "soak: ";
  if (!line.starts_with(kBegin)) return std::nullopt;
  line = line.substr(kBegin.size(), line.find('\n') - kBegin.size());
  const std::size_t colon = line.rfind(": ");
  if (colon == std::string_view::npos) return std::nullopt;
  const std::string_view told = line.substr(colon + 2);
  JobStep step{std::string(line.substr(0, colon)), std::nullopt};
  if (told == kNobodyKnows) return step;
  if (!told.ends_with(kProgressEnd)) return std::nullopt;
  const auto percent = base::parse_int(told.substr(0, told.size() - kProgressEnd.size()));
  if (!percent || *percent < 0 || *percent > 100) return std::nullopt;
  step.share = static_cast<double>(*percent) / 100.0;
  return step;
}

/// Takes the first line off, with its end.
std::string_view take_line(std::string_view& text) {
  const std::string_view line = text.substr(0, std::min(text.find('\n'), text.size() - 1) + 1);
  text.remove_prefix(line.size());
  return line;
}

/// What was said beside what it did and how far it was.
std::string without_steps(std::string_view errors) {
  std::string rest;
  while (!errors.empty()) {
    const std::string_view line = take_line(errors);
    if (!step_of(line)) rest += line;
  }
  return rest;
}

/// Takes over the members that there are.
json part_of(const json& document, std::initializer_list<const char*> members) {
  json part = json::object();
  for (const char* member : members) {
    if (const auto found = document.find(member); found != document.end()) part[member] = *found;
  }
  return part;
}

/// What became of each unit: `units` in the folder, `skipped` with why not.
json handed_over(const json& document) {
  json result = part_of(document.value("manifest", json::object()), {"key_id", "file_format"});
  result["units"] = json::array();
  for (const json& unit : document.value("/manifest/units"_json_pointer, json::array())) {
    result["units"].push_back(part_of(unit, {"unit", "model", "file", "simulated", "expires"}));
  }
  result["skipped"] = json::array();
  for (const json& unit : document.value("left_out", json::array())) {
    const auto reasons = unit.value("reasons", std::vector<std::string>());
    result["skipped"].push_back(
        {{"unit", unit.value("unit", "")}, {"message", fmt::format("{}", fmt::join(reasons, "; "))}});
  }
  return result;
}

}  // namespace

bool is_of_all(std::string_view kind) {
  return kind == kFitAll || kind == kVerifyAll || kind == kReleaseAll || kind == kExportAll || kind == kReportCampaign;
}

base::Status check_job(const db::Catalog& catalog, const JobRequest& request) {
  if (std::ranges::find(kKinds, request.kind) == kKinds.end()) {
    return base::bad_input(fmt::format("there is no such job; there are {}", fmt::join(kKinds, ", ")), "kind");
  }
  if (is_of_all(request.kind)) return check_of_all(catalog, request);
  const auto unit = catalog.unit(request.unit);
  if (!unit) return base::forward_error(unit);
  if (!*unit) return base::bad_input("there is no such unit; /api/v1/units lists those that there are", "unit");
  if (request.kind == "verify" && request.campaign.empty()) {
    return base::bad_input("the campaign of the fresh runs is missing", "campaign");
  }
  if (request.kind == "export" && ending_of(request.format).empty()) {
    return base::bad_input(fmt::format("there is no such format; there are {}", fmt::join(export_formats(), ", ")),
                           "format");
  }
  if (request.sign && (request.kind != "export" || request.format != "blob")) {
    return base::bad_input("only a calibration file (export as blob) can be signed", "sign");
  }
  if (request.sign) {
    if (auto key = check_key(catalog); !key) return key;
  }
  if (request.kind == "gap_accept" && request.effects.empty()) {
    return base::bad_input("the names of the effects to be accepted are missing", "effects");
  }
  if (auto ids = check_device_ids(request); !ids) return ids;
  return check_version(catalog, request);
}

base::Result<JobCommand> job_command(const db::Catalog& catalog, const JobRequest& request,
                                     const std::filesystem::path& folder) {
  // Each value in one word with its option: one that begins with a dash is a value all the same.
  const std::string unit = "--unit=" + request.unit;
  const auto output = [&](const std::string& name) { return "--output=" + (folder / name).string(); };
  const std::string stem = plain_file_name(request.unit.substr(0, kLongestStem));
  if (request.kind == "fit" || request.kind == "release") return JobCommand{{request.kind, unit}, ""};
  if (is_of_all(request.kind)) return command_of_all(catalog, request, folder);
  if (request.kind == "report") {
    const std::string name = stem + ".html";
    return JobCommand{{"report", unit, output(name)}, name};
  }
  if (request.kind == "verify") {
    const auto file = calibration_file(catalog, request, folder);
    if (!file) return base::forward_error(file);
    if (auto fresh = check_fresh(catalog, request); !fresh) return base::forward_error(fresh);
    return JobCommand{{"verify", file->string(), "--campaign=" + request.campaign}, ""};
  }
  if (request.kind.starts_with("gap_")) {
    JobCommand command{{"gap", request.kind.substr(4), unit}, ""};
    if (request.kind == "gap_accept") {
      for (const std::string& effect : request.effects) command.arguments.push_back("--effect=" + effect);
    }
    return command;
  }
  const auto marked = is_marked(catalog, request);
  if (!marked) return base::forward_error(marked);
  const std::string name = stem + (*marked ? ".unreleased" : "") + std::string(ending_of(request.format));
  JobCommand command{{"export", unit, "--format=" + request.format, output(name)}, name};
  if (request.model) command.arguments.push_back(fmt::format("--model={}", *request.model));
  if (*marked) command.arguments.emplace_back("--unreleased");
  if (request.simulated) command.arguments.emplace_back("--simulated");
  if (request.accel_id) {
    command.arguments.push_back(
        fmt::format("--device-id={},{}", *request.accel_id, request.gyro_id.value_or(*request.accel_id)));
  }
  if (request.sign) command.arguments.push_back("--sign=" + station_key_file(catalog.data_folder()).string());
  return command;
}

json job_result(const std::string& kind, const std::string& output) {
  json document = json::parse(output, nullptr, false);
  if (!document.is_object()) return nullptr;
  if (kind == "fit") return part_of(document, {"unit", "model", "epoch", "simulated"});
  if (kind == kExportAll) return handed_over(document);
  if (kind == kReportCampaign) return part_of(document, {"campaign", "units", "bytes", "sha256"});
  if (kind == "verify" || is_of_all(kind) || kind.starts_with("gap_")) return document;
  if (kind == "release") {
    return part_of(document.value("/units/0"_json_pointer, json::object()),
                   {"unit", "model", "state", "simulated", "expires"});
  }
  if (kind == "export") {
    return part_of(document, {"unit", "model", "format", "bytes", "sha256", "key_id", "simulated", "unreleased",
                              "warnings", "notes", "cubic"});
  }
  json part = part_of(document, {"unit", "model", "bytes", "sha256"});
  part.update(part_of(document.value("/sections/summary"_json_pointer, json::object()), {"verdict", "sentence"}));
  return part;
}

base::Result<std::optional<std::int32_t>> job_model(const db::Catalog& catalog, const JobRequest& request) {
  const bool is_of_none =
      request.kind == "fit" || is_of_all(request.kind) || (request.kind == "export" && request.format == "kalibr");
  if (is_of_none) return std::nullopt;
  const auto model = exported_model(catalog, request);
  if (!model) return base::forward_error(model);
  return *model ? std::optional((*model)->version) : std::nullopt;
}

std::optional<JobStep> job_step(std::string_view errors) {
  std::optional<JobStep> last;
  while (!errors.empty()) {
    if (auto step = step_of(take_line(errors))) last = std::move(step);
  }
  return last;
}

std::string job_message(const ChildEnd& end) {
  const std::string errors = without_steps(end.errors);
  // Remarks come before the error, which is a document of its own.
  const std::size_t newline = errors.rfind("\n{");
  const std::size_t begin = newline == std::string::npos ? 0 : newline + 1;
  const json document = json::parse(errors.substr(begin), nullptr, false);
  if (document.is_object() && document.contains("error")) {
    const json& error = document["error"];
    const std::string where = error.value("where", "");
    return (where.empty() ? "" : where + ": ") + error.value("message", "");
  }
  if (!errors.empty()) return errors.substr(errors.size() - std::min<std::size_t>(errors.size(), 2000));
  if (end.exit_status > 128) return fmt::format("ended by signal {}", end.exit_status - 128);
  return fmt::format("ended with status {}", end.exit_status);
}

json kept_verdicts(const std::filesystem::path& folder) {
  std::ifstream file(folder / kKeptVerdicts);
  if (!file) return nullptr;
  json result;
  for (const char* list : {"units", "skipped", "not_verified"}) result[list] = json::array();
  for (std::string line; std::getline(file, line);) {
    const json kept = json::parse(line, nullptr, false);
    if (!kept.is_object() || kept.size() != 1 || !result.contains(kept.begin().key())) continue;
    result[kept.begin().key()].push_back(kept.begin().value());
  }
  return result;
}

}  // namespace soak::station
