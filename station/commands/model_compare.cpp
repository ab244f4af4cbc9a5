// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "base/statistics.h"
#include "calib/curve/calibration.h"
#include "calib/model/model_document.h"
#include "calib/vocabulary/sensor.h"
#include "station/commands/command.h"
#include "station/io/data_folder.h"

namespace soak::station {
namespace {

/// soak model compare --unit SN --model V --with W
struct ModelCompare final : CatalogCommand {
  std::string unit;
  int before = 0;
  std::optional<int> after;  ///< absent = the newest

  void declare(OptionList& options) override {
    options.add("--unit SN", &unit, "Serial number of the unit").required();
    options.add("--model V", &before, "Model version that is compared with a later one").required();
    options.add("--with W", &after, "The later version (default: the newest)");
  }
  base::Status run_with(db::Catalog& catalog, Output& output) override;
};

/// A stored version.
struct Version {
  db::ModelRow row;
  calib::Calibration calibration;
  nlohmann::json sensors;                   ///< as `soak fit` printed them
  std::map<std::string, std::string> runs;  ///< content hash by the name that the fit printed
};

/// The difference of two bias curves at a temperature, in printed units.
struct CurveDifference {
  double temp_c = 0.0;
  double value = 0.0;
  double ci95 = 0.0;
};

/// Errors on runs that neither curve had seen.
struct HeldOutErrors {
  std::size_t runs = 0;  ///< held out in both versions
  std::optional<double> before_rms;
  std::optional<double> after_rms;
  std::optional<double> ratio;  ///< after / before, geometric mean over the runs
  std::optional<double> ratio_low;
  std::optional<double> ratio_high;
  std::string_view verdict = "unknown";
};

struct SensorPair {
  calib::Sensor sensor = calib::Sensor::gyro_x;
  std::string before;  ///< what is deployed
  std::string after;
  std::vector<CurveDifference> differences;  ///< at whole degrees of the common range
  HeldOutErrors held_out;
};

/// The runs of a fit. It printed labels, with their campaigns where two runs have one label. A name that may be of two
/// recordings (a copy under another name is also in the catalog) is none.
base::Result<std::map<std::string, std::string>> runs_of(const db::Catalog& catalog,
                                                         const calib::Calibration& calibration) {
  const auto rows = catalog.runs({.unit = calibration.unit, .campaign = {}, .run = {}});
  if (!rows) return base::forward_error(rows);
  std::map<std::string, std::set<std::string>> hashes;
  for (const db::RunRow& run : *rows) {
    if (std::ranges::find(calibration.run_hashes, run.content_sha256) == calibration.run_hashes.end()) continue;
    hashes[run.label].insert(run.content_sha256);
    hashes[run.campaign + "/" + run.label].insert(run.content_sha256);
  }
  std::map<std::string, std::string> runs;
  for (const auto& [name, of] : hashes) {
    if (of.size() == 1) runs.emplace(name, *of.begin());
  }
  return runs;
}

base::Result<Version> version_of(const db::Catalog& catalog, const std::string& unit, std::optional<int> number) {
  auto row = catalog.model(unit, number);
  if (!row) return base::forward_error(row);
  if (!*row) {
    return base::bad_input(fmt::format("unit {} has no model{}; 'soak model list --unit {}' shows them", unit,
                                       number ? fmt::format(" {}", *number) : "", unit));
  }
  auto calibration = calib::calibration_of((*row)->document);
  if (!calibration) return base::forward_error(calibration);
  const auto document = nlohmann::json::parse((*row)->document, nullptr, false);
  const nlohmann::json::json_pointer sensors("/fit/sensors");
  if (!document.contains(sensors)) return base::corrupt("the stored model cannot be read", "unit " + unit);
  auto runs = runs_of(catalog, *calibration);
  if (!runs) return base::forward_error(runs);
  return Version{**std::move(row), *std::move(calibration), document[sensors], *std::move(runs)};
}

double ci95_at(const calib::UncertaintyTable& table, double temp_c) {
  const auto above = std::ranges::lower_bound(table.temp_c, temp_c);
  const auto i = static_cast<std::size_t>(above - table.temp_c.begin());
  if (i == 0) return table.ci95.front();
  if (i == table.temp_c.size()) return table.ci95.back();
  const double share = (temp_c - table.temp_c[i - 1]) / (table.temp_c[i] - table.temp_c[i - 1]);
  return std::lerp(table.ci95[i - 1], table.ci95[i], share);
}

std::vector<CurveDifference> differences_of(const calib::SensorCalibration& before,
                                            const calib::SensorCalibration& after) {
  const double factor = calib::printed_per_si(before.sensor);
  const double last_c = std::min(before.temp_max_c, after.temp_max_c);
  std::vector<CurveDifference> differences;
  for (double temp_c = std::ceil(std::max(before.temp_min_c, after.temp_min_c)); temp_c <= last_c; temp_c += 1.0) {
    const double value = calib::evaluate(after.bias, temp_c) - calib::evaluate(before.bias, temp_c);
    // As if the two had no run in common; where they have, the difference is known better than that.
    const double ci95 = std::hypot(ci95_at(before.bias_uncertainty, temp_c), ci95_at(after.bias_uncertainty, temp_c));
    differences.push_back({temp_c, factor * value, factor * ci95});
  }
  return differences;
}

/// Errors of the deployed family on each run that was held out, by the run's content hash: two campaigns may give their
/// runs the same labels.
std::map<std::string, double> errors_by_run(const Version& version, std::string_view name) {
  const nlohmann::json& sensor = version.sensors[name];
  std::map<std::string, double> errors;
  if (sensor.value("holdout", "") != "run") return errors;
  const std::string deployed = sensor.value("deployed", "");
  for (const nlohmann::json& check : sensor.at("checks")) {
    if (!check.contains(deployed) || !check[deployed].is_number()) continue;
    const double error = check[deployed];
    const auto run = version.runs.find(check.at("held_out").get<std::string>());
    if (run != version.runs.end() && error > 0.0) errors.emplace(run->second, error);
  }
  return errors;
}

/// Paired over the runs that both versions held out: the mean of ln(after / before) with its interval by Student's t.
HeldOutErrors compare_errors(const Version& before, const Version& after, std::string_view sensor) {
  constexpr std::size_t kFewestRuns = 3;
  const auto errors_after = errors_by_run(after, sensor);
  HeldOutErrors result;
  std::vector<double> logarithms;
  double squares_before = 0.0;
  double squares_after = 0.0;
  for (const auto& [run, error] : errors_by_run(before, sensor)) {
    const auto other = errors_after.find(run);
    if (other == errors_after.end()) continue;
    logarithms.push_back(std::log(other->second / error));
    squares_before += error * error;
    squares_after += other->second * other->second;
  }
  result.runs = logarithms.size();
  if (logarithms.empty()) return result;
  const auto n = static_cast<double>(logarithms.size());
  result.before_rms = std::sqrt(squares_before / n);
  result.after_rms = std::sqrt(squares_after / n);
  if (logarithms.size() < kFewestRuns) return result;
  double mean = 0.0;
  for (const double value : logarithms) mean += value / n;
  double squares = 0.0;
  for (const double value : logarithms) squares += (value - mean) * (value - mean);
  const double half = base::student_t_two_sided(0.95, n - 1.0) * std::sqrt(squares / (n - 1.0) / n);
  result.ratio = std::exp(mean);
  result.ratio_low = std::exp(mean - half);
  result.ratio_high = std::exp(mean + half);
  result.verdict = mean + half < 0.0 ? "better" : mean - half > 0.0 ? "worse" : "equal";
  return result;
}

std::vector<SensorPair> compare(const Version& before, const Version& after) {
  std::vector<SensorPair> list;
  for (const calib::SensorCalibration& one : before.calibration.sensors) {
    const auto other = std::ranges::find(after.calibration.sensors, one.sensor, &calib::SensorCalibration::sensor);
    if (other == after.calibration.sensors.end()) continue;
    const std::string name(calib::name_of(one.sensor));
    if (!before.sensors.contains(name) || !after.sensors.contains(name)) continue;
    list.push_back(
        {one.sensor, one.model, other->model, differences_of(one, *other), compare_errors(before, after, name)});
  }
  return list;
}

bool is_beyond(const CurveDifference& difference) { return std::abs(difference.value) > difference.ci95; }

nlohmann::json comparison_json(const SensorPair& sensor) {
  nlohmann::json curve = nlohmann::json::array();
  for (const auto& [temp_c, value, ci95] : sensor.differences) {
    curve.push_back({{"temp_c", temp_c}, {"difference", value}, {"ci95", ci95}});
  }
  const HeldOutErrors& errors = sensor.held_out;
  return {{"before", sensor.before},
          {"after", sensor.after},
          {"curve", std::move(curve)},
          {"beyond_ci95", std::ranges::count_if(sensor.differences, is_beyond)},
          {"held_out",
           {{"runs", errors.runs},
            {"before_rms", number_or_null(errors.before_rms)},
            {"after_rms", number_or_null(errors.after_rms)},
            {"ratio", number_or_null(errors.ratio)},
            {"ratio_low", number_or_null(errors.ratio_low)},
            {"ratio_high", number_or_null(errors.ratio_high)}}},
          {"verdict", errors.verdict}};
}

std::vector<std::string> comparison_row(const SensorPair& sensor) {
  const HeldOutErrors& errors = sensor.held_out;
  const auto number = [](const std::optional<double>& value) { return value ? fmt::format("{:.3g}", *value) : "-"; };
  std::vector<std::string> row = {std::string(calib::name_of(sensor.sensor)),
                                  std::string(calib::printed_unit(sensor.sensor))};
  const auto largest = std::ranges::max_element(sensor.differences, {},
                                                [](const CurveDifference& point) { return std::abs(point.value); });
  if (largest == sensor.differences.end()) {
    row.insert(row.end(), {"-", "-", "-"});
  } else {
    row.insert(
        row.end(),
        {fmt::format("{:+.3g} ± {:.2g}", largest->value, largest->ci95), fmt::format("{:.0f}", largest->temp_c),
         fmt::format("{} of {}", std::ranges::count_if(sensor.differences, is_beyond), sensor.differences.size())});
  }
  row.insert(row.end(), {std::to_string(errors.runs), number(errors.before_rms), number(errors.after_rms),
                         errors.ratio ? fmt::format("{:.3g} ({:.3g}..{:.3g})", *errors.ratio, *errors.ratio_low,
                                                    *errors.ratio_high)
                                      : "-",
                         std::string(errors.verdict)});
  return row;
}

base::Status ModelCompare::run_with(db::Catalog& catalog, Output& output) {
  if (const auto known = find_unit(catalog, unit); !known) return base::forward_error(known);
  const auto one = version_of(catalog, unit, before);
  if (!one) return base::forward_error(one);
  const auto other = version_of(catalog, unit, after);
  if (!other) return base::forward_error(other);
  if (one->row.version == other->row.version) {
    return base::bad_input(fmt::format("version {} would be compared with itself: name two different ones", before),
                           "unit " + unit);
  }
  const std::vector<SensorPair> list = compare(*one, *other);
  nlohmann::json sensors = nlohmann::json::object();
  std::vector<std::vector<std::string>> table = {{"sensor", "unit", "largest difference", "at °C", "beyond 95 %",
                                                  "runs", "error before", "after", "ratio (95 %)", "verdict"}};
  for (const SensorPair& sensor : list) {
    sensors[std::string(calib::name_of(sensor.sensor))] = comparison_json(sensor);
    table.push_back(comparison_row(sensor));
  }
  if (output.json()) {
    return output.print_json(
        {{"unit", unit}, {"before", one->row.version}, {"after", other->row.version}, {"sensors", std::move(sensors)}});
  }
  output.print(fmt::format("unit {}: model {} after model {}\n{}", unit, other->row.version, one->row.version,
                           text_table(table)));
  output.print("errors: on runs that both versions held out; verdict: whether the ratio's interval excludes 1\n");
  return {};
}

}  // namespace

CommandGroup model_compare_commands() {
  return {"model",
          "",
          {{"compare", "Compare two versions: difference of the curves, errors on held-out runs, better or worse",
            "soak model compare --unit SN0042 --model 1", std::make_shared<ModelCompare>()}}};
}

}  // namespace soak::station
