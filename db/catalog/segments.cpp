// SPDX-License-Identifier: Apache-2.0
#include <SQLiteCpp/Statement.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "db/catalog/detail/impl.h"
#include "db/catalog/detail/run_digest.h"
#include "db/catalog/detail/seals.h"
#include "db/detail/sqlite.h"

namespace soak::db {
namespace {

using Names = std::vector<std::string>;

Names joined(Names names, const Names& more) {
  names.insert(names.end(), more.begin(), more.end());
  return names;
}

Names statistics_columns() {
  Names names;
  for (const auto sensor : calib::kSensorNames) {
    for (const char* what : {"_count", "_mean", "_variance", "_se"}) names.push_back(std::string(sensor) + what);
  }
  return names;
}

const Names& segment_columns() {
  static const Names kNames = [] {
    Names names = {"visit",          "position", "attempt", "phase",          "sweep",       "plateau_c",
                   "position_label", "up_x",     "up_y",    "up_z",           "azimuth_deg", "rate_dps",
                   "t_start_s",      "t_end_s",  "temp_c",  "temp_rate_kpmin"};
    for (const auto sensor : calib::kSensorNames) names.push_back(std::string(sensor) + "_temp_c");
    return joined(names, statistics_columns());
  }();
  return kNames;
}

const Names& block_columns() {
  static const Names kNames = [] {
    Names names = {"visit", "position", "attempt", "ordinal", "t_s", "duration_s", "temp_c", "temp_rate_kpmin"};
    for (const auto sensor : calib::kSensorNames) names.push_back(std::string(sensor) + "_temp_c");
    return joined(names, statistics_columns());
  }();
  return kNames;
}

const Names& finding_columns() {
  static const Names kNames = {"visit", "position", "attempt", "ordinal", "code", "severity", "sensor", "text"};
  return kNames;
}

std::string list_of(const Names& names) {
  std::string list;
  for (const std::string& name : names) list.append(list.empty() ? "" : ", ").append(name);
  return list;
}

/// INSERT of run_id, unit and the columns.
std::string insert_into(const char* table, const Names& columns) {
  std::string sql = std::string("INSERT INTO ") + table + " (run_id, unit, " + list_of(columns) + ") VALUES (?, ?";
  for (std::size_t i = 0; i < columns.size(); ++i) sql += ", ?";
  return sql += ")";
}

void add_statistics(sqlite::Binder& binder, const std::array<calib::SensorStatistics, calib::kSensorCount>& sensors) {
  for (const calib::SensorStatistics& sensor : sensors) {
    binder.add(sensor.count).add(sensor.mean).add(sensor.variance).add(sensor.standard_error);
  }
}

void read_statistics(sqlite::Fields& fields, std::array<calib::SensorStatistics, calib::kSensorCount>& sensors) {
  for (calib::SensorStatistics& sensor : sensors) {
    sensor.count = static_cast<std::size_t>(fields.integer());
    sensor.mean = fields.real();
    sensor.variance = fields.real();
    sensor.standard_error = fields.real();
  }
}

void add_position(sqlite::Binder& binder, const std::optional<calib::Position>& position) {
  if (!position) {
    for (int i = 0; i < 6; ++i) binder.add_null();
    return;
  }
  binder.add(position->label);
  for (const double component : position->up) binder.add(component);
  binder.add(position->azimuth_deg).add(position->rate_dps);
}

std::optional<calib::Position> read_position(sqlite::Fields& fields) {
  const auto label = fields.optional_text();
  calib::Position position;
  for (double& component : position.up) component = fields.real();
  position.azimuth_deg = fields.optional_real();
  position.rate_dps = fields.optional_real();
  if (!label) return std::nullopt;
  position.label = *label;
  return position;
}

/// Inserts the parts of a segment into a table that numbers them by an ordinal; `add_rest` binds the columns after it.
template <class Part, class AddRest>
void insert_parts(SQLite::Database& database, const char* table, const Names& columns, const calib::SegmentKey& key,
                  const std::vector<Part>& parts, const AddRest& add_rest) {
  SQLite::Statement insert(database, insert_into(table, columns));
  for (std::size_t ordinal = 0; ordinal < parts.size(); ++ordinal) {
    sqlite::Binder binder(insert);
    binder.add(key.run_id).add(key.unit).add(key.visit).add(key.position).add(key.attempt).add(ordinal);
    add_rest(binder, parts[ordinal]);
    insert.exec();
    insert.reset();
  }
}

void add_block(sqlite::Binder& binder, const calib::Block& block) {
  binder.add(block.t_s).add(block.duration_s).add(block.temp_c).add(block.temp_rate_kpmin);
  for (const double temp_c : block.sensor_temp_c) binder.add(temp_c);
  add_statistics(binder, block.sensor);
}

void add_finding(sqlite::Binder& binder, const calib::Finding& finding) {
  binder.add(finding.code).add(calib::name_of(finding.severity));
  binder.add(finding.sensor ? std::optional(calib::name_of(*finding.sensor)) : std::nullopt).add(finding.text);
}

calib::Segment segment_from(sqlite::Fields& fields, std::string_view run_id, std::string_view unit) {
  calib::Segment segment;
  segment.key.run_id = run_id;
  segment.key.unit = unit;
  segment.key.visit = fields.integer32();
  segment.key.position = fields.text();
  segment.key.attempt = fields.integer32();
  segment.phase = fields.text() == "ramp" ? calib::Phase::ramp : calib::Phase::soak;
  segment.sweep = calib::sweep_named(fields.text());
  segment.plateau_c = fields.optional_real();
  segment.position = read_position(fields);
  segment.t_start_s = fields.real();
  segment.t_end_s = fields.real();
  segment.temp_c = fields.real();
  segment.temp_rate_kpmin = fields.real();
  for (double& temp_c : segment.sensor_temp_c) temp_c = fields.real();
  read_statistics(fields, segment.sensor);
  return segment;
}

/// Whether a void record withdraws segment `s`.
constexpr std::string_view kIsWithdrawn =
    "EXISTS (SELECT 1 FROM void AS v WHERE v.run_id = s.run_id AND v.unit = s.unit AND "
    "(v.visit IS NULL OR v.visit = s.visit) AND (v.position IS NULL OR v.position = s.position) AND "
    "(v.attempt IS NULL OR v.attempt = s.attempt))";

enum class Withdrawn : std::uint8_t { left_out, among_them };

std::vector<calib::Segment> read_segments(const SQLite::Database& database, std::string_view run_id,
                                          std::string_view unit, Withdrawn withdrawn) {
  const std::string only = withdrawn == Withdrawn::left_out ? " AND NOT " + std::string(kIsWithdrawn) : std::string();
  return sqlite::rows_of(
      database,
      "SELECT " + list_of(segment_columns()) + " FROM segment AS s WHERE run_id = ? AND unit = ?" + only +
          " ORDER BY t_start_s, visit, attempt, position",
      [&](sqlite::Fields& fields) { return segment_from(fields, run_id, unit); }, run_id, unit);
}

/// Gives each segment its rows of a table that numbers them by an ordinal; those of withdrawn segments are left out.
/// `take` reads the fields after the ordinal.
void read_parts(const SQLite::Database& database, std::string_view run_id, std::string_view unit, const char* table,
                const Names& columns, std::vector<calib::Segment>& segments,
                const std::function<void(sqlite::Fields&, calib::Segment&)>& take) {
  std::map<std::tuple<std::int32_t, std::string, std::int32_t>, calib::Segment*> by_key;
  for (calib::Segment& segment : segments) {
    by_key[{segment.key.visit, segment.key.position, segment.key.attempt}] = &segment;
  }
  SQLite::Statement query(database, "SELECT " + list_of(columns) + " FROM " + table +
                                        " WHERE run_id = ? AND unit = ? ORDER BY visit, position, attempt, ordinal");
  sqlite::bind_all(query, run_id, unit);
  while (query.executeStep()) {
    sqlite::Fields fields(query);
    const std::int32_t visit = fields.integer32();
    std::string position = fields.text();
    const auto found = by_key.find({visit, std::move(position), fields.integer32()});
    if (found == by_key.end()) continue;
    static_cast<void>(fields.integer());  // the ordinal, by which the rows are in order
    take(fields, *found->second);
  }
}

void take_block(sqlite::Fields& fields, calib::Segment& segment) {
  calib::Block& block = segment.blocks.emplace_back();
  block.t_s = fields.real();
  block.duration_s = fields.real();
  block.temp_c = fields.real();
  block.temp_rate_kpmin = fields.real();
  for (double& temp_c : block.sensor_temp_c) temp_c = fields.real();
  read_statistics(fields, block.sensor);
}

void take_finding(sqlite::Fields& fields, calib::Segment& segment) {
  calib::Finding& finding = segment.findings.emplace_back();
  finding.code = fields.text();
  finding.severity = calib::severity_named(fields.text());
  if (const auto sensor = fields.optional_text()) finding.sensor = calib::sensor_named(*sensor);
  finding.text = fields.text();
}

/// Tables that say which segments of which runs there are, and what they belong to.
constexpr std::array<std::string_view, 4> kSealedOfFits = {"run", "void", "unit", "sample_drop"};

}  // namespace

namespace catalog {

void insert_segment(SQLite::Database& database, const calib::Segment& segment) {
  SQLite::Statement insert(database, insert_into("segment", segment_columns()));
  sqlite::Binder binder(insert);
  const calib::SegmentKey& key = segment.key;
  binder.add(key.run_id).add(key.unit).add(key.visit).add(key.position).add(key.attempt);
  binder.add(std::string_view(segment.phase == calib::Phase::ramp ? "ramp" : "soak"));
  binder.add(calib::name_of(segment.sweep)).add(segment.plateau_c);
  add_position(binder, segment.position);
  binder.add(segment.t_start_s).add(segment.t_end_s).add(segment.temp_c).add(segment.temp_rate_kpmin);
  for (const double temp_c : segment.sensor_temp_c) binder.add(temp_c);
  add_statistics(binder, segment.sensor);
  insert.exec();
  insert_parts(database, "block", block_columns(), key, segment.blocks, add_block);
  insert_parts(database, "finding", finding_columns(), key, segment.findings, add_finding);
}

}  // namespace catalog

base::Status Catalog::Impl::check_run_of_fits(std::string_view run_id, std::string_view unit) {
  if (!seals_are_sound) {
    if (auto whole = catalog::check_seals(connection, kSealedOfFits); !whole) return whole;
    seals_are_sound = true;
  }
  if (auto known = catalog::require_run(connection, run_id, unit); !known) return known;
  const auto checked = std::pair(std::string(run_id), std::string(unit));
  if (sound.contains(checked)) return {};
  if (auto stored = catalog::check_numbers(connection, run_id, unit); !stored) return stored;
  sound.insert(checked);
  return {};
}

base::Result<std::vector<calib::Segment>> Catalog::segments(std::string_view run_id, std::string_view unit,
                                                            bool with_blocks) const {
  return impl_->connection.snapshot("read the segments", [&]() -> base::Result<std::vector<calib::Segment>> {
    if (const auto sound = impl_->check_run_of_fits(run_id, unit); !sound) return base::forward_error(sound);
    auto segments = read_segments(impl_->database(), run_id, unit, Withdrawn::left_out);
    read_parts(impl_->database(), run_id, unit, "finding", finding_columns(), segments, take_finding);
    if (with_blocks) read_parts(impl_->database(), run_id, unit, "block", block_columns(), segments, take_block);
    return segments;
  });
}

base::Result<std::vector<calib::Segment>> Catalog::recorded_segments(std::string_view run_id,
                                                                     std::string_view unit) const {
  return impl_->connection.snapshot("read the segments", [&]() -> base::Result<std::vector<calib::Segment>> {
    if (const auto sound = impl_->check_run_of_fits(run_id, unit); !sound) return base::forward_error(sound);
    auto segments = read_segments(impl_->database(), run_id, unit, Withdrawn::among_them);
    read_parts(impl_->database(), run_id, unit, "finding", finding_columns(), segments, take_finding);
    return segments;
  });
}

base::Result<std::vector<SegmentCounts>> Catalog::segment_counts() const {
  const std::string withdrawn(kIsWithdrawn);
  return impl_->rows("count the segments",
                     "SELECT run_id, unit, count(*), sum(withdrawn), sum(NOT withdrawn AND rejected) FROM (SELECT "
                     "s.run_id, s.unit, " +
                         withdrawn +
                         " AS withdrawn, EXISTS (SELECT 1 FROM finding AS f WHERE f.run_id = s.run_id AND "
                         "f.unit = s.unit AND f.visit = s.visit AND f.position = s.position AND "
                         "f.attempt = s.attempt AND f.severity = 'reject') AS rejected FROM segment AS s) "
                         "GROUP BY run_id, unit",
                     [](sqlite::Fields& fields) {
                       SegmentCounts counts;
                       counts.run_id = fields.text();
                       counts.unit = fields.text();
                       counts.recorded = static_cast<std::uint64_t>(fields.integer());
                       counts.withdrawn = static_cast<std::uint64_t>(fields.integer());
                       counts.rejected = static_cast<std::uint64_t>(fields.integer());
                       return counts;
                     });
}

}  // namespace soak::db
