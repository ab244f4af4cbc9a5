// SPDX-License-Identifier: Apache-2.0
#include "station/import/detail/csv_columns.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <set>
#include <string>
#include <utility>

#include "calib/vocabulary/position.h"
#include "calib/vocabulary/sensor.h"
#include "station/io/csv_scanner.h"

namespace soak::station {
namespace {

using base::bad_input;

const MappedColumn* mapped(const ColumnsMap& map, std::string_view header) {
  const auto found = std::find_if(map.columns.begin(), map.columns.end(),
                                  [&](const MappedColumn& column) { return column.source == header; });
  return found == map.columns.end() ? nullptr : &*found;
}

std::optional<std::string> refuse_phase(std::string_view label) {
  if (label == "soak" || label == "ramp") return std::nullopt;
  return fmt::format("unknown phase '{}': known are soak and ramp", label);
}

std::optional<std::string> refuse_sweep(std::string_view label) {
  if (label == "up" || label == "down") return std::nullopt;
  return fmt::format("unknown sweep '{}': known are up and down", label);
}

std::optional<std::string> refuse_position(const ColumnsMap& map, std::string_view label) {
  if (calib::position_named(label)) return std::nullopt;
  std::vector<std::string_view> known(calib::kSixPositionLabels.begin(), calib::kSixPositionLabels.end());
  for (const calib::Position& position : map.positions) {
    if (position.label == label) return std::nullopt;
    if (!calib::position_named(position.label)) known.push_back(position.label);
  }
  return fmt::format("unknown position '{}': known are {}; give others in [positions] of a columns map", label,
                     fmt::join(known, ", "));
}

/// Fills in what the role of the column asks for.
void apply_role(ColumnPlan& plan, const HeaderMeaning& meaning, const ColumnsMap& map) {
  plan.role = meaning.role;
  plan.channel.name = meaning.name;
  plan.channel.unit = meaning.unit;
  plan.channel.scale *= meaning.scale;
  plan.channel.offset *= meaning.scale;
  plan.is_label = plan.is_label || meaning.unit == "label";
  if (meaning.role == ColumnRole::phase) plan.refuse_label = refuse_phase;
  if (meaning.role == ColumnRole::sweep) plan.refuse_label = refuse_sweep;
  if (meaning.role == ColumnRole::position) {
    plan.refuse_label = [&map](std::string_view label) { return refuse_position(map, label); };
  }
}

base::Result<ColumnPlan> plan_of(std::size_t cell, std::string_view header, const ColumnsMap& map) {
  ColumnPlan plan;
  plan.cell = cell;
  plan.header = header;
  plan.channel.source_name = header;
  if (const MappedColumn* column = mapped(map, header)) {
    plan.is_label = column->is_label;
    plan.type = column->type;
    plan.channel.scale = column->scale;
    plan.channel.offset = column->offset;
    plan.channel.labels = column->labels;
    apply_role(plan, column->meaning, map);
    for (const std::string& label : column->labels) {
      const auto refused = plan.refuse_label ? plan.refuse_label(label) : std::nullopt;
      if (refused) return bad_input(fmt::format("the columns map gives column '{}' an {}", header, *refused));
    }
    return plan;
  }
  const auto meaning = meaning_of_header(header);
  if (!meaning) return base::forward_error(meaning);
  apply_role(plan, *meaning, map);
  return plan;
}

/// Constants of the map become columns whose cells are not in the file.
base::Status add_constants(CsvLayout& layout, const ColumnsMap& map) {
  for (const auto& [header, cell] : map.constants) {
    const auto meaning = meaning_of_header(header);
    if (!meaning) return base::forward_error(meaning);
    ColumnPlan plan;
    plan.constant = cell;
    plan.header = header;
    plan.channel.source_name = header;
    apply_role(plan, *meaning, map);
    layout.columns.push_back(std::move(plan));
  }
  return {};
}

base::Status check_given_once(const CsvLayout& layout) {
  std::map<std::string, std::string> header_of;
  for (const ColumnPlan& plan : layout.columns) {
    const auto [other, is_new] = header_of.emplace(plan.channel.name, plan.header);
    if (is_new) continue;
    return bad_input(fmt::format("columns '{}' and '{}' both give {}: remove one of them", other->second, plan.header,
                                 plan.channel.name));
  }
  return {};
}

base::Status check_required(const CsvLayout& layout, const std::vector<std::string_view>& header) {
  const auto has = [&](std::string_view name) {
    return std::any_of(layout.columns.begin(), layout.columns.end(),
                       [&](const ColumnPlan& plan) { return plan.channel.name == name; });
  };
  const bool has_sensor = std::any_of(calib::kSensorNames.begin(), calib::kSensorNames.end(), has);
  std::vector<std::string_view> missing;
  if (!has("t_s")) missing.emplace_back("t_s");
  if (!has("temp_c")) missing.emplace_back("temp_c");
  if (!has_sensor) missing.emplace_back("one sensor (gx_dps ... az_mps2)");
  if (missing.empty()) return {};
  return bad_input(
      fmt::format("no column for {}; the header has: {}. Rename the columns, or map them with --columns (which can "
                  "also set another separator)",
                  fmt::join(missing, ", "), fmt::join(header, ", ")));
}

/// The rate of a position stands in a column or beside the position's direction, not in both, and never alone.
base::Status check_rate(const CsvLayout& layout, const ColumnsMap& map) {
  const auto find = [&](std::string_view name) {
    return std::find_if(layout.columns.begin(), layout.columns.end(),
                        [&](const ColumnPlan& plan) { return plan.channel.name == name; });
  };
  const auto rate = find("rate_dps");
  if (rate == layout.columns.end()) return {};
  if (find("position") == layout.columns.end()) {
    return bad_input(
        fmt::format("column '{}' gives the rate at which the fixture turns about the vertical, but no column gives the "
                    "axis that points up: add 'position'",
                    rate->header));
  }
  for (const calib::Position& position : map.positions) {
    if (!position.rate_dps) continue;
    return bad_input(
        fmt::format("the columns map states a rate of position '{}', and column '{}' gives one too: keep one of them",
                    position.label, rate->header));
  }
  return {};
}

base::Status check_map_is_used(const ColumnsMap& map, const std::vector<std::string_view>& header) {
  for (const MappedColumn& column : map.columns) {
    if (std::find(header.begin(), header.end(), column.source) != header.end()) continue;
    return bad_input(fmt::format("the columns map names column '{}', which is not in the header: {}", column.source,
                                 fmt::join(header, ", ")));
  }
  return {};
}

base::Status check_names(const std::vector<std::string_view>& header) {
  std::set<std::string_view> seen;
  for (std::size_t i = 0; i < header.size(); ++i) {
    if (header[i].empty()) return bad_input(fmt::format("column {} of {} has no name", i + 1, header.size()));
    if (!seen.insert(header[i]).second) return bad_input(fmt::format("column '{}' is duplicated", header[i]));
  }
  return {};
}

}  // namespace

base::Result<CsvLayout> layout_of_csv(const std::vector<std::string_view>& raw_header, const ColumnsMap& map) {
  std::vector<std::string_view> header;
  for (const std::string_view cell : raw_header) header.push_back(trimmed(cell));
  if (auto status = check_names(header); !status) return base::forward_error(status);
  if (auto status = check_map_is_used(map, header); !status) return base::forward_error(status);

  CsvLayout layout;
  layout.cells = header.size();
  for (std::size_t i = 0; i < header.size(); ++i) {
    auto plan = plan_of(i, header[i], map);
    if (!plan) return base::forward_error(plan);
    if (plan->role == ColumnRole::run && layout.run) {
      return bad_input(
          fmt::format("columns '{}' and '{}' both give the run: remove one of them", header[*layout.run], header[i]));
    }
    if (plan->role == ColumnRole::run) {
      layout.run = i;
      layout.run_header = header[i];
    } else {
      layout.columns.push_back(*std::move(plan));
    }
  }
  if (auto status = add_constants(layout, map); !status) return base::forward_error(status);
  if (auto status = check_given_once(layout); !status) return base::forward_error(status);
  if (auto status = check_required(layout, header); !status) return base::forward_error(status);
  if (auto status = check_rate(layout, map); !status) return base::forward_error(status);
  const auto time = std::find_if(layout.columns.begin(), layout.columns.end(),
                                 [](const ColumnPlan& plan) { return plan.role == ColumnRole::time; });
  std::rotate(layout.columns.begin(), time, time + 1);
  return layout;
}

}  // namespace soak::station
