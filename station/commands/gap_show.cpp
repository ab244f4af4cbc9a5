// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "station/commands/gap_commands.h"
#include "station/gap/gap_comparison.h"
#include "station/io/data_folder.h"
#include "station/io/host.h"
#include "station/io/text_file.h"
#include "station/report/page.h"

namespace soak::station {
namespace {

std::vector<std::string> table_row(calib::Sensor sensor, const SensorComparison& figures, const std::string& runs,
                                   const std::string& closed) {
  const double factor = calib::printed_per_si(sensor);
  const auto text = [&](double value) { return fmt::format("{:.3g}", value * factor); };
  return {std::string(calib::name_of(sensor)),
          std::string(calib::printed_unit(sensor)),
          runs,
          text(figures.before_rms),
          text(figures.after_rms),
          figures.floor_rms ? text(*figures.floor_rms) : "-",
          text(figures.noise_rms),
          closed};
}

std::string closed_text(const SensorComparison& figures) {
  return figures.closed_fraction ? fmt::format("{:.0f} %", 100.0 * *figures.closed_fraction) : "too small to tell";
}

std::string describe(const GapComparison& comparison) {
  std::string text = fmt::format("unit {}: simulation less measurement, with model {} and with model {}\n",
                                 comparison.unit, comparison.before, comparison.model);
  if (comparison.terms.empty()) text += "the model carries no accepted effect: before and after are the same\n";
  for (const calib::ModelTerm& term : comparison.terms) {
    text += fmt::format("  {}, found missing in model {}{}\n", term.name, term.parent_version,
                        term.lab_only ? "; lab only: not in what the unit computes" : "");
  }
  std::vector<std::vector<std::string>> table = {
      {"sensor", "unit", "runs", "before", "after", "floor", "noise", "closed"}};
  for (const calib::Sensor sensor : calib::kSensors) {
    const std::size_t s = calib::index_of(sensor);
    if (comparison.fitted[s]) table.push_back(table_row(sensor, *comparison.fitted[s], "fitted", "-"));
    if (comparison.fresh[s])
      table.push_back(table_row(sensor, *comparison.fresh[s], "fresh", closed_text(*comparison.fresh[s])));
  }
  text +=
      text_table(table) +
      "RMS of one-minute blocks about each run's own mean. fresh: runs that neither model was fitted to; floor: what "
      "noise and the\nscatter between runs would leave of a perfect model (fitted runs lie below it by what the fit "
      "took of their noise)\n";
  for (const std::string& sentence : remarks(comparison)) text += sentence + "\n";
  return text;
}

}  // namespace

base::Status run_gap_show(const GapShowCommand& command, Output& output) {
  const auto catalog = open_existing_catalog(command.data);
  if (!catalog) return base::forward_error(catalog);
  const auto comparison = compare_gap(*catalog, command.unit, command.model, command.campaign);
  if (!comparison) return base::forward_error(comparison);
  if (!command.file.empty()) {
    const std::string page = gap_page(*comparison, command.software, now_utc_s());
    if (const auto written = write_text_file(command.file, page); !written) return written;
  }
  for (const std::string& sentence : comparison->simulated_after.left_out) output.note("warning: " + sentence);
  if (output.json()) return output.print_json(comparison_json(*comparison));
  output.print(describe(*comparison));
  return {};
}

}  // namespace soak::station
