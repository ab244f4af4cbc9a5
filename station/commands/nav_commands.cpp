// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <iterator>
#include <nlohmann/json.hpp>
#include <system_error>

#include "calib/model/model_document.h"
#include "station/commands/command.h"
#include "station/commands/shared.h"
#include "station/io/data_folder.h"
#include "station/io/host.h"
#include "station/io/text_file.h"
#include "station/nav/drive_file.h"
#include "station/nav/free_inertial.h"
#include "station/nav/nav_json.h"
#include "station/nav/outage_batch.h"
#include "station/nav/simulated_drive.h"
#include "station/nav/unit_drives.h"
#include "station/records/calibration_reader.h"
#include "station/report/page.h"

namespace soak::station {
namespace {

using nlohmann::json;

/// Simulated drives from which an ANFIS learns, with seeds that no compared drive has.
constexpr std::size_t kDrivesToLearnFrom = 8;
constexpr std::uint64_t kSeedsToLearnFrom = 1'000'000'000'000;

/// What all comparisons ask for.
struct OutageOptions {
  std::size_t number = 0;  ///< of outages on each drive
  double length_s = 30.0;
  double first_s = 120.0;
  std::size_t seed = 1;
  int jobs = 0;
  std::string file{};

  void declare(OptionList& options) {
    options.add("--number N", &number, "Outages on each drive, evenly spread").range(1, 1000).with_default();
    options.add("--length-s S", &length_s, "Length of an outage").range(1.0, 3600.0).with_default();
    options.add("--first-s S", &first_s, "The first outage begins so long after the drive")
        .range(0.0, 1e6)
        .with_default();
    options.add("--seed N", &seed, "Seed of all that is random").range(0, 1e9).with_default();
    options.add("--jobs N", &jobs, "Threads (default: one per processor)").range(0, 1024);
    options.add("-o,--output FILE.html", &file, "Also write a page with tracks and errors over time to this file");
  }

  /// Before anything that takes long: whether the page that was asked for can be written.
  [[nodiscard]] base::Status check_file() const { return file.empty() ? base::Status() : check_writable(file); }

  /// Runs the outages on all drives; the comparison's document with `more` in it. Writes the page that was asked for,
  /// which begins with the sentence `about` what was compared.
  [[nodiscard]] base::Result<json> compare(const std::vector<nav::Drive>& drives,
                                           const std::vector<nav::Pipeline>& pipelines, const json& more,
                                           const std::string& about, Output& output) const {
    std::vector<OutageTask> tasks;
    for (std::size_t d = 0; d < drives.size(); ++d) {
      const auto outages = nav::spread_outages(drives[d], first_s, length_s, number);
      if (!outages) return base::forward_error(outages);
      for (const nav::Outage& outage : *outages) tasks.push_back({d, outage});
    }
    const auto results = run_outages(drives, tasks, pipelines, jobs, output.progress("outages"));
    output.end_progress();
    if (!results) return base::forward_error(results);
    std::vector<nav::Innovations> fixes;
    for (const nav::Drive& drive : drives) {
      const auto found = nav::innovations_of(drive, raw_filter());
      if (!found) return base::forward_error(found);
      fixes.push_back(*found);
    }
    json document = comparison_json(drives, fixes, *results, pipelines, length_s, seed);
    document.update(more);
    if (!file.empty()) {
      const std::string page = outages_page(document, *results, about, "soak " + software_version(), now_utc_s());
      if (const auto written = write_text_file(file, page); !written) return base::forward_error(written);
    }
    return document;
  }
};

std::vector<std::string> further_names() { return {std::begin(kFurtherPipelines), std::end(kFurtherPipelines)}; }

/// Adds the further pipelines that were asked for; `learn_from` makes the drives of which an ANFIS learns, where one
/// is.
base::Status add_further(const std::vector<std::string>& names,
                         const std::function<base::Result<std::vector<nav::Drive>>()>& learn_from,
                         std::vector<nav::Pipeline>& pipelines) {
  std::optional<nav::ErrorModel> model;
  if (needs_learning(names)) {
    const auto drives = learn_from();
    if (!drives) return base::forward_error(drives);
    auto learnt = learnt_errors(*drives);
    if (!learnt) return base::forward_error(learnt);
    model = *std::move(learnt);
  }
  std::ranges::move(further_pipelines(names, model), std::back_inserter(pipelines));
  return {};
}

/// soak nav outages FILE...
struct NavOutages final : Command {
  std::vector<std::string> files;
  std::vector<std::string> also;
  std::vector<std::string> learn;
  std::string calibration;
  OutageOptions outages{12};

