// SPDX-License-Identifier: Apache-2.0
#include "station/runs/run_records.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "calib/estimate/unit_input.h"
#include "calib/segments/data_gate.h"
#include "calib/segments/long_run.h"
#include "calib/segments/segmentation.h"
#include "station/io/host.h"
#include "station/runs/long_run_rows.h"
#include "station/runs/recording_reader.h"
#include "station/runs/run_columns.h"
#include "station/runs/run_streams.h"

namespace soak::station {
namespace {

constexpr std::string_view kUser = "soakd";

db::RunRow row_of(const db::RunInfo& info) {
  db::RunRow row;
  row.run_id = info.run_id;
  row.campaign = info.campaign;
  row.label = info.label;
  row.procedure = info.procedure;
  row.purpose = info.purpose;
  row.created_utc_s = info.created_utc_s;
  row.clock_rate = info.clock_rate;
  row.simulated = info.simulated || info.clock_rate != 1.0;
  row.sealed = true;
  row.site = info.site;
  row.continues = info.continues;
  return row;
}

/// Numbers the visits as `visits` (one value per row, NaN = unknown) says, and the attempts of each position anew.
void number_visits(const calib::Recording& recording, const std::vector<double>& visits,
                   std::vector<calib::Segment>& segments) {
  std::vector<double> numbers;
  for (const calib::Segment& segment : segments) {
    const auto first = std::lower_bound(recording.t_s.begin(), recording.t_s.end(), segment.t_start_s);
    numbers.push_back(visits[static_cast<std::size_t>(first - recording.t_s.begin())]);
  }
  calib::number_visits(numbers, segments);
}

/// Stores what the data gate finds in each segment.
void store_findings(const calib::Examination& examination, std::vector<calib::Segment>& segments) {
  auto findings = examination.findings();
  for (std::size_t i = 0; i < findings.size(); ++i) segments[i].findings = std::move(findings[i]);
}

/// Statistics and data gate, with the samples of one sensor in memory at a time.
base::Status look_at_sensors(const db::RunFileReader& file, const calib::Recording& axes, calib::Segmenter& segmenter,
                             calib::Examination& examination) {
  std::vector<double> samples;
  for (const calib::Sensor sensor : calib::kSensors) {
    if (auto read = read_sensor(file, axes.unit, sensor, samples); !read) return read;
    if (samples.empty()) continue;
    segmenter.describe(sensor, samples);
    examination.add(sensor, samples);
  }
  return {};
}

/// Where a unit without positions rested, if it may have been turned by hand on a bench; else none.
base::Result<std::vector<calib::Standstill>> standstills_of(const db::RunFileReader& file,
                                                            const calib::Recording& axes) {
  if (!calib::may_be_bench_session(axes)) return std::vector<calib::Standstill>();
  calib::StandstillFinder finder(axes.t_s);
  std::vector<double> samples;
  for (const calib::Sensor sensor : calib::kSensors) {
    if (auto read = read_sensor(file, axes.unit, sensor, samples); !read) return base::forward_error(read);
    if (!samples.empty()) finder.add(sensor, samples);
  }
  return finder.find();
}

/// What the file's events tell of lost packets of the unit.
base::Result<std::vector<PacketLoss>> losses_in(const db::RunFileReader& file, std::string_view unit) {
  const auto events = file.events();
  if (!events) return base::forward_error(events);
  std::vector<PacketLoss> losses;
  for (const db::RunEvent& event : *events) {
    if (event.kind != kLostPacketsEvent) continue;
    const auto text = nlohmann::json::parse(event.text, nullptr, false);
    const bool known = text.is_object() && text.contains("unit") && text["unit"] == unit &&
                       text.value("packets", nlohmann::json()).is_number_unsigned() &&
                       text.value("from_s", nlohmann::json()).is_number() &&
                       text.value("to_s", nlohmann::json()).is_number();
    if (!known) continue;
    losses.push_back({std::string(unit), text["from_s"].get<double>(), text["to_s"].get<double>(),
                      text["packets"].get<std::uint64_t>()});
  }
  return losses;
}

/// With findings; without the run's length.
base::Result<RunRecord> record_of(const db::RunFileReader& file, std::string_view unit,
                                  calib::Segmentation segmentation) {
  const auto losses = losses_in(file, unit);
  if (!losses) return base::forward_error(losses);
  mark_losses(*losses, segmentation.segments);
  RunRecord record{row_of(file.info()), std::move(segmentation.segments), std::move(segmentation.warnings)};
  for (const calib::Warning& warning : calib::gate_warnings(record.segments)) {
    record.warnings.push_back(fmt::format("{} {}", warning.code, warning.text));
  }
  record.row.unit = unit;
  return record;
}

/// With the whole run in memory, as imported recordings without plateaus or positions need it.
base::Result<RunRecord> describe_whole_run(const db::RunFileReader& file, std::string_view unit,
                                           const calib::UnitType& type, bool with_visits) {
  const auto axes = read_axes(file, unit);
  if (!axes) return base::forward_error(axes);
  const auto standstills = standstills_of(file, *axes);
  if (!standstills) return base::forward_error(standstills);
  auto segmenter = calib::Segmenter::begin(*axes, *standstills);
  if (!segmenter) return base::forward_error(segmenter);
  calib::Segmentation& segmentation = segmenter->result();
  calib::Examination examination(*axes, segmentation.segments, type);
  if (auto looked = look_at_sensors(file, *axes, *segmenter, examination); !looked) return base::forward_error(looked);
  for (const calib::AuxiliaryChannel& channel : axes->auxiliary) {
    if (!with_visits || channel.name != kVisitChannel) continue;
    number_visits(*axes, channel.values, segmentation.segments);
  }
  store_findings(examination, segmentation.segments);
  auto record = record_of(file, unit, std::move(segmentation));
  if (!record) return record;
  record->row.rows = axes->rows();
  record->row.duration_s = axes->t_s.back() - axes->t_s.front();
  return record;
}

bool has_rows(const db::RunFileReader& file, std::string_view unit) {
  const auto stream = find_stream(file, kImuStream, unit);
  return stream && file.rows(*stream) > 0;
}

/// The records of all units with samples, but for their epochs.
base::Result<std::vector<RunRecord>> describe_all(const SealedRun& run) {
  const auto file = db::RunFileReader::open(run.path);
  if (!file) return base::forward_error(file);
  const auto content = file->content_hash();
  if (!content) return base::forward_error(content);
  std::vector<RunRecord> records;
  for (const RecordedUnit& unit : run.units) {
    if (!has_rows(*file, unit.serial)) continue;
    auto record = describe_recorded_run(*file, unit.serial, unit.facts);
    if (!record) return base::forward_error(record);
    record->row.file_name = run.path.filename().string();
    record->row.file_sha256 = run.sha256;
    record->row.content_sha256 = *content;
    records.push_back(*std::move(record));
  }
  return records;
}

bool touches(const Withdrawal& withdrawal, const calib::Segment& segment) {
  return withdrawal.unit == segment.key.unit && withdrawal.span && segment.t_end_s >= withdrawal.span->first &&
         segment.t_start_s <= withdrawal.span->second;
}

base::Status add_void(db::Catalog& catalog, const calib::SegmentKey& key, const std::string& reason) {
  return catalog.add_void(
      {key.run_id, key.unit, key.visit, key.position, key.attempt, reason, std::string(kUser), now_utc_s()});
}

base::Status withdraw(db::Catalog& catalog, const SealedRun& run, const std::vector<RunRecord>& records,
                      const Withdrawal& withdrawal) {
  bool any = false;
  for (const RunRecord& record : records) {
    for (const calib::Segment& segment : record.segments) {
      if (!touches(withdrawal, segment)) continue;
      if (auto status = add_void(catalog, segment.key, withdrawal.reason); !status) return status;
      any = true;
    }
  }
  if (any) return {};
  return catalog.log_event({now_utc_s(), "nothing_to_void", run.path.stem().string(),
                            fmt::format("unit {}: no segment for: {}", withdrawal.unit, withdrawal.reason)});
}

base::Status enter(db::Catalog& catalog, const SealedRun& run, RunRecord& record) {
  const auto unit = std::find_if(run.units.begin(), run.units.end(),
                                 [&](const RecordedUnit& u) { return u.serial == record.row.unit; });
  const auto known = catalog.ensure_unit(unit->serial, unit->type);
  if (!known) return base::forward_error(known);
  record.row.epoch = unit->epoch.value_or(known->epoch);
  if (record.row.epoch > known->epoch) {
    record.warnings.push_back(fmt::format(
        "recorded in epoch {}, after a repair that this catalog, in epoch {}, does not know: no fit uses it "
        "before the repair is entered again",
        record.row.epoch, known->epoch));
  }
  if (auto status = catalog.ensure_campaign(record.row.campaign, record.row.procedure); !status) return status;
  if (auto status = catalog.add_run(record.row, record.segments); !status) return status;
  for (const std::string& warning : record.warnings) {
    const std::string text = fmt::format("unit {}: {}", record.row.unit, warning);
    if (auto status = catalog.log_event({now_utc_s(), "run_warning", record.row.run_id, text}); !status) return status;
  }
  return {};
}

base::Status void_run(db::Catalog& catalog, const db::RunRow& row, const std::string& reason) {
  db::VoidRecord record;
  record.run_id = row.run_id;
  record.unit = row.unit;
  record.reason = reason;
  record.user = kUser;
  record.utc_s = now_utc_s();
  return catalog.add_void(record);
}

/// Why a unit's part ended before its last visit; nothing where it did not.
std::optional<std::string> why_cut(const SealedRun& run, const std::string& unit) {
  const auto part = run.void_units.find(unit);
  return part == run.void_units.end() ? run.void_reason : part->second;
}

/// Whether a part has a segment that no withdrawal touches.
bool is_of_use(const SealedRun& run, const RunRecord& record) {
  return std::ranges::any_of(record.segments, [&](const calib::Segment& segment) {
    return std::ranges::none_of(run.withdrawals, [&](const Withdrawal& w) { return touches(w, segment); });
  });
}

base::Status enter_all(db::Catalog& catalog, const SealedRun& run, std::vector<RunRecord>& records) {
  for (RunRecord& record : records) {
    const auto why = why_cut(run, record.row.unit);
    const bool kept = why && run.keeps_parts && is_of_use(run, record);
    if (kept) record.row.cut_short = *why;
    if (auto status = enter(catalog, run, record); !status) return status;
    if (!why || kept) continue;
    if (auto status = void_run(catalog, record.row, *why); !status) return status;
  }
  for (const Withdrawal& withdrawal : run.withdrawals) {
    if (auto status = withdraw(catalog, run, records, withdrawal); !status) return status;
  }
  return {};
}

}  // namespace

std::string text_of(const PacketLoss& loss) {
  return nlohmann::json{{"unit", loss.unit}, {"from_s", loss.from_s}, {"to_s", loss.to_s}, {"packets", loss.packets}}
      .dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

void mark_losses(std::span<const PacketLoss> losses, std::vector<calib::Segment>& segments) {
  for (calib::Segment& segment : segments) {
    std::uint64_t packets = 0;
    for (const PacketLoss& loss : losses) {
      // A row before which packets were lost, other than the segment's first.
      if (loss.to_s > segment.t_start_s && loss.from_s <= segment.t_end_s) packets += loss.packets;
    }
    if (packets == 0) continue;
    segment.findings.push_back(
        {"lost_packets", calib::Severity::warn, std::nullopt,
         fmt::format("{} packet{} of the unit did not arrive, by its own counter: check cable, adapter and rate",
                     packets, packets == 1 ? "" : "s")});
  }
}

base::Result<RunRecord> describe_run(const db::RunFileReader& file, std::string_view unit,
                                     const calib::UnitType& type) {
  return describe_whole_run(file, unit, type, false);
}

base::Result<RunRecord> describe_recorded_run(const db::RunFileReader& file, std::string_view unit,
                                              const calib::UnitType& type, bool may_read_in_parts) {
  if (!may_read_in_parts) return describe_whole_run(file, unit, type, true);
  const auto rows = LongRunRows::open(file, unit);
  if (!rows) return base::forward_error(rows);
  if (!*rows) return describe_whole_run(file, unit, type, true);
  auto run = calib::describe_long_run(**rows, type, kVisitChannel);
  if (!run) return base::forward_error(run);
  if (!*run) return describe_whole_run(file, unit, type, true);
  auto record = record_of(file, unit, std::move((*run)->segmentation));
  if (!record) return record;
  record->row.rows = (*rows)->rows();
  record->row.duration_s = (*run)->duration_s;
  return record;
}

base::Result<std::vector<db::RunRow>> enter_run(db::Catalog& catalog, const SealedRun& run) {
  auto records = describe_all(run);
  if (!records) return base::forward_error(records);
  const auto entered = catalog.all_or_nothing([&] { return enter_all(catalog, run, *records); });
  if (!entered) return base::forward_error(entered);
  std::vector<db::RunRow> rows;
  for (RunRecord& record : *records) rows.push_back(std::move(record.row));
  return rows;
}

}  // namespace soak::station
