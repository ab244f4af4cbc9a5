// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>
#include <utility>

#include "base/units.h"
#include "station/commands/command.h"
#include "station/commands/shared.h"
#include "station/commands/signal_text.h"
#include "station/io/output.h"

namespace soak::station {
namespace {

using nlohmann::json;

std::string four_digits(const json& value) {
  return value.is_null() ? "-" : fmt::format("{:.4g}", value.get<double>());
}

std::string header_line(const json& document) {
  std::string line =
      fmt::format("{}{}: {} samples at {:.6g} Hz", document["column"].get<std::string>(),
                  document["unit"].get<std::string>().empty() ? "" : " in " + document["unit"].get<std::string>(),
                  document["samples"].get<std::size_t>(), document["rate_hz"].get<double>());
  if (const auto missing = document["missing"].get<std::size_t>(); missing > 0) {
    line += fmt::format(", {} missing", missing);
  }
  return line + "\n";
}

std::string warning_lines(const json& document) {
  std::string lines;
  for (const json& warning : document["warnings"]) lines += "note: " + warning["text"].get<std::string>() + "\n";
  return lines;
}

/// deg/s or m/s² of one unit of a rate, and which of the two it is.
struct RateUnit {
  bool is_gyro;
  double factor;
};
std::optional<RateUnit> rate_unit(std::string_view unit) {
  if (unit == "deg/s") return RateUnit{true, 1.0};
  if (unit == "rad/s") return RateUnit{true, base::kDegPerRad};
  if (unit == "deg/h") return RateUnit{true, 1.0 / 3600.0};
  if (unit == "m/s2") return RateUnit{false, 1.0};
  if (unit == "g") return RateUnit{false, base::kStandardGravity_mps2};
  if (unit == "mg") return RateUnit{false, base::kStandardGravity_mps2 / 1000.0};
  return std::nullopt;
}

/// The coefficient in the unit of data sheets; empty where there is none.
std::string data_sheet_value(std::string_view name, const json& coefficient, std::string_view unit) {
  const auto rate = rate_unit(unit);
  if (!rate) return {};
  const double value = coefficient["value"].get<double>() * rate->factor;
  if (name == "angle_random_walk") return fmt::format("{:.4g} {}/sqrt(h)", 60.0 * value, rate->is_gyro ? "deg" : "m/s");
  if (name != "bias_instability") return {};
  if (rate->is_gyro) return fmt::format("{:.4g} deg/h", 3600.0 * value);
  return fmt::format("{:.4g} mg", 1000.0 * value / base::kStandardGravity_mps2);
}

std::string coefficient_table(const json& coefficients, const std::string& unit) {
  constexpr std::array<std::pair<const char*, const char*>, 7> names = {{{"quantization", "quantisation Q"},
                                                                         {"angle_random_walk", "random walk N"},
                                                                         {"bias_instability", "bias instability B"},
                                                                         {"rate_random_walk", "rate random walk K"},
                                                                         {"rate_ramp", "rate ramp R"},
                                                                         {"markov_sigma", "Markov process, sigma"},
                                                                         {"markov_time", "Markov process, time"}}};
  std::vector<std::vector<std::string>> table = {{"term", "value", "95 % from", "to", "unit", "as in data sheets"}};
  for (const auto& [key, title] : names) {
    const json& c = coefficients[key];
    if (!c["found"].get<bool>() && std::string_view(key).starts_with("markov")) continue;
    table.push_back({title, c["found"].get<bool>() ? four_digits(c["value"]) : "not found", four_digits(c["ci95"][0]),
                     four_digits(c["ci95"][1]), c["unit"].get<std::string>(),
                     c["found"].get<bool>() ? data_sheet_value(key, c, unit) : ""});
  }
  return text_table(table);
}

std::string process_line(std::string_view order, const json& process) {
  if (process.is_null()) return fmt::format("Gauss-Markov, {} order: none found\n", order);
  return fmt::format(
      "Gauss-Markov, {} order: sigma {:.4g}, correlation time {:.4g} s, plus white noise {:.4g}; correlation misfit "
      "{:.2g} RMS\n",
      order, process["sigma"].get<double>(), process["correlation_s"].get<double>(),
      process["white_sigma"].get<double>(), process["rms_misfit"].get<double>());
}

std::string correlation_time_text(const json& time_s, double step_s) {
  if (time_s.is_null()) return "beyond the longest lag";
  if (time_s.get<double>() < step_s) return "within one sample";
  return fmt::format("at {:.4g} s", time_s.get<double>());
}

std::string correlation_lines(const json& document) {
  return fmt::format("standard deviation {:.6g}; correlation falls to 1/e {}\n",
                     std::sqrt(document["variance"].get<double>()),
                     correlation_time_text(document["correlation_time_s"], document["lag_s"][1])) +
         process_line("first", document["gauss_markov_1"]) + process_line("second", document["gauss_markov_2"]);
}

/// Where the bands of a table begin among `count` rows, and the end: one row each up to five, then a fifth wider each.
std::vector<std::size_t> band_edges(std::size_t count) {
  std::vector<std::size_t> edges;
  for (double next = 0.0; next < static_cast<double>(count); next = std::max(next + 1.0, next * 1.2)) {
    edges.push_back(static_cast<std::size_t>(next));
  }
  edges.push_back(count);
  return edges;
}

std::string mean_of(const json& values, std::size_t first, std::size_t last) {
  double sum = 0.0;
  for (std::size_t i = first; i < last; ++i) sum += values[i].is_null() ? 0.0 : values[i].get<double>();
  return fmt::format("{:.4g}", sum / static_cast<double>(last - first));
}

/// Bands of a list: where each begins and ends, and its mean, also that after denoising.
std::string band_table(const json& document, const char* x, const char* y, const std::string& x_unit,
                       const std::string& y_title) {
  const json& after = document["after_wmra"];
  std::vector<std::vector<std::string>> table = {{"from " + x_unit, "to " + x_unit, y_title}};
  if (!after.is_null()) table.front().emplace_back("after WMRA");
  const std::vector<std::size_t> edges = band_edges(document[x].size());
  for (std::size_t band = 0; band + 1 < edges.size(); ++band) {
    const std::size_t first = edges[band];
    const std::size_t last = edges[band + 1];
    table.push_back(
        {four_digits(document[x][first]), four_digits(document[x][last - 1]), mean_of(document[y], first, last)});
    if (!after.is_null()) table.back().push_back(mean_of(after[y], first, last));
  }
  return text_table(table);
}

std::string lines_text(const json& lines, const std::string& unit) {
  if (lines.empty()) return "no line above the noise\n";
  std::string text;
  for (const json& line : lines) {
    text += fmt::format("line at {:.5g} Hz, amplitude {:.4g} {}\n", line["frequency_hz"].get<double>(),
                        line["amplitude"].get<double>(), unit);
  }
  return text;
}

std::string low_pass_line(const json& filter) {
  if (!filter["found"].get<bool>()) return {};
  std::string line = filter["corner_hz"].is_null()
                         ? "low-pass of the unit, its corner beyond half the rate"
                         : fmt::format("low-pass of the unit at {:.3g} Hz", filter["corner_hz"].get<double>());
  if (!filter["fitted_from_s"].is_null()) {
    line += fmt::format("; terms are fitted from {:.3g} s on", filter["fitted_from_s"].get<double>());
  }
  return line + "\n";
}

}  // namespace

std::string allan_text(const json& document) {
  const std::string unit = document["unit"];
  std::vector<std::vector<std::string>> table = {{"tau s", "adev", "oadev", "95 % from", "to", "mdev", "ohdev"}};
  for (std::size_t i = 0; i < document["tau_s"].size(); ++i) {
    const json& interval = i < document["ci95"].size() ? document["ci95"][i] : json::array({nullptr, nullptr});
    table.push_back({four_digits(document["tau_s"][i]), four_digits(document["adev"][i]),
                     four_digits(document["oadev"][i]), four_digits(interval[0]), four_digits(interval[1]),
                     four_digits(document["mdev"][i]), four_digits(document["ohdev"][i])});
  }
  std::string text = header_line(document) + text_table(table) + low_pass_line(document["low_pass"]);
  if (!document["coefficients"].empty()) text += "\n" + coefficient_table(document["coefficients"], unit);
  return text + warning_lines(document);
}

std::string psd_text(const json& document) {
  return header_line(document) +
         fmt::format("{} sections, {:.0f} degrees of freedom; integrates to a standard deviation of {:.6g} {}\n",
                     document["sections"].get<std::size_t>(), document["degrees_of_freedom"].get<double>(),
                     std::sqrt(document["variance"].get<double>()), document["unit"].get<std::string>()) +
         lines_text(document["lines"], document["unit"]) +
         band_table(document, "frequency_hz", "psd", "Hz", "mean " + document["psd_unit"].get<std::string>());
}

std::string acf_text(const json& document) {
  std::string text = header_line(document) + correlation_lines(document);
  if (!document["after_wmra"].is_null()) text += "after WMRA: " + correlation_lines(document["after_wmra"]);
  return text + band_table(document, "lag_s", "acf", "s", "mean correlation");
}

}  // namespace soak::station
