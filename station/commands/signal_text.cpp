// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>

#include "base/units.h"
#include "station/commands/signal_commands.h"

namespace soak::station {
namespace {

using nlohmann::json;

std::string short_number(const json& value) {
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

/// The same coefficient as data sheets print it; empty where there is no such custom.
std::string customary(std::string_view name, const json& coefficient) {
  const std::string unit = coefficient["unit"];
  const double value = coefficient["value"];
  if (name == "angle_random_walk" && unit == "deg/s/sqrt(Hz)") return fmt::format("{:.4g} deg/sqrt(h)", 60.0 * value);
  if (name == "angle_random_walk" && unit == "m/s2/sqrt(Hz)") return fmt::format("{:.4g} m/s/sqrt(h)", 60.0 * value);
  if (name == "bias_instability" && unit == "deg/s") return fmt::format("{:.4g} deg/h", 3600.0 * value);
  if (name == "bias_instability" && unit == "m/s2") {
    return fmt::format("{:.4g} mg", 1000.0 * value / base::kStandardGravity_mps2);
  }
  return {};
}

std::string coefficient_table(const json& coefficients) {
  constexpr std::array<std::pair<const char*, const char*>, 7> names = {{{"quantization", "quantisation Q"},
                                                                         {"angle_random_walk", "random walk N"},
                                                                         {"bias_instability", "bias instability B"},
                                                                         {"rate_random_walk", "rate random walk K"},
                                                                         {"rate_ramp", "rate ramp R"},
                                                                         {"markov_sigma", "Markov process, sigma"},
                                                                         {"markov_time", "Markov process, time"}}};
  std::vector<std::vector<std::string>> table = {{"term", "value", "95 % from", "to", "unit", "that is"}};
  for (const auto& [key, title] : names) {
    const json& c = coefficients[key];
    if (!c["found"].get<bool>() && std::string_view(key).starts_with("markov")) continue;
    table.push_back({title, c["found"].get<bool>() ? short_number(c["value"]) : "not seen", short_number(c["ci95"][0]),
                     short_number(c["ci95"][1]), c["unit"].get<std::string>(),
                     c["found"].get<bool>() ? customary(key, c) : ""});
  }
  return text_table(table);
}

std::string process_line(std::string_view order, const json& process) {
  if (process.is_null()) return fmt::format("Gauss-Markov, {} order: none seen\n", order);
  return fmt::format("Gauss-Markov, {} order: sigma {:.4g}, correlation time {:.4g} s, white beside it {:.4g}\n", order,
                     process["sigma"].get<double>(), process["correlation_s"].get<double>(),
                     process["white_sigma"].get<double>());
}

std::string correlation_lines(const json& document) {
  const json& time = document["correlation_time_s"];
  return fmt::format(
             "standard deviation {:.6g}; correlation falls to 1/e at {}\n",
             std::sqrt(document["variance"].get<double>()),
             time.is_null() ? std::string("no lag of the table") : fmt::format("{:.4g} s", time.get<double>())) +
         process_line("first", document["gauss_markov_1"]) + process_line("second", document["gauss_markov_2"]);
}

/// Indices from 0 to `count` - 1 on a scale that is even up to 10 and then grows by a tenth of a decade.
std::vector<std::size_t> thinned(std::size_t count) {
  std::vector<std::size_t> indices;
  for (double next = 0.0; next < static_cast<double>(count); next = std::max(next + 1.0, next * 1.25)) {
    indices.push_back(static_cast<std::size_t>(next));
  }
  return indices;
}

/// A table of some rows of two lists, and of a third one from the analysis after denoising.
std::string list_table(const json& document, const char* x, const char* y, const std::string& unit) {
  const json& after = document["after_wmra"];
  std::vector<std::vector<std::string>> table = {{x, y + (unit.empty() ? "" : " " + unit)}};
  if (!after.is_null()) table.front().emplace_back("after WMRA");
  for (const std::size_t i : thinned(document[x].size())) {
    table.push_back({short_number(document[x][i]), short_number(document[y][i])});
    if (!after.is_null()) table.back().push_back(short_number(after[y][i]));
  }
  return text_table(table);
}

}  // namespace

std::string allan_text(const json& document) {
  const std::string unit = document["unit"];
  std::vector<std::vector<std::string>> table = {{"tau s", "adev", "oadev", "95 % from", "to", "mdev", "ohdev"}};
  for (std::size_t i = 0; i < document["tau_s"].size(); ++i) {
    const json& interval = i < document["ci95"].size() ? document["ci95"][i] : json::array({nullptr, nullptr});
    table.push_back({short_number(document["tau_s"][i]), short_number(document["adev"][i]),
                     short_number(document["oadev"][i]), short_number(interval[0]), short_number(interval[1]),
                     short_number(document["mdev"][i]), short_number(document["ohdev"][i])});
  }
  std::string text = header_line(document) + text_table(table);
  if (!document["coefficients"].empty()) text += "\n" + coefficient_table(document["coefficients"]);
  return text + warning_lines(document);
}

std::string psd_text(const json& document) {
  return header_line(document) +
         fmt::format("{} sections, {:.0f} degrees of freedom; integrates to a standard deviation of {:.6g} {}\n",
                     document["sections"].get<std::size_t>(), document["degrees_of_freedom"].get<double>(),
                     std::sqrt(document["variance"].get<double>()), document["unit"].get<std::string>()) +
         list_table(document, "frequency_hz", "psd", document["psd_unit"]);
}

std::string acf_text(const json& document) {
  std::string text = header_line(document) + correlation_lines(document);
  if (!document["after_wmra"].is_null()) text += "after WMRA: " + correlation_lines(document["after_wmra"]);
  return text + list_table(document, "lag_s", "acf", "");
}

}  // namespace soak::station