  void declare(OptionList& options) override {
    options.add("file FILE.toml", &files, "Drive files: each describes a recording of unit, fixes and truth")
        .required();
    options.add("--calibration FILE.blob", &calibration,
                "Calibration file of the unit: adds the pipeline 'calibrated'; the recording needs temperatures");
    options.add("--also NAME", &also, "A further pipeline, of the thesis; may be repeated").one_of(further_names());
    options.add("--learn FILE.toml", &learn, "Other drives, from which the ANFIS pipelines learn; may be repeated");
    outages.declare(options);
  }
  base::Status run(Output& output) override;

 private:
  [[nodiscard]] base::Result<std::vector<nav::Drive>> drives_to_learn_from() const;
  [[nodiscard]] std::vector<std::string> learnt_and_judged() const;
};

base::Result<std::vector<nav::Drive>> NavOutages::drives_to_learn_from() const {
  if (learn.empty()) {
    return base::bad_input("an ANFIS pipeline needs --learn FILE.toml: other drives, from which it learns", "--also");
  }
  std::vector<nav::Drive> drives;
  for (const std::string& file : learn) {
    auto drive = read_drive(file);
    if (!drive) return base::forward_error(drive);
    drives.push_back(*std::move(drive));
  }
  return drives;
}

/// Judged files that the ANFIS learns from as well.
std::vector<std::string> NavOutages::learnt_and_judged() const {
  std::vector<std::string> both;
  for (const std::string& file : files) {
    const auto same = [&](const std::string& other) {
      std::error_code unknown;
      return std::filesystem::equivalent(file, other, unknown);
    };
    if (std::ranges::any_of(learn, same)) both.push_back(file);
  }
  return both;
}

/// Drives with readings at temperatures outside the calibration: their names and the shares of such readings.
json outside_calibration(const std::vector<nav::Drive>& drives, const DeviceCorrection& correction) {
  json outside = json::array();
  for (const nav::Drive& drive : drives) {
    const auto number =
        std::ranges::count_if(drive.imu, [&](const nav::ImuSample& s) { return correction.is_outside(s.temp_c); });
    if (number == 0) continue;
    const double share = static_cast<double>(number) / static_cast<double>(drive.imu.size());
    outside.push_back({{"drive", drive.name}, {"share", share}});
  }
  return outside;
}

base::Status NavOutages::run(Output& output) {
  if (auto writable = outages.check_file(); !writable) return writable;
  if (!learn.empty() && !needs_learning(also)) {
    return base::bad_input("only an ANFIS learns: --also anfis_position or --also anfis_updates must come with it",
                           "--learn");
  }
  std::vector<nav::Drive> drives;
  for (const std::string& file : files) {
    auto drive = read_drive(file);
    if (!drive) return base::forward_error(drive);
    const bool has_temp = !std::isnan(drive->imu.front().temp_c);
    if (!calibration.empty() && !has_temp) {
      return base::bad_input("--calibration needs a column temp_c in the readings of every drive", file);
    }
    drives.push_back(*std::move(drive));
  }
  std::optional<nav::Correction> correction;
  json more = json::object();
  if (!calibration.empty()) {
    const auto loaded = read_calibration(calibration);
    if (!loaded) return base::forward_error(loaded);
    const auto made = device_correction(loaded->bytes);
    if (!made) return base::fail(made.error().kind, made.error().message, calibration);
    correction = made->correct;
    more["uncorrected"] = json::array();
    for (const calib::Sensor sensor : made->raw) more["uncorrected"].push_back(calib::name_of(sensor));
    if (json outside = outside_calibration(drives, *made); !outside.empty()) more["outside_calibration"] = outside;
  }
  auto pipelines = standard_pipelines(correction);
  if (auto status = add_further(also, [this] { return drives_to_learn_from(); }, pipelines); !status) return status;
  if (auto both = learnt_and_judged(); !both.empty()) more["learnt_and_judged"] = std::move(both);
  const auto document = outages.compare(drives, pipelines, more, "", output);
  if (!document) return base::forward_error(document);
  if (output.json()) return output.print_json(*document);
  output.print(comparison_text(*document));
  return {};
}

/// soak nav compare
struct NavCompare final : Command {
  std::string errors = "ahrs400ca";
  std::size_t drives = 4;
  double temp_start_c = -10.0;
  double temp_end_c = 50.0;
  double left_percent = 1.0;
  std::vector<std::string> also;
  OutageOptions outages{6};

