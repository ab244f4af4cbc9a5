// SPDX-License-Identifier: Apache-2.0
#include "station/nav/nav_json.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

#include "base/statistics.h"
#include "station/io/output.h"

namespace soak::station {
namespace {

using nlohmann::json;

json axes_json(const Eigen::Vector3d& v) { return {{"east", v.x()}, {"north", v.y()}, {"up", v.z()}}; }

json errors_json(const nav::OutageErrors& errors) {
  return {{"horizontal_rmse_m", errors.horizontal_rmse_m},
          {"horizontal_final_m", errors.horizontal_final_m},
          {"position_rmse_m", axes_json(errors.position_rmse_m)},
          {"position_final_m", axes_json(errors.position_final_m)},
          {"velocity_rmse_mps", axes_json(errors.velocity_rmse_mps)},
          {"velocity_final_mps", axes_json(errors.velocity_final_mps)}};
}

json outage_json(const nav::OutageResult& result, std::span<const nav::Pipeline> pipelines) {
  json errors = json::object();
  for (std::size_t p = 0; p < pipelines.size(); ++p) errors[pipelines[p].name] = errors_json(result.pipelines[p]);
  return {{"drive", result.drive},
          {"begin_s", result.outage.begin_s},
          {"end_s", result.outage.end_s},
          {"distance_m", result.distance_m},
          {"errors", std::move(errors)}};
}

json statistics_json(const nav::FixStatistics& statistics) {
  json median;
  if (std::isfinite(statistics.median_nis)) median = statistics.median_nis;
  return {{"median_nis", std::move(median)}, {"left_out", statistics.left_out}};
}

json fixes_json(const nav::Innovations& fixes) {
  return {{"number", fixes.fixes},
          {"position", statistics_json(fixes.position)},
          {"velocity", statistics_json(fixes.velocity)}};
}

std::string fixes_sentence(const std::string& drive, const json& fixes) {
  const auto of = [&](const char* what) {
    const json& statistics = fixes[what];
    return fmt::format("{} {:.2g} ({} left out as outliers)", what, statistics["median_nis"].get<double>(),
                       statistics["left_out"].get<std::size_t>());
  };
  return fmt::format(
      "Fixes of {}: {}; median of the normalised innovations squared: {}, {}. Where the standard "
      "deviations are right it is {:.2g}.",
      drive, fixes["number"].get<std::size_t>(), of("position"), of("velocity"), base::chi_squared_quantile(0.5, 3.0));
}

json truth_json(const nav::Drive& drive) {
  static constexpr const char* kNames[] = {"simulation", "fixes", "file", "smoother"};
  return {{"from", kNames[static_cast<std::size_t>(drive.truth_source)]}, {"horizontal_sigma_m", drive.truth_sigma_m}};
}

std::string with_interval(const json& estimate, double factor, int digits) {
  std::string value = fmt::format("{:.{}f}", factor * estimate["value"].get<double>(), digits);
  if (estimate["ci95"].is_null()) return value;
  return fmt::format("{} [{:.{}f} to {:.{}f}]", value, factor * estimate["ci95"][0].get<double>(), digits,
                     factor * estimate["ci95"][1].get<double>(), digits);
}

/// Names the pipeline with the least mean error at the end of the outages.
std::string best_sentence(const json& comparison) {
  const auto error_m = [](const json& pipeline) { return pipeline["horizontal_final_m"]["value"].get<double>(); };
  const json& best = *std::ranges::min_element(comparison["pipelines"], {}, error_m);
  return fmt::format("Least error at the end: {}, {:.1f} m.\n", best["name"].get<std::string>(), error_m(best));
}

}  // namespace

json estimate_json(const nav::Estimate& estimate) {
  json interval;
  if (std::isfinite(estimate.low)) interval = json::array({estimate.low, estimate.high});
  return {{"value", estimate.value}, {"ci95", std::move(interval)}};
}

json comparison_json(std::span<const nav::Drive> drives, std::span<const nav::Innovations> fixes,
                     std::span<const nav::OutageResult> results, std::span<const nav::Pipeline> pipelines,
                     double length_s, std::size_t seed) {
  json document = {{"length_s", length_s}, {"seed", seed}};
  document["drives"] = json::array();
  for (std::size_t d = 0; d < drives.size(); ++d) {
    const nav::Drive& drive = drives[d];
    document["drives"].push_back({{"name", drive.name},
                                  {"duration_s", drive.imu.back().t_s - drive.imu.front().t_s},
                                  {"truth", truth_json(drive)},
                                  {"fixes", fixes_json(fixes[d])}});
  }
  document["pipelines"] = json::array();
  const auto summaries = nav::summarize(results, pipelines, seed);
  for (std::size_t p = 0; p < pipelines.size(); ++p) {
    const nav::PipelineSummary& summary = summaries[p];
    document["pipelines"].push_back({{"name", summary.name},
                                     {"description", pipelines[p].description},
                                     {"horizontal_rmse_m", estimate_json(summary.horizontal_rmse_m)},
                                     {"horizontal_final_m", estimate_json(summary.horizontal_final_m)},
                                     {"position_rmse_m", axes_json(summary.position_rmse_m)},
                                     {"position_final_m", axes_json(summary.position_final_m)},
                                     {"gain", estimate_json(summary.gain)}});
  }
  document["outages"] = json::array();
  bool overlap = false;
  for (std::size_t i = 0; i < results.size(); ++i) {
    document["outages"].push_back(outage_json(results[i], pipelines));
    overlap = overlap || (i > 0 && results[i].drive == results[i - 1].drive &&
                          results[i].outage.begin_s < results[i - 1].outage.end_s);
  }
  document["outages_overlap"] = overlap;
  return document;
}

std::vector<std::string> outage_remarks(const json& comparison) {
  std::vector<std::string> sentences;
  if (const auto raw = comparison.find("uncorrected"); raw != comparison.end() && !raw->empty()) {
    sentences.push_back(fmt::format("The calibration file does not correct {}: these stayed raw.",
                                    fmt::join(raw->get<std::vector<std::string>>(), ", ")));
  }
  if (const auto both = comparison.find("learnt_and_judged"); both != comparison.end()) {
    sentences.push_back(fmt::format(
        "warning: the ANFIS learnt from {}, which it is judged by: its figures say nothing of other drives.",
        fmt::join(both->get<std::vector<std::string>>(), ", ")));
  }
  if (const auto outside = comparison.find("outside_calibration"); outside != comparison.end()) {
    for (const json& drive : *outside) {
      sentences.push_back(
          fmt::format("warning: {:.2g} % of the readings of {} were taken at temperatures outside the calibration, and "
                      "corrected as at the end of its range.",
                      100.0 * drive["share"].get<double>(), drive["drive"].get<std::string>()));
    }
  }
  if (comparison["outages_overlap"].get<bool>()) {
    sentences.emplace_back(
        "warning: outages overlap, which the intervals do not know: they are too narrow. Fewer outages or shorter ones "
        "do not.");
  }
  for (const json& drive : comparison["drives"]) {
    const json& truth = drive["truth"];
    if (truth["from"] == "simulation") continue;
    sentences.push_back(fmt::format("Truth of {}: from the {}, known to {:.3f} m (horizontal, one standard deviation).",
                                    drive["name"].get<std::string>(), truth["from"].get<std::string>(),
                                    truth["horizontal_sigma_m"].get<double>()));
    if (drive["fixes"]["number"] > 0) sentences.push_back(fixes_sentence(drive["name"], drive["fixes"]));
  }
  return sentences;
}

std::string comparison_text(const json& comparison) {
  std::vector<std::vector<std::string>> table = {
      {"pipeline", "RMSE m [95 %]", "error at the end m [95 %]", "less than the first % [95 %]"}};
  std::string explained = best_sentence(comparison);
  for (const json& pipeline : comparison["pipelines"]) {
    table.push_back({pipeline["name"], with_interval(pipeline["horizontal_rmse_m"], 1.0, 2),
                     with_interval(pipeline["horizontal_final_m"], 1.0, 2), with_interval(pipeline["gain"], 100.0, 1)});
    explained +=
        fmt::format("{}: {}\n", pipeline["name"].get<std::string>(), pipeline["description"].get<std::string>());
  }
  for (const std::string& sentence : outage_remarks(comparison)) explained += sentence + "\n";
  return fmt::format("{} outages of {} s on {} drive(s); horizontal position, means over outages\n{}{}",
                     comparison["outages"].size(), comparison["length_s"].get<double>(), comparison["drives"].size(),
                     text_table(table), explained);
}

}  // namespace soak::station
