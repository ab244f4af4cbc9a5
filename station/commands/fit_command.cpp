// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include "base/text.h"
#include "base/units.h"
#include "calib/judge/chamber_time.h"
#include "calib/model/model_document.h"
#include "station/commands/command.h"
#include "station/commands/shared.h"
#include "station/fit/fit_batch.h"
#include "station/fit/fit_inputs.h"
#include "station/fit/fit_shard.h"
#include "station/fit/fit_unit.h"
#include "station/io/data_folder.h"
#include "station/io/host.h"
#include "station/io/text_file.h"

namespace soak::station {
namespace {

/// soak fit (--unit SN | --all)
struct FitCommand final : CatalogCommand {
  std::string unit;  ///< empty with `all`
  bool all = false;
  std::optional<std::string> campaign;
  std::optional<int> rules;  ///< absent = auto
  int jobs = 0;              ///< threads; 0 = one per core
  std::optional<ShardPart> shard;
  std::string shard_file;
  bool chamber_time = false;  ///< also what a shorter campaign would have given
  bool brief = false;         ///< of many units only what became of each

  void declare(OptionList& options) override;
  base::Status run_with(db::Catalog& catalog, Output& output) override;

 protected:
  base::Result<db::Catalog> open_data() const override {
    return shard ? open_unchanged_catalog(data) : CatalogCommand::open_data();
  }

