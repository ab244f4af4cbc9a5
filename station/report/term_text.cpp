// SPDX-License-Identifier: Apache-2.0
#include "station/report/term_text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <nlohmann/json.hpp>
#include <ranges>
#include <utility>

#include "base/units.h"
#include "station/io/output.h"

namespace soak::station {
namespace {

constexpr double kSecondsPerMinute = 60.0;
constexpr double kSecondsPer1000h = 3.6e6;

/// One unit for another within a unit of several parts.
struct Replacement {
  std::string_view of;
  std::string_view by;
  double factor;
};

/// In this order, each at most once: what stands first holds what follows.
constexpr std::array kReplacements = {
    Replacement{"(rad/s)/(m/s2)", "deg/s/g", base::kDegPerRad* base::kStandardGravity_mps2},
    Replacement{"(m/s2)/(m/s2)", "m/s2/g", base::kStandardGravity_mps2},
    Replacement{"1/(m/s2)", "m/s2/g2", base::kStandardGravity_mps2* base::kStandardGravity_mps2},
    Replacement{"rad/s/s", "deg/s per 1000 h", base::kDegPerRad* kSecondsPer1000h},
    Replacement{"m/s2/s", "m/s2 per 1000 h", kSecondsPer1000h},
    Replacement{"rad", "deg", base::kDegPerRad},
    Replacement{"/(K/s)", "/(K/min)", 1.0 / kSecondsPerMinute},
};

/// Names that state a unit which is printed as another.
constexpr std::array<std::pair<std::string_view, std::string_view>, 3> kNames = {
    {{"per_kps", "per_kpmin"}, {"per_kps_per_c", "per_kpmin_per_c"}, {"per_s", "per_1000h"}}};

/// The line of an effect of a stored report.
std::string size_of_entry(const nlohmann::json& effect) {
  std::vector<calib::Sensor> sensors;
  for (const nlohmann::json& name : effect.at("sensors")) {
    if (const auto sensor = calib::sensor_named(name.get<std::string>())) sensors.push_back(*sensor);
  }
  const nlohmann::json& magnitude = effect.at("magnitude");
  return size_text(effect.at("name").get<std::string>(), magnitude.at("value").get<double>(),
                   magnitude.at("unit").get<std::string>(), effect.at("shape").get<std::string>(),
                   sensors_text(sensors));
}

/// The lines of a term's effects in a stored report; none where it did not name it.
std::vector<std::string> lines_of(const std::string& document, const std::string& name) {
  std::vector<std::string> lines;
  const auto report = nlohmann::json::parse(document, nullptr, false);
  if (!report.is_object() || !report.contains("effects")) return lines;
  for (const nlohmann::json& effect : report["effects"]) {
    if (effect.at("name") == name) lines.push_back(size_of_entry(effect));
  }
  return lines;
}

}  // namespace

std::string sensors_text(const std::vector<calib::Sensor>& sensors) {
  std::vector<std::string_view> names;
  for (const calib::Sensor sensor : sensors) names.push_back(calib::name_of(sensor));
  return sensors.size() == calib::kSensorCount ? "all sensors" : fmt::format("{}", fmt::join(names, ", "));
}

std::string size_text(std::string_view name, double value, std::string_view unit, std::string_view shape,
                      std::string_view sensors) {
  return fmt::format("{}: {:.3g} {}{}{}, {}", name, value, unit, shape.empty() ? "" : ", ", shape, sensors);
}

base::Result<std::vector<std::string>> size_lines(const db::Catalog& catalog, const std::string& unit,
                                                  const calib::ModelTerm& term) {
  const auto reports = catalog.gap_reports(unit);
  if (!reports) return base::forward_error(reports);
  for (const db::GapReportRow& report : std::views::reverse(*reports)) {
    if (report.model_version != term.parent_version) continue;
    std::vector<std::string> lines = lines_of(report.document, term.name);
    if (!lines.empty()) return lines;
  }
  return std::vector<std::string>{term.name};
}

calib::TermParameter printed_parameter(calib::TermParameter parameter) {
  // A misalignment is printed in radians.
  if (parameter.unit == "rad/K") return parameter;
  for (const auto& [of, by, factor] : kReplacements) {
    const std::size_t at = parameter.unit.find(of);
    if (at == std::string::npos) continue;
    parameter.unit.replace(at, of.size(), by);
    parameter.value *= factor;
  }
  for (const auto& [of, by] : kNames) {
    if (parameter.name == of) parameter.name = by;
  }
  return parameter;
}

std::string parameter_table(const std::vector<calib::ModelTerm>& terms) {
  std::vector<std::vector<std::string>> table = {{"effect", "sensors", "parameter", "value", "unit"}};
  for (const calib::ModelTerm& term : terms) {
    for (const calib::TermPart& part : term.parts) {
      for (const calib::TermParameter& parameter : part.parameters) {
        const calib::TermParameter printed = printed_parameter(parameter);
        table.push_back({term.name, sensors_text(part.sensors), printed.name, fmt::format("{:.4g}", printed.value),
                         printed.unit == "1" ? "" : printed.unit});
      }
    }
  }
  return text_table(table);
}

}  // namespace soak::station
