// SPDX-License-Identifier: Apache-2.0
#include "station/archive/archive_record.h"

#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <system_error>
#include <variant>

#include "base/text.h"

namespace soak::station {
namespace {

using nlohmann::json;

constexpr std::string_view kRecordFormat = "soak-archive-1";
/// One for each repair of a unit. A pull begins them one by one.
constexpr std::int32_t kMostEpochs = 1000;

json value_json(const db::RecordValue& value) {
  return std::visit(
      [](const auto& held) {
        if constexpr (std::is_same_v<std::decay_t<decltype(held)>, std::monostate>) {
          return json();
        } else {
          return json(held);
        }
      },
      value);
}

/// Throws json::exception.
db::RecordValue value_of_json(const json& value) {
  if (value.is_null()) return std::monostate{};
  if (value.is_number_integer()) return value.get<std::int64_t>();
  if (value.is_number_float()) return value.get<double>();
  return value.get<std::string>();
}

json run_json(const db::RunRecord& run) {
  json tables = json::array();
  for (const db::RecordTable& table : run.tables) {
    json rows = json::array();
    for (const auto& row : table.rows) {
      json values = json::array();
      for (const db::RecordValue& value : row) values.push_back(value_json(value));
      rows.push_back(std::move(values));
    }
    tables.push_back({{"name", table.name}, {"columns", table.columns}, {"rows", std::move(rows)}});
  }
  return {{"unit", run.unit}, {"numbers_sha256", run.numbers_sha256}, {"tables", std::move(tables)}};
}

/// Throws json::exception.
db::RunRecord run_of_json(const json& document, const std::string& run_id) {
  db::RunRecord run{run_id, document.at("unit"), document.at("numbers_sha256"), {}};
  for (const json& entry : document.at("tables")) {
    db::RecordTable& table = run.tables.emplace_back();
    entry.at("name").get_to(table.name);
    entry.at("columns").get_to(table.columns);
    for (const json& values : entry.at("rows")) {
      std::vector<db::RecordValue>& row = table.rows.emplace_back();
      for (const json& value : values) row.push_back(value_of_json(value));
    }
  }
  return run;
}

template <class T>
json or_null(const std::optional<T>& value) {
  return value ? json(*value) : json();
}

template <class T>
std::optional<T> optional_of(const json& value) {
  return value.is_null() ? std::nullopt : std::optional(value.get<T>());
}

json void_json(const db::VoidRecord& record) {
  return {{"unit", record.unit},
          {"visit", or_null(record.visit)},
          {"position", or_null(record.position)},
          {"attempt", or_null(record.attempt)},
          {"reason", record.reason},
          {"user", record.user},
          {"utc_s", record.utc_s}};
}

/// Throws json::exception.
db::VoidRecord void_of_json(const json& document, const std::string& run_id) {
  db::VoidRecord record;
  record.run_id = run_id;
  document.at("unit").get_to(record.unit);
  record.visit = optional_of<std::int32_t>(document.at("visit"));
  record.position = optional_of<std::string>(document.at("position"));
  record.attempt = optional_of<std::int32_t>(document.at("attempt"));
  document.at("reason").get_to(record.reason);
  document.at("user").get_to(record.user);
  document.at("utc_s").get_to(record.utc_s);
  return record;
}

/// Throws json::exception.
ArchiveRecord record_of_json(const json& document) {
  ArchiveRecord record;
  document.at("run").get_to(record.run_id);
  document.at("file").get_to(record.file_name);
  document.at("file_sha256").get_to(record.file_sha256);
  document.at("bytes").get_to(record.bytes);
  document.at("campaign").get_to(record.campaign);
  document.at("procedure").get_to(record.procedure);
  document.at("label").get_to(record.label);
  document.at("created_utc_s").get_to(record.created_utc_s);
  document.at("references").get_to(record.references);
  for (const json& unit : document.at("units")) {
    record.units.push_back({unit.at("serial"), unit.at("type"), unit.at("epoch")});
  }
  for (const json& run : document.at("runs")) record.runs.push_back(run_of_json(run, record.run_id));
  for (const json& entry : document.at("voids")) record.voids.push_back(void_of_json(entry, record.run_id));
  return record;
}

/// Names become paths and rows of records that nobody can change.
bool is_plausible(const ArchiveRecord& record) {
  // Every recording and import names its file so; any other name may be that of another run's file here.
  bool is = base::is_uuid(record.run_id) && record.file_name == record.run_id + ".soakrun" &&
            base::bytes_of_hex<32>(record.file_sha256) && !record.units.empty() &&
            record.units.size() == record.runs.size();
  for (const std::string* text : {&record.campaign, &record.procedure, &record.label}) {
    is = is && base::is_plain_line(*text);
  }
  for (std::size_t i = 0; is && i < record.units.size(); ++i) {
    const auto& [serial, type, epoch] = record.units[i];
    is = serial == record.runs[i].unit && base::is_plain_line(serial) && base::is_plain_line(type) && epoch >= 0 &&
         epoch <= kMostEpochs;
  }
  for (const db::VoidRecord& entry : record.voids) {
    is = is && base::is_plain_line(entry.unit) && base::is_plain_line(entry.position.value_or("")) &&
         base::is_plain_line(entry.reason) && base::is_plain_line(entry.user);
  }
  return is;
}

}  // namespace

base::Result<std::string> archive_record(const db::Catalog& catalog, const std::vector<db::RunRow>& rows) {
  const db::RunRow& first = rows.front();
  json units = json::array();
  json runs = json::array();
  for (const db::RunRow& row : rows) {
    const auto unit = catalog.unit(row.unit);
    if (!unit) return base::forward_error(unit);
    if (!*unit) return base::corrupt(fmt::format("run {} is of unit {}, which is not there", row.run_id, row.unit));
    const auto run = catalog.run_record(row.run_id, row.unit);
    if (!run) return base::forward_error(run);
    units.push_back({{"serial", row.unit}, {"type", (*unit)->type}, {"epoch", (*unit)->epoch}});
    runs.push_back(run_json(*run));
  }
  const auto voids = catalog.voids(first.run_id);
  if (!voids) return base::forward_error(voids);
  json void_records = json::array();
  for (const db::VoidRecord& record : *voids) void_records.push_back(void_json(record));
  const auto references = catalog.campaign_references(first.campaign);
  if (!references) return base::forward_error(references);
  std::error_code ignored;
  // Of dropped samples as it was, so that the record stays the one that was made before.
  const std::uint64_t bytes = first.samples_dropped ? first.samples_dropped->bytes
                                                    : std::filesystem::file_size(catalog.run_file_path(first), ignored);
  return json{{"format", kRecordFormat},
              {"run", first.run_id},
              {"file", first.file_name},
              {"file_sha256", first.file_sha256},
              {"bytes", bytes},
              {"campaign", first.campaign},
              {"procedure", first.procedure},
              {"label", first.label},
              {"created_utc_s", first.created_utc_s},
              {"references", references->size()},
              {"units", std::move(units)},
              {"runs", std::move(runs)},
              {"voids", std::move(void_records)}}
      .dump();
}

base::Result<ArchiveRecord> read_archive_record(std::string_view text, const std::string& where) {
  const json document = json::parse(text, nullptr, false);
  try {
    const std::string format = document.is_object() ? document.value("format", "") : "";
    if (format != kRecordFormat && format.starts_with("soak-archive-")) {
      return base::bad_input(fmt::format("has the format {}, which a newer version of Soak reads", format), where);
    }
    ArchiveRecord record = record_of_json(document);
    if (format == kRecordFormat && is_plausible(record)) return record;
    return base::corrupt("is no record of a run", where);
  } catch (const json::exception& error) {
    return base::corrupt(fmt::format("is no record of a run: {}", error.what()), where);
  }
}

}  // namespace soak::station
