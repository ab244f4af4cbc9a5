// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "station/commands/command.h"
#include "station/commands/shared.h"
#include "station/io/data_folder.h"
#include "station/io/host.h"
#include "station/io/output.h"
#include "station/io/text.h"
#include "station/records/check_standard.h"

namespace soak::station {
namespace {

/// soak check declare UNIT --reason TEXT
struct CheckDeclare : CatalogCommand {
  std::string unit;
  std::string reason;

  void declare(OptionList& options) override {
    options.add("unit UNIT", &unit, "Serial number").required();
    options.add("--reason TEXT", &reason, "Reason, for the record").required();
  }
  base::Status run_with(db::Catalog& catalog, Output& output) override;
};

/// soak check end UNIT --reason TEXT
struct CheckEnd final : CheckDeclare {
  base::Status run_with(db::Catalog& catalog, Output& output) override;
};

/// soak check chart: prints the charts; verdicts do not change the exit status.
struct CheckChartCommand final : CatalogCommand {
  std::optional<std::string> unit;  ///< absent: all that are check standards now

  void declare(OptionList& options) override {
    options.add("--unit SN", &unit, "One check standard (default: all current ones)");
  }
  base::Status run_with(db::Catalog& catalog, Output& output) override;
};

using calib::ControlVerdict;
using calib::Estimate;
using calib::Sensor;

std::string five_digits(double value) { return fmt::format("{:.5g}", value); }

std::string with_error(const std::optional<Estimate>& estimate, double factor) {
  if (!estimate) return "-";
  return fmt::format("{:.5g} ± {:.2g}", estimate->value * factor, estimate->standard_error * factor);
}

std::string_view verdict_text(ControlVerdict verdict) {
  return verdict == ControlVerdict::in_control       ? "in control"
         : verdict == ControlVerdict::out_of_control ? "OUT OF CONTROL"
                                                     : "not established";
}

std::string verdict_text(const calib::ControlPoint& point) {
  std::string text(verdict_text(point.verdict));
  if (point.beyond_limits()) text += ", outside the limits";
  if (point.shifted()) text += ", shifted over the last eight campaigns";
  return text;
}

std::vector<std::string> point_row(const CheckCampaign& campaign, const CheckSensor& sensor, double factor) {
  const auto limit = [&](double calib::ControlLimits::* which) {
    return sensor.point.limits ? five_digits(*sensor.point.limits.*which * factor) : "-";
  };
  const auto range = sensor.point.moving_range;
  return {campaign.name,
          std::to_string(campaign.runs.size()),
          with_error(sensor.bias, factor),
          limit(&calib::ControlLimits::centre),
          limit(&calib::ControlLimits::lower),
          limit(&calib::ControlLimits::upper),
          range ? five_digits(*range * factor) : "-",
          limit(&calib::ControlLimits::moving_range_upper),
          with_error(sensor.drift, factor),
          verdict_text(sensor.point)};
}

std::string sensor_table(const CheckChart& chart, Sensor sensor) {
  const std::size_t s = calib::index_of(sensor);
  if (!chart.temp_c[s]) return {};
  std::vector<std::vector<std::string>> rows = {
      {"campaign", "runs", "bias", "centre", "lower", "upper", "range", "range limit", "in-run drift", "verdict"}};
  for (const CheckCampaign& campaign : chart.campaigns) {
    if (campaign.sensor[s]) rows.push_back(point_row(campaign, *campaign.sensor[s], calib::printed_per_si(sensor)));
  }
  return fmt::format("\n{}, {}, at a sensor temperature of {:.2f} °C\n{}", calib::name_of(sensor),
                     calib::printed_unit(sensor), *chart.temp_c[s], text_table(rows));
}

/// Campaigns without a point on the charts.
std::string not_charted(const CheckChart& chart) {
  std::vector<std::string> names;
  for (const CheckCampaign& campaign : chart.campaigns) {
    if (std::ranges::none_of(campaign.sensor, [](const auto& sensor) { return sensor.has_value(); })) {
      names.push_back(campaign.name);
    }
  }
  if (names.empty()) return {};
  return fmt::format("not shown, no plateau within {:g} K of {:g} °C: {}\n", calib::kReferenceReach_c,
                     calib::kReferencePlateau_c, fmt::join(names, ", "));
}

std::string check_chart_text(const CheckChart& chart) {
  const bool simulated = std::ranges::any_of(chart.campaigns, &CheckCampaign::simulated);
  const ControlVerdict last =
      chart.campaigns.empty() ? ControlVerdict::not_established : chart.campaigns.back().verdict;
  std::string text = fmt::format("check standard {}, epoch {}{}{}: {} campaigns, the last one {}\n{}", chart.unit,
                                 chart.epoch, chart.ended ? " (ended)" : "", simulated ? " (SIMULATED)" : "",
                                 chart.campaigns.size(), verdict_text(last), not_charted(chart));
  for (const Sensor sensor : calib::kSensors) text += sensor_table(chart, sensor);
  return text;
}

/// The charts as text: one table per sensor, one line per campaign.
std::string check_text(const std::vector<CheckChart>& charts) {
  std::string text;
  for (const CheckChart& chart : charts) text += (text.empty() ? "" : "\n") + check_chart_text(chart);
  return text;
}

base::Status print_check_record(const db::CheckStandardRow& record, Output& output) {
  if (output.json()) {
    return output.print_json({{"unit", record.unit},
                              {"check_standard_id", record.check_standard_id},
                              {"since_utc_s", record.since_utc_s},
                              {"reason", record.reason},
                              {"user", record.user},
                              {"ended", record.ended.has_value()}});
  }
  output.print(fmt::format("unit {} is {} check standard\n", record.unit, record.ended ? "no longer a" : "a"));
  return {};
}

/// The record that makes the unit a check standard now.
base::Result<db::CheckStandardRow> open_record(const db::Catalog& catalog, const std::string& unit) {
  auto records = catalog.check_standards();
  if (!records) return base::forward_error(records);
  for (db::CheckStandardRow& record : *records) {
    if (record.unit == unit && !record.ended) return std::move(record);
  }
  return base::bad_input(fmt::format("unit '{}' is not a check standard", unit), "UNIT");
}

base::Status CheckDeclare::run_with(db::Catalog& catalog, Output& output) {
  if (auto plain = check_text_line(reason, "--reason"); !plain) return plain;
  db::CheckStandardRow row;
  row.unit = unit;
  row.since_utc_s = now_utc_s();
  row.reason = reason;
  row.user = user_name();
  const auto id = catalog.add_check_standard(row);
  if (!id) return base::forward_error(id);
  const auto record = open_record(catalog, unit);
  if (!record) return base::forward_error(record);
  return print_check_record(*record, output);
}

base::Status CheckEnd::run_with(db::Catalog& catalog, Output& output) {
  if (auto plain = check_text_line(reason, "--reason"); !plain) return plain;
  auto record = open_record(catalog, unit);
  if (!record) return base::forward_error(record);
  record->ended = db::EndRecord{reason, user_name(), now_utc_s()};
  if (auto ended = catalog.end_check_standard(record->check_standard_id, *record->ended); !ended) return ended;
  return print_check_record(*record, output);
}

base::Status CheckChartCommand::run_with(db::Catalog& catalog, Output& output) {
  const auto charts = check_charts(catalog, unit);
  if (!charts) return base::forward_error(charts);
  if (output.json()) return output.print_json(check_document(*charts));
  output.print(check_text(*charts));
  return {};
}

}  // namespace

CommandGroup check_commands() {
  return {"check",
          "Check standards: units that are measured in every campaign",
          {{"declare", "Make a unit a check standard",
            "soak check declare SN0001 --reason 'stays in slot 1 of every campaign'", std::make_shared<CheckDeclare>()},
           {"end", "End a unit's use as a check standard", "soak check end SN0001 --reason 'dropped on 2027-03-02'",
            std::make_shared<CheckEnd>()},
           {"chart", "Control charts of the check standards, campaign by campaign", "soak check chart --unit SN0001",
            std::make_shared<CheckChartCommand>()}}};
}

}  // namespace soak::station