  void declare(OptionList& options) override {
    options.add("--errors UNIT", &errors, "Errors of the simulated unit, as its maker states them")
        .one_of({"ahrs400ca", "motionpak2", "isi"})
        .with_default();
    options.add("--drives N", &drives, "Simulated drives of ten minutes").range(1, 1000).with_default();
    options.add("--temp-start-c T", &temp_start_c, "Temperature at the start").range(-60.0, 120.0).with_default();
    options.add("--temp-end-c T", &temp_end_c, "Temperature that the unit tends to").range(-60.0, 120.0).with_default();
    options.add("--left-percent P", &left_percent, "What the calibration leaves of the simulated thermal bias")
        .range(0.0, 100.0)
        .with_default();
    options
        .add("--also NAME", &also,
             "A further pipeline, of the thesis; may be repeated. An ANFIS learns from eight other simulated drives")
        .one_of(further_names());
    outages.declare(options);
  }
  base::Status run(Output& output) override;
};

base::Status NavCompare::run(Output& output) {
  if (auto writable = outages.check_file(); !writable) return writable;
  DriveRequest request;
  request.errors = errors == "isi" ? nav::isi() : errors == "motionpak2" ? nav::motionpak2() : nav::ahrs400ca();
  request.temperature = {temp_start_c, temp_end_c, 200.0};
  request.thermal = example_curve;
  std::vector<nav::Drive> made;
  for (std::size_t d = 0; d < drives; ++d) {
    request.seed = outages.seed * 1000 + d;
    made.push_back(simulated_drive(request));
  }
  const auto learn_from = [&]() -> base::Result<std::vector<nav::Drive>> {
    std::vector<nav::Drive> others;
    for (std::size_t d = 0; d < kDrivesToLearnFrom; ++d) {
      request.seed = kSeedsToLearnFrom + outages.seed * 1000 + d;
      others.push_back(simulated_drive(request));
    }
    return others;
  };
  const double known = 1.0 - left_percent / 100.0;
  const auto correction =
      curve_correction([known](calib::Sensor sensor, double temp_c) { return known * example_curve(sensor, temp_c); });
  auto pipelines = standard_pipelines(correction);
  if (auto status = add_further(also, learn_from, pipelines); !status) return status;
  const json more = {{"simulated",
                      {{"errors", request.errors.name},
                       {"temp_start_c", temp_start_c},
                       {"temp_end_c", temp_end_c},
                       {"left_percent", left_percent}}}};
  const std::string about =
      fmt::format("Simulated drives, errors of {}, from {} to {} °C; the calibration leaves {} %.", errors,
                  temp_start_c, temp_end_c, left_percent);
  const auto document = outages.compare(made, pipelines, more, about, output);
  if (!document) return base::forward_error(document);
  if (output.json()) return output.print_json(*document);
  output.print(fmt::format("simulated drives, errors of {}, from {} to {} °C\n{}", errors, temp_start_c, temp_end_c,
                           comparison_text(*document)));
  return {};
}

/// soak nav impact --unit SN
struct NavImpact final : CatalogCommand {
  std::string unit;
  std::optional<int> model;
  std::optional<double> from_c;
  std::optional<double> to_c;
  std::size_t drives = kUnitDrives;
  OutageOptions outages{kOutagesOfUnitDrive, kUnitOutage_s, kFirstUnitOutage_s, kUnitDriveSeed};

  void declare(OptionList& options) override {
    options.add("--unit SN", &unit, "Serial number of the unit").required();
    options.add("--model V", &model, "Model version (default: the newest)");
    options.add("--from-c T", &from_c, "Temperature at power-on (default: the lowest of the calibration)")
        .range(-273.15, 1000.0);
    options.add("--to-c T", &to_c, "Temperature afterwards (default: the highest of the calibration)")
        .range(-273.15, 1000.0);
    options.add("--drives N", &drives, "Simulated drives of ten minutes").range(1, 1000).with_default();
    outages.declare(options);
  }
  base::Status run_with(db::Catalog& catalog, Output& output) override;

