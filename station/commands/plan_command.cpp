// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <nlohmann/json.hpp>
#include <ranges>
#include <string_view>
#include <utility>

#include "base/text.h"
#include "station/commands/command.h"
#include "station/commands/shared.h"
#include "station/config/procedure.h"
#include "station/io/text_file.h"
#include "station/plan/campaign_plan.h"

namespace soak::station {
namespace {

/// soak plan --type NAME -o FILE
struct PlanCommand final : CatalogCommand {
  std::string type;
  PlanRequest request;
  std::string file;

  void declare(OptionList& options) override;
  base::Status run_with(db::Catalog& catalog, Output& output) override;
};

/// "gyro_dps=0.01,accel_mps2=0.005", either or both.
base::Status read_accuracy(const std::string& text, PlanRequest& request) {
  constexpr const char* kRight = "must be gyro_dps=X, accel_mps2=Y or both with a comma between, each above 0";
  for (const auto field : std::views::split(text, ',')) {
    const std::string_view part(field.begin(), field.end());
    const std::size_t equals = part.find('=');
    if (equals == std::string_view::npos) return base::bad_input(kRight);
    const auto value = base::parse_double(part.substr(equals + 1));
    const std::string_view key = part.substr(0, equals);
    if ((key == "gyro_dps" && request.gyro) || (key == "accel_mps2" && request.accel)) {
      return base::bad_input(fmt::format("'{}' may be given once only", key));
    }
    if (!value || !(*value > 0.0) || (key != "gyro_dps" && key != "accel_mps2")) return base::bad_input(kRight);
    if (key == "gyro_dps") request.gyro = *value / calib::printed_per_si(calib::Sensor::gyro_x);
    if (key == "accel_mps2") request.accel = value;
  }
  return {};
}

void PlanCommand::declare(OptionList& options) {
  options.add("--type NAME", &type, "Unit type: its stored units, or its file, say what to expect").required();
  options.add(
      "--accuracy gyro_dps=X,accel_mps2=Y", [this](const std::string& text) { return read_accuracy(text, request); },
      "Half-width of the 95 % band of the mean curve that is wanted at all temperatures (default: what is expected of "
      "the "
      "full campaign)");
  options.add("--hours H", &request.hours, "Hours of the chamber, at most").range(1.0, 100'000.0);
  options.add("-o,--output FILE", &file, "Procedure to write").required();
}

std::string printed(const std::optional<calib::ExpectedBand>& band, calib::Sensor sensor, bool shape) {
  if (!band) return "-";
  return fmt::format("{:.3g}", (shape ? band->worst_shape() : band->worst_curve()) * calib::printed_per_si(sensor));
}

/// The sensor of one kind that has the widest band.
calib::Sensor widest_of(const PlanOption& option, bool gyro) {
  calib::Sensor widest = gyro ? calib::Sensor::gyro_x : calib::Sensor::accel_x;
  double largest = -1.0;
  for (const calib::Sensor sensor : calib::kSensors) {
    const auto& band = option.bands[index_of(sensor)];
    if (is_gyro(sensor) != gyro || !band || band->worst_curve() <= largest) continue;
    largest = band->worst_curve();
    widest = sensor;
  }
  return widest;
}

std::vector<std::string> option_row(const PlanOption& option, const char* mark) {
  const PassDesign& design = option.design;
  std::vector<std::string> row = {fmt::format("{:.1f}", option.hours),
                                  std::to_string(design.passes),
                                  std::to_string(design.plateaus),
                                  design.return_every == 0 ? "none" : fmt::format("every {}", design.return_every),
                                  std::to_string(option.power_ons),
                                  fmt::format("{:.0f}", design.dwell_s)};
  for (const bool gyro : {true, false}) {
    const calib::Sensor sensor = widest_of(option, gyro);
    for (const bool shape : {true, false}) row.push_back(printed(option.bands[index_of(sensor)], sensor, shape));
  }
  row.push_back(fmt::format("{:.2f}", option.relative));
  row.emplace_back(mark);
  return row;
}

std::string plan_text(const CampaignPlan& plan) {
  std::vector<std::vector<std::string>> rows = {{"hours", "passes", "plateaus", "back", "power-ons", "dwell s",
                                                 "gyro shape", "gyro curve", "accel shape", "accel curve", "relative",
                                                 ""}};
  for (std::size_t i = 0; i < plan.options.size(); ++i) {
    rows.push_back(option_row(plan.options[i], i == plan.chosen ? "<- chosen" : ""));
  }
  rows.push_back(option_row(plan.full, "full campaign"));
  return text_table(rows) +
         "bands: half-widths of 95 %, deg/s and m/s2, at the worst temperature of the worst sensor\n";
}

std::string picture_text(const TypePicture& picture) {
  std::string text = fmt::format(
      "{:g} to {:g} °C, expected from {}{}\n", picture.low_c, picture.high_c,
      picture.units.empty() ? "the limits of the type's file" : fmt::format("{}", fmt::join(picture.units, ", ")),
      picture.simulated ? " (SIMULATED)" : "");
  for (const std::string& remark : picture.remarks) text += fmt::format("assumed: {}\n", remark);
  return text;
}

/// What the procedure's file says of itself.
std::string description_of(const PlanOption& chosen, const std::string& type) {
  return fmt::format("Planned for units of type {}: {:.0f} h, {} power-ons.", type, chosen.hours, chosen.power_ons);
}

base::Status PlanCommand::run_with(db::Catalog& catalog, Output& output) {
  const auto known = find_unit_type("", type);
  if (!known) return base::forward_error(known);
  const auto picture = picture_of_type(catalog, *known);
  if (!picture) return base::forward_error(picture);
  const auto plan = plan_campaign(*picture, *known, request);
  if (!plan) return base::forward_error(plan);
  const PlanOption& chosen = plan->options[plan->chosen];
  const std::string text = procedure_text(chosen.design, {picture->low_c, picture->high_c, *known},
                                          fmt::format("planned-{}", known->name), description_of(chosen, known->name));
  if (const auto right = parse_procedure(text, file, {*known}); !right) return base::forward_error(right);
  if (const auto written = write_text_file(file, text); !written) return written;
  if (output.json()) {
    nlohmann::json document = plan_json(*plan, *picture, known->name, request);
    document["file"] = file;
    document["warnings"] = warnings_json(picture->warnings);
    return output.print_json(document);
  }
  output.print(picture_text(*picture));
  output.print(plan_text(*plan));
  output.print(
      fmt::format("{} holds the chosen procedure, {:.1f} h; see: soak procedure check {}\n", file, chosen.hours, file));
  for (const calib::Warning& warning : picture->warnings) output.note("warning: " + warning.text);
  if (chosen.relative > 1.0) {
    output.note(
        fmt::format("the accuracy is not reached within the hours: the band is {:.2f} times as wide", chosen.relative));
  }
  return {};
}

}  // namespace

CommandGroup plan_commands() {
  return {"",
          "",
          {{"plan", "What a campaign of so many chamber hours buys; writes a procedure",
            "soak plan --type mti-300 --hours 100 -o planned.toml", std::make_shared<PlanCommand>()}}};
}

}  // namespace soak::station