 private:
  base::Status fit_one(db::Catalog& catalog, Output& output) const;
  base::Status fit_all(const db::Catalog& catalog, Output& output) const;
  base::Status fit_part(const db::Catalog& catalog, Output& output) const;
};

void FitCommand::declare(OptionList& options) {
  const OptionReader read_rules = [this](const std::string& text) -> base::Status {
    rules.reset();
    if (text == "auto") return {};
    const auto number = base::parse_int(text);
    if (!number || *number < 2 || *number > 64) return base::bad_input("must be auto or a number from 2 to 64");
    rules = static_cast<int>(*number);
    return {};
  };
  const OptionReader read_part = [this](const std::string& text) -> base::Status {
    const auto part = parse_shard_part(text);
    if (!part) return base::forward_error(part);
    shard = *part;
    return {};
  };
  options.add("--unit SN", &unit, "Serial number of the unit");
  options.add("--all", &all, "Fit every unit whose newest model was not made of the same runs and options")
      .excludes("--unit");
  options.require_one_of({"--unit", "--all"}, "--unit SN or --all");
  options.add("--campaign NAME", &campaign, "Use only runs of this campaign");
  options.add("--rules auto|N", read_rules,
              "Number of ANFIS rules; auto (default): chosen by cross-validation over runs");
  options.add("--jobs N", &jobs, "Threads (default: one per core)").range(1, 1024);
  options
      .add("--shard I/N", read_part,
           "Fit part I of N of the units and write a result shard for 'soak merge'; the data folder is only read, and "
           "must be a copy that nobody writes ('soak backup'). slurm: the part of this task of a Slurm job array")
      .needs("--all")
      .needs("--output");
  options.add("-o,--output FILE", &shard_file, "With --shard: the result shard").needs("--shard");
  options
      .add("--chamber-time", &chamber_time,
           "Also estimate what fewer runs, fewer plateaus or one sweep would have given, and in how many hours")
      .needs("--unit");
  options.add("--brief", &brief, "With --all and --json: only what became of each unit, not its curves").needs("--all");
}

std::string fit_number(const std::optional<double>& value, double factor) {
  return value ? fmt::format("{:.3g}", *value * factor) : "-";
}

/// A line on the effects that the readings were corrected for.
std::string terms_line(const std::vector<calib::ModelTerm>& terms) {
  if (terms.empty()) return {};
  std::vector<std::string_view> names;
  for (const calib::ModelTerm& term : terms) names.push_back(term.name);
  return fmt::format("accepted effects (subtracted from the readings): {}\n", fmt::join(names, ", "));
}

/// A line on the level error where headings were given.
std::string level_line(const calib::LevelStatement& level) {
  if (!level.with_headings) return {};
  if (!level.to_north_east) return fmt::format("level error: unknown, {}\n", level.reason);
  const auto& [north, east] = *level.to_north_east;
  const auto in_deg = [](const calib::StatedValue& value) {
    return fmt::format("{:+.3g}° ± {:.2g}°", value.value * base::kDegPerRad, value.ci95 * base::kDegPerRad);
  };
  return fmt::format("level error (subtracted): the true vertical is tilted {} to north, {} to east (95 %{})\n",
                     in_deg(north), in_deg(east),
                     north.type_b ? "" : "; the fixture's squareness error is not stated and not included");
}

std::string fit_text(const calib::UnitModel& model) {
  std::vector<std::vector<std::string>> table = {{"sensor", "unit", "deployed", "rules", "runs", "range °C",
                                                  "fit error", "cross-validation", "shape", "run-to-run", "ci95"}};
  for (const calib::Sensor sensor : calib::kSensors) {
    const auto& fit = model.sensors[calib::index_of(sensor)];
    if (!fit) continue;
    const double factor = calib::printed_per_si(sensor);
    const auto error = fit->bias.deployed_error();
    double widest = 0.0;
    for (const calib::CurvePoint& point : fit->bias.points) widest = std::max(widest, point.ci95);
    table.push_back({std::string(calib::name_of(sensor)), std::string(calib::printed_unit(sensor)),
                     std::string(calib::name_of(fit->bias.deployed)), std::to_string(fit->bias.rules),
                     std::to_string(fit->bias.runs.size()),
                     fmt::format("{:.1f}..{:.1f}", fit->bias.temp_min_c, fit->bias.temp_max_c),
                     fit_number(fit->bias.train_rmse, factor), error ? fit_number(error->rmse_abs, factor) : "-",
                     error ? fit_number(error->rmse_shape, factor) : "-",
                     fit_number(fit->bias.run_to_run_sigma, factor), fit_number(widest, factor)});
  }
  return fmt::format("unit {}, model {}{}\n{}{}{}", model.unit, model.version, model.simulated ? " (SIMULATED)" : "",
                     text_table(table), terms_line(model.terms), level_line(model.level));
}

void note_warnings(const calib::UnitModel& model, Output& output) {
  for (const calib::Warning& warning : model.warnings) output.note("warning: " + warning.text);
  std::set<std::string> noted;
  for (const auto& fit : model.sensors) {
    if (!fit) continue;
    for (const calib::Warning& warning : fit->warnings) {
      // All sensors have the same runs: once is enough to read.
      const bool of_runs = warning.code == "few_runs" || warning.code == "one_temperature" || warning.code == "one_way";
      if (!of_runs || noted.insert(warning.text).second) output.note("warning: " + warning.text);
    }
  }
}

/// The sensor whose error grows most against the whole campaign.
std::optional<calib::Sensor> worst_sensor(const calib::ChamberTimeOption& option,
                                          const calib::ChamberTimeOption& whole) {
  std::optional<calib::Sensor> worst;
  double largest = 0.0;
  for (const calib::Sensor sensor : calib::kSensors) {
    const auto& error = option.sensors[calib::index_of(sensor)];
    const auto& reference = whole.sensors[calib::index_of(sensor)];
    if (!error || !reference || error->rmse_shape <= largest * reference->rmse_shape) continue;
    largest = error->rmse_shape / reference->rmse_shape;
    worst = sensor;
  }
  return worst;
}

std::vector<std::string> chamber_time_row(const calib::ChamberTimeOption& option,
                                          const calib::ChamberTimeOption& whole) {
  std::vector<std::string> row = {fmt::format("{:.1f}", option.hours), fmt::format("{:.1f}", option.hours_at_least),
                                  std::to_string(option.runs), std::to_string(option.plateaus_c.size()),
                                  std::string(name_of(option.sweeps))};
  const auto sensor = worst_sensor(option, whole);
  if (!sensor) {
    row.insert(row.end(), {"-", "-", "-", "-", "-", "-"});
    return row;
  }
  const auto s = calib::index_of(*sensor);
  const double factor = calib::printed_per_si(*sensor);
  const calib::ExpectedError& error = *option.sensors[s];
  row.insert(
      row.end(),
      {std::string(calib::name_of(*sensor)), std::string(calib::printed_unit(*sensor)),
       fit_number(error.error_rms, factor),
       fmt::format("{}..{}", fit_number(error.error_low, factor), fit_number(error.error_high, factor)),
       fit_number(error.rmse_shape, factor), fmt::format("{:.2f}", error.rmse_shape / whole.sensors[s]->rmse_shape)});
  return row;
}

/// The largest error of a sensor as a multiple of that of the whole campaign; infinite where nothing is known.
double worst_ratio(const calib::ChamberTimeOption& option, const calib::ChamberTimeOption& whole) {
  const auto sensor = worst_sensor(option, whole);
  if (!sensor) return std::numeric_limits<double>::infinity();
  const auto s = calib::index_of(*sensor);
  return option.sensors[s]->rmse_shape / whole.sensors[s]->rmse_shape;
}

/// Choices without another that is both shorter and better (Pareto front), and always the recommended one and the whole
/// campaign. Indices, rising.
std::set<std::size_t> useful_options(const calib::ChamberTime& study) {
  const auto& options = study.options;
  std::vector<std::tuple<double, double, std::size_t>> by_hours;  // hours, error, index
  for (std::size_t i = 0; i < options.size(); ++i) {
    by_hours.emplace_back(options[i].hours, worst_ratio(options[i], options.back()), i);
  }
  std::sort(by_hours.begin(), by_hours.end());
  std::set<std::size_t> useful = {options.size() - 1};
  if (study.recommended) useful.insert(*study.recommended);
  double best = std::numeric_limits<double>::infinity();
  for (const auto& [hours, ratio, i] : by_hours) {
    if (ratio >= best) continue;
    best = ratio;
    useful.insert(i);
  }
  return useful;
}

std::string chamber_time_text(const calib::ChamberTime& study) {
  const std::string title = fmt::format("chamber time: {} runs, {:.1f} hours\n", study.runs, study.hours);
  if (study.options.empty()) return title + "no estimate: " + study.reason + "\n";
  std::vector<std::vector<std::string>> table = {{"hours", "at least", "runs", "plateaus", "sweeps", "worst sensor",
                                                  "unit", "curve error", "95 %", "shape", "x full campaign"}};
  const std::set<std::size_t> useful = useful_options(study);
  for (const std::size_t i : useful) table.push_back(chamber_time_row(study.options[i], study.options.back()));
  return fmt::format(
      "{}{}showing {} of {} options: the full campaign, and those that no other option beats in both time and error; "
      "--json lists all\n{}: {}\n",
      title, text_table(table), useful.size(), study.options.size(),
      study.recommended ? "recommended" : "no recommendation", study.reason);
}

/// Adds the estimate for shorter campaigns to the unit's document and text.
base::Status add_chamber_time(const calib::UnitInput& input, const calib::UnitModel& model, nlohmann::json& document,
                              std::string& text) {
  const auto rows = calib::make_rows(input);
  if (!rows) return base::forward_error(rows);
  const calib::ChamberTime study = calib::study_chamber_time(input, *rows, model.sensors);
  document["chamber_time"] = calib::chamber_time_json(study);
  text += "\n" + chamber_time_text(study);
  return {};
}

base::Result<std::vector<std::string>> all_serials(const db::Catalog& catalog) {
  const auto units = catalog.units();
  if (!units) return base::forward_error(units);
  std::vector<std::string> serials;
  for (const db::UnitRow& unit : *units) serials.push_back(unit.serial);
  if (serials.empty()) return base::bad_input("the data folder has no unit; import a recording first");
  return serials;
}

/// A unit of which no run is for a fit.
struct SkippedUnit {
  std::string serial;
  std::string why;
};

/// Takes the units out of the list that have nothing to be fitted to; refuses a list that has no others.
base::Result<std::vector<SkippedUnit>> take_out_skipped(const db::Catalog& catalog, std::vector<std::string>& serials) {
  std::vector<SkippedUnit> skipped;
  std::vector<std::string> rest;
  std::string message = "no unit has a run for a fit:";
  for (const std::string& serial : serials) {
    auto why = why_nothing_to_fit(catalog, serial);
    if (!why) return base::forward_error(why);
    if (why->empty()) {
      rest.push_back(serial);
      continue;
    }
    message += "\n  " + *why;
    skipped.push_back({serial, *std::move(why)});
  }
  if (rest.empty()) return base::bad_input(message);
  serials = std::move(rest);
  return skipped;
}

/// What `soak fit` printed of the newest model of a unit.
base::Result<nlohmann::json> stored_fit(const db::Catalog& catalog, const std::string& serial) {
  const auto model = catalog.model(serial);
  if (!model) return base::forward_error(model);
  auto document = *model ? nlohmann::json::parse((*model)->document, nullptr, false) : nlohmann::json();
  if (!document.contains("fit")) return base::corrupt("the stored model cannot be read", "unit " + serial);
  return std::move(document["fit"]);
}

/// Root mean square error of a sensor's deployed curve on rows that it did not see, in printed units.
std::optional<double> held_out_error(const nlohmann::json& sensor) {
  const std::string deployed = sensor.value("deployed", "");
  const nlohmann::json::json_pointer baseline("/baselines/" + deployed + "/rmse_abs");
  const nlohmann::json& error = deployed == "anfis"         ? sensor.at("check_rmse")
                                : sensor.contains(baseline) ? sensor[baseline]
                                                            : nlohmann::json();
  return error.is_number() ? std::optional(error.get<double>()) : std::nullopt;
}

std::vector<std::string> batch_row(const nlohmann::json& fit, bool up_to_date) {
  std::optional<double> gyro;
  std::optional<double> accel;
  std::set<std::string> warnings;
  const auto add_warnings = [&](const nlohmann::json& list) {
    for (const nlohmann::json& warning : list) warnings.insert(warning.at("text").get<std::string>());
  };
  add_warnings(fit.at("warnings"));
  std::size_t runs = 0;
  for (const auto& [name, sensor] : fit.at("sensors").items()) {
    const auto error = held_out_error(sensor);
    std::optional<double>& largest = name.starts_with("gyro") ? gyro : accel;
    if (error) largest = std::max(largest.value_or(0.0), *error);
    add_warnings(sensor.at("warnings"));
    runs = std::max(runs, sensor.at("runs").size());
  }
  return {fit.at("unit").get<std::string>(),
          std::to_string(fit.at("model").get<int>()),
          up_to_date ? "up to date" : "fitted",
          std::to_string(runs),
          fit_number(gyro, 1.0),
          fit_number(accel, 1.0),
          std::to_string(warnings.size())};
}

/// What became of each unit that the batch came to, and which its newest model is now.
base::Status print_brief(const db::Catalog& catalog, const std::vector<BatchUnit>& units,
                         const std::vector<SkippedUnit>& skipped, Output& output) {
  const auto heads = catalog.models();
  if (!heads) return base::forward_error(heads);
  std::map<std::string, std::int32_t> newest;
  for (const db::ModelHead& head : *heads) newest[head.unit] = std::max(newest[head.unit], head.version);
  nlohmann::json list = nlohmann::json::array();
  for (const BatchUnit& unit : units) {
    if (!unit.done && !unit.failure) continue;
    const auto model = newest.find(unit.serial);
    list.push_back({{"unit", unit.serial},
                    {"result", name_of(result_of(unit))},
                    {"model", model == newest.end() ? nlohmann::json() : nlohmann::json(model->second)},
                    {"message", unit.failure ? nlohmann::json(unit.failure->message) : nlohmann::json()}});
  }
  for (const SkippedUnit& unit : skipped) {
    const auto model = newest.find(unit.serial);
    list.push_back({{"unit", unit.serial},
                    {"result", "skipped"},
                    {"model", model == newest.end() ? nlohmann::json() : nlohmann::json(model->second)},
                    {"message", unit.why}});
  }
  return output.print_json({{"units", std::move(list)}});
}

base::Status print_batch(const db::Catalog& catalog, const std::vector<BatchUnit>& units, Output& output) {
  std::vector<const BatchUnit*> fitted;
  for (const BatchUnit& unit : units) {
    if (!unit.failure) fitted.push_back(&unit);
  }
  if (output.json()) {
    return output.print_json_list("units", fitted.size(),
                                  [&](std::size_t i) { return stored_fit(catalog, fitted[i]->serial); });
  }
  if (fitted.empty()) return {};
  std::vector<std::vector<std::string>> table = {
      {"unit", "model", "result", "runs", "worst gyro deg/s", "worst accel m/s2", "warnings"}};
  for (const BatchUnit* unit : fitted) {
    const auto fit = stored_fit(catalog, unit->serial);
    if (!fit) return base::forward_error(fit);
    table.push_back(batch_row(*fit, unit->up_to_date));
  }
  output.print(text_table(table));
  output.print("errors: root mean square on held-out runs; 'soak report --unit SN' has curves and warnings\n");
  return {};
}

base::Status all_failures(const std::vector<BatchUnit>& units) {
  std::string message;
  std::size_t failures = 0;
  auto kind = base::ErrorKind::bad_input;
  for (const BatchUnit& unit : units) {
    if (!unit.failure) continue;
    if (failures++ == 0) kind = unit.failure->kind;
    const base::Error& error = *unit.failure;
    message +=
        fmt::format("\n  unit {}: {}{}{}", unit.serial, error.where, error.where.empty() ? "" : ": ", error.message);
  }
  if (failures == 0) return {};
  return base::fail(kind, fmt::format("{} of {} units could not be fitted:{}", failures, units.size(), message));
}

nlohmann::json shard_json(const ShardPart& part, const std::string& file, const FittedShard& fitted) {
  nlohmann::json units = nlohmann::json::array();
  for (const BatchUnit& unit : fitted.units) {
    units.push_back({{"unit", unit.serial}, {"result", name_of(result_of(unit))}});
  }
  return {
      {"file", file}, {"shard", part.shard}, {"of", part.of}, {"sha256", fitted.sha256}, {"units", std::move(units)}};
}

std::string shard_text(const ShardPart& part, const std::string& file, const FittedShard& fitted) {
  const auto count = [&](ShardResult result) {
    return std::ranges::count(fitted.units, result, [](const BatchUnit& unit) { return result_of(unit); });
  };
  return fmt::format("{}: shard {} of {}, {} units: {} fitted, {} up to date, {} wait for the fleet, {} failed\n", file,
                     part.shard, part.of, fitted.units.size(), count(ShardResult::fitted),
                     count(ShardResult::up_to_date), count(ShardResult::waits_for_fleet), count(ShardResult::failed));
}

base::Status FitCommand::run_with(db::Catalog& catalog, Output& output) {
  if (shard) return fit_part(catalog, output);
  return all ? fit_all(catalog, output) : fit_one(catalog, output);
}

base::Status FitCommand::fit_part(const db::Catalog& catalog, Output& output) const {
  if (campaign) {
    if (auto known = check_campaign_known(catalog, *campaign); !known) return known;
  }
  if (auto writable = check_writable(shard_file); !writable) return writable;
  const auto fitted =
      fit_shard(catalog, *shard, {campaign, {rules}, jobs, user_name()}, shard_file, output.progress("fitting"));
  output.end_progress();
  if (!fitted) return base::forward_error(fitted);
  if (output.json()) {
    if (auto printed = output.print_json(shard_json(*shard, shard_file, *fitted)); !printed) return printed;
  } else {
    output.print(shard_text(*shard, shard_file, *fitted));
  }
  return all_failures(fitted->units);
}

base::Status FitCommand::fit_all(const db::Catalog& catalog, Output& output) const {
  if (catalog.read_only()) {
    return base::fail(base::ErrorKind::internal, "this folder cannot be written, so no model could be stored",
                      catalog.data_folder().string());
  }
  auto serials = all_serials(catalog);
  if (!serials) return base::forward_error(serials);
  if (campaign) {
    if (auto known = check_campaign_known(catalog, *campaign); !known) return known;
  }
  const auto skipped = take_out_skipped(catalog, *serials);
  if (!skipped) return base::forward_error(skipped);
  const auto batch = fit_batch(catalog, *serials, {campaign, {rules}, jobs, user_name()}, output.progress("fitting"));
  output.end_progress();
  const bool is_brief = brief && output.json();
  if (!batch.ended && !is_brief) return batch.ended;
  for (const SkippedUnit& unit : *skipped) output.note("left out: " + unit.why);
  const auto& units = batch.units;
  const base::Status printed =
      is_brief ? print_brief(catalog, units, *skipped, output) : print_batch(catalog, units, output);
  if (!batch.ended) return batch.ended;
  const base::Status failed = all_failures(units);
  return failed ? printed : failed;
}

base::Status FitCommand::fit_one(db::Catalog& catalog, Output& output) const {
  output.begin("reading");
  const auto row = catalog.unit(unit);
  if (!row) return base::forward_error(row);
  const auto terms = accepted_terms(catalog, unit, *row ? (*row)->epoch : 0);
  if (!terms) return base::forward_error(terms);
  const auto inputs = fit_inputs_now(catalog, unit, campaign, *terms, {rules});
  if (!inputs) return base::forward_error(inputs);
  std::vector<calib::Warning> warnings;
  auto input = load_unit(catalog, unit, campaign, warnings);
  if (!input) return base::forward_error(input);
  CheckWarnings check_warnings(catalog);
  const auto model = fit_with_terms(catalog, *input, *terms, {rules}, FitWork{jobs, output.progress("fitting")},
                                    check_warnings, std::move(warnings), *inputs);
  output.end_progress();
  if (!model) return base::forward_error(model);
  nlohmann::json document = calib::fit_json(*model);
  std::string text = fit_text(*model);
  if (chamber_time) {
    if (auto added = add_chamber_time(*input, *model, document, text); !added) return added;
  }
  if (output.json()) return output.print_json(document);
  note_warnings(*model, output);
  output.print(text);
  return {};
}

}  // namespace

CommandGroup fit_commands() {
  return {"",
          "",
          {{"fit", "Fit a thermal model per sensor; adds a model version, older versions are kept",
            "soak fit --unit SN0042 --json", std::make_shared<FitCommand>()}}};
}

}  // namespace soak::station