 private:
  [[nodiscard]] base::Result<TemperatureCourse> find_course(const calib::Calibration& calibration) const;
  [[nodiscard]] base::Result<json> drive(const calib::Calibration& calibration, const TemperatureCourse& course,
                                         int version, Output& output) const;
};

/// The temperatures at which all sensors were calibrated, narrowed to what was asked for.
base::Result<TemperatureCourse> NavImpact::find_course(const calib::Calibration& calibration) const {
  const auto range = whole_range(calibration);
  if (!range) {
    return base::bad_input(fmt::format("the sensors of unit {} were not calibrated at two common temperatures: record "
                                       "a campaign over a range of temperature, and fit again",
                                       unit),
                           unit);
  }
  const TemperatureCourse course{from_c.value_or(range->from_c), to_c.value_or(range->to_c)};
  const auto [low_c, high_c] = std::minmax(course.from_c, course.to_c);
  if (low_c >= range->from_c && high_c <= range->to_c && low_c != high_c) return course;
  return base::bad_input(
      fmt::format(
          "--from-c and --to-c must be two temperatures from {:.1f} to {:.1f} °C, where all sensors of unit {} were "
          "calibrated",
          range->from_c, range->to_c, unit),
      unit);
}

base::Result<json> NavImpact::drive(const calib::Calibration& calibration, const TemperatureCourse& course, int version,
                                    Output& output) const {
  const std::string about = fmt::format(
      "Simulated drives with the curves of unit {}, model {}{}, from {:.1f} to {:.1f} °C; other errors of {}.", unit,
      version, calibration.simulated ? " (SIMULATED)" : "", course.from_c, course.to_c, nav::ahrs400ca().name);
  return outages.compare(unit_drives(calibration, course, drives, outages.seed),
                         standard_pipelines(correction_by(calibration)), json::object(), about, output);
}

std::string impact_text(const json& document) {
  return fmt::format("unit {}, model {}{}, from {:.1f} to {:.1f} °C\n{}\nsimulated drives with this unit's curves\n{}",
                     document["unit"].get<std::string>(), document["model"].get<int>(),
                     document["simulated"].get<bool>() ? " (SIMULATED)" : "", document["from_c"].get<double>(),
                     document["to_c"].get<double>(), free_inertial_text(document["free_inertial"]),
                     comparison_text(document["drive"]));
}

base::Status NavImpact::run_with(db::Catalog& catalog, Output& output) {
  if (auto writable = outages.check_file(); !writable) return writable;
  if (const auto found = find_unit(catalog, unit); !found) return base::forward_error(found);
  const auto row = catalog.model(unit, model);
  if (!row) return base::forward_error(row);
  if (!*row) {
    return base::bad_input(model ? fmt::format("unit {} has no model version {}", unit, *model)
                                 : fmt::format("unit {} has no model yet; run 'soak fit --unit {}' first", unit, unit));
  }
  const auto calibration = calib::calibration_of((*row)->document);
  if (!calibration) return base::forward_error(calibration);
  const auto course = find_course(*calibration);
  if (!course) return base::forward_error(course);
  auto drive_document = drive(*calibration, *course, (*row)->version, output);
  if (!drive_document) return base::forward_error(drive_document);
  json document = impact_json(*calibration, *course);
  document["unit"] = unit;
  document["model"] = (*row)->version;
  document["simulated"] = calibration->simulated;
  document["drive"] = *std::move(drive_document);
  if (output.json()) return output.print_json(document);
  for (const calib::Warning& warning : scatter_warnings(*calibration)) output.note("warning: " + warning.text);
  output.print(impact_text(document));
  return {};
}

}  // namespace

CommandGroup nav_commands() {
  return {"nav",
          "What a calibration buys in navigation: metres in outages of satellite navigation",
          {{"impact", "Position errors from a unit's thermal bias, with and without its calibration",
            "soak nav impact --unit SN0042", std::make_shared<NavImpact>()},
           {"outages", "Outages on recorded drives, every pipeline on the same ones",
            "soak nav outages drive.toml --number 12 --length-s 30", std::make_shared<NavOutages>(), true,
            "docs/nav.md says what a drive file holds."},
           {"compare", "The same on simulated drives over a course of temperature",
            "soak nav compare --errors ahrs400ca --drives 4 --seed 1", std::make_shared<NavCompare>()}}};
}

}  // namespace soak::station
