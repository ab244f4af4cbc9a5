// SPDX-License-Identifier: Apache-2.0
#include "station/commands/check_commands.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <utility>

#include "station/commands/check_text.h"
#include "station/io/data_folder.h"
#include "station/io/host.h"
#include "station/io/text.h"
#include "station/records/check_standard.h"

namespace soak::station {
namespace {

base::Status print_record(const db::CheckStandardRow& record, Output& output) {
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
  return base::bad_input(fmt::format("unit '{}' is no check standard; there is nothing to end", unit), "UNIT");
}

}  // namespace

base::Status run_check_declare(const CheckRecordCommand& command, Output& output) {
  if (command.reason.empty()) return base::bad_input("a check standard needs a reason", "--reason");
  if (auto plain = check_text_line(command.reason, "--reason"); !plain) return plain;
  auto catalog = open_existing_catalog(command.data);
  if (!catalog) return base::forward_error(catalog);
  db::CheckStandardRow row;
  row.unit = command.unit;
  row.since_utc_s = now_utc_s();
  row.reason = command.reason;
  row.user = user_name();
  const auto id = catalog->add_check_standard(row);
  if (!id) return base::forward_error(id);
  const auto record = open_record(*catalog, command.unit);
  if (!record) return base::forward_error(record);
  return print_record(*record, output);
}

base::Status run_check_end(const CheckRecordCommand& command, Output& output) {
  if (command.reason.empty()) return base::bad_input("the end of a check standard needs a reason", "--reason");
  if (auto plain = check_text_line(command.reason, "--reason"); !plain) return plain;
  auto catalog = open_existing_catalog(command.data);
  if (!catalog) return base::forward_error(catalog);
  auto record = open_record(*catalog, command.unit);
  if (!record) return base::forward_error(record);
  record->ended = db::EndRecord{command.reason, user_name(), now_utc_s()};
  if (auto ended = catalog->end_check_standard(record->check_standard_id, *record->ended); !ended) return ended;
  return print_record(*record, output);
}

base::Status run_check_chart(const CheckChartCommand& command, Output& output) {
  const auto catalog = open_existing_catalog(command.data);
  if (!catalog) return base::forward_error(catalog);
  const auto charts = check_charts(*catalog, command.unit);
  if (!charts) return base::forward_error(charts);
  if (output.json()) return output.print_json(check_document(*charts));
  output.print(check_text(*charts));
  return {};
}

}  // namespace soak::station
