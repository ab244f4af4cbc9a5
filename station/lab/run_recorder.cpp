// SPDX-License-Identifier: Apache-2.0
#include "station/lab/run_recorder.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <set>
#include <utility>

#include "calib/vocabulary/position.h"
#include "db/catalog/catalog.h"
#include "db/run/run_file.h"
#include "station/import/slow_channel.h"
#include "station/runs/run_streams.h"

namespace soak::station {
namespace {

constexpr std::string_view kChamberStream = "chamber";
// Eight four-byte channels that compress little, and the slower ones beside them.
constexpr double kBytesPerRow = 34.0;
constexpr std::string_view kLostRunReason = "soakd ended in mid-run";
constexpr std::string_view kUnknownUnitType = "generic";

bool is_six_position(std::string_view label) {
  const auto& labels = calib::kSixPositionLabels;
  return std::find(labels.begin(), labels.end(), label) != labels.end();
}

base::Status check_run_purpose(const std::string& purpose) {
  if (db::is_purpose(purpose)) return {};
  return base::bad_input(fmt::format("'{}' is not a purpose of a run", purpose));
}

base::Status check_recorded_units(const std::vector<RecordedUnit>& units) {
  std::set<std::string> serials;
  for (const RecordedUnit& unit : units) {
    if (unit.serial.empty()) return base::bad_input("a unit needs a serial number");
    if (!serials.insert(unit.serial).second) {
      return base::bad_input(fmt::format("unit '{}' is duplicated", unit.serial));
    }
  }
  if (units.empty()) return base::bad_input("a run needs a unit");
  return {};
}

/// What the catalog would refuse only after hours of recording.
base::Status check_run_label(const db::Catalog& catalog, const db::RunInfo& info,
                             const std::vector<RecordedUnit>& units) {
  for (const RecordedUnit& unit : units) {
    const auto runs = catalog.runs({.unit = unit.serial, .campaign = info.campaign, .run = {}});
    if (!runs) return base::forward_error(runs);
    const auto same =
        std::find_if(runs->begin(), runs->end(), [&](const db::RunRow& run) { return run.label == info.label; });
    if (same == runs->end()) continue;
    return base::bad_input(fmt::format("campaign '{}' has a run '{}' of unit '{}' already ({})", info.campaign,
                                       info.label, unit.serial, same->run_id));
  }
  return {};
}

base::Status enter_recorded_units(db::Catalog& catalog, const std::vector<RecordedUnit>& units) {
  return catalog.all_or_nothing([&]() -> base::Status {
    for (const RecordedUnit& unit : units) {
      if (const auto known = catalog.ensure_unit(unit.serial, unit.type); !known) return base::forward_error(known);
    }
    return {};
  });
}

/// Number of units whose samples were entered; 0 where the file holds none.
base::Result<std::size_t> enter_lost_run(db::Catalog& catalog, const db::OrphanRunFile& orphan) {
  auto sha256 = db::RunFileWriter::seal_interrupted(orphan.path, kLostRunReason);
  if (!sha256) return base::forward_error(sha256);
  SealedRun run;
  run.path = orphan.path;
  run.sha256 = *std::move(sha256);
  run.void_reason = kLostRunReason;
  for (const std::string& serial : orphan.units) run.units.push_back({serial, std::string(kUnknownUnitType)});
  const auto rows = enter_run(catalog, run);
  if (!rows) return base::forward_error(rows);
  return rows->size();
}

std::string lost_run_text(const base::Result<std::size_t>& entered) {
  if (!entered) return "stays as it is: " + entered.error().message;
  return *entered > 0 ? "is sealed, entered and voided" : "is sealed; it holds no samples";
}

}  // namespace

base::Result<RunRecorder> RunRecorder::begin(db::Catalog& catalog, const db::RunInfo& info, std::string purpose,
                                             std::vector<RecordedUnit> units, bool with_rates) {
  if (const auto valid = check_recorded_units(units); !valid) return base::forward_error(valid);
  if (const auto valid = check_run_purpose(purpose); !valid) return base::forward_error(valid);
  if (const auto valid = check_run_label(catalog, info, units); !valid) return base::forward_error(valid);
  if (const auto entered = enter_recorded_units(catalog, units); !entered) return base::forward_error(entered);
  db::RunInfo stated = info;
  stated.purpose = std::move(purpose);
  stated.simulated = info.simulated || info.clock_rate != 1.0;
  const auto path = catalog.data_folder() / "runs" / (info.run_id + ".soakrun");
  auto file = db::RunFileWriter::create(path, stated);
  if (!file) return base::forward_error(file);
  RunRecorder recorder(catalog, *std::move(file), std::move(stated), with_rates);
  if (const auto added = recorder.add_streams(units); !added) return base::forward_error(added);
  recorder.sealed_.path = path;
  recorder.sealed_.units = std::move(units);
  return recorder;
}

base::Status RunRecorder::add_streams(const std::vector<RecordedUnit>& units) {
  for (const RecordedUnit& unit : units) {
    const auto stream =
        file_.add_stream({std::string(kImuStream), unit.serial, imu_channels(unit.supply_is_measured, with_rates_)});
    if (!stream) return base::forward_error(stream);
    UnitStream& rows = units_.emplace_back(UnitStream{unit, *stream});
    rows.fresh.with_supply = unit.supply_is_measured;
    if (unit.positions.empty()) continue;
    const auto positions = add_position_stream(file_, unit.serial, unit.positions);
    if (!positions) return base::forward_error(positions);
    rows.position_stream = *positions;
  }
  const auto stream = file_.add_stream({std::string(kChamberStream), "", chamber_channels()});
  if (!stream) return base::forward_error(stream);
  chamber_stream_ = *stream;
  return file_.flush();
}

// --- rows -------------------------------------------------------------------------------------------------------

std::optional<int> RunRecorder::UnitStream::visit_of(const RowLabels& labels) {
  if (labels.visit >= 0) return labels.visit;
  if (labels.phase != calib::Phase::soak || !labels.plateau_c) return std::nullopt;
  if (labels.plateau_c != last_plateau_c) ++counted_visit;
  last_plateau_c = labels.plateau_c;
  return counted_visit;
}

void RunRecorder::UnitStream::follow_attempt(const RowLabels& labels, std::optional<int> visit, double from_s,
                                             double to_s) {
  const bool records = labels.phase == calib::Phase::soak && !labels.position.empty();
  const std::string place = labels.rate_dps == 0.0 ? labels.position : label_at_rate(labels.position, labels.rate_dps);
  const bool continues = records && recording && attempt->position == place && attempt->visit == visit;
  recording = records;
  if (continues) attempt->to_s = to_s;
  if (records && !continues) attempt = {visit, place, from_s, to_s};
}

base::Status RunRecorder::UnitStream::check(std::span<const hal::ImuSample> samples, const RowLabels& labels) const {
  if (!labels.position.empty() && !is_six_position(labels.position)) {
    return base::bad_input(fmt::format("'{}' is not one of the six positions", labels.position), unit.serial);
  }
  if (labels.visit > std::numeric_limits<std::int16_t>::max()) {
    return base::bad_input(fmt::format("{} is not a visit number", labels.visit), unit.serial);
  }
  double before_s = last_t_s;
  for (const hal::ImuSample& sample : samples) {
    if (!(sample.t_s > before_s) || !std::isfinite(sample.t_s)) {
      return base::bad_input(
          fmt::format("the device time must increase: it goes from {} s to {} s", before_s, sample.t_s), unit.serial);
    }
    before_s = sample.t_s;
  }
  return {};
}

base::Status RunRecorder::add(std::size_t unit, std::span<const hal::ImuSample> samples, const RowLabels& labels) {
  if (unit >= units_.size()) return base::bad_input(fmt::format("the run has no unit number {}", unit));
  UnitStream& rows = units_[unit];
  if (auto valid = rows.check(samples, labels); !valid) return valid;
  if (samples.empty()) return {};
  const std::optional<int> visit = rows.visit_of(labels);
  auto added = file_.append(rows.stream, imu_columns(samples, labels, visit, rows.fresh, with_rates_));
  // Every other error leaves the rows in the writer's memory.
  if (!added && added.error().kind == base::ErrorKind::bad_input) return added;
  if (const auto noted = note_position(rows, labels.position, samples.front().t_s); added && !noted) added = noted;
  rows.follow_attempt(labels, visit, samples.front().t_s, samples.back().t_s);
  rows.rows += samples.size();
  rows.last_t_s = samples.back().t_s;
  rows.fresh = SlowReadings{};
  rows.fresh.with_supply = rows.unit.supply_is_measured;
  return added;
}

/// Notes a position of known azimuth where it occurs for the first time.
base::Status RunRecorder::note_position(UnitStream& unit, const std::string& label, double t_s) {
  if (!unit.position_stream || label.empty() || !unit.placed.insert(label).second) return {};
  const auto& positions = unit.unit.positions;
  const auto found = std::ranges::find(positions, label, &calib::Position::label);
  if (found == positions.end()) return {};
  return append_position(file_, *unit.position_stream, positions, static_cast<std::size_t>(found - positions.begin()),
                         t_s);
}

base::Status RunRecorder::add_chamber(double t_s, const hal::ChamberReading& reading) {
  if (!std::isfinite(t_s)) return base::bad_input("the time of a chamber reading must be finite");
  const double time_s = std::max(t_s, last_chamber_t_s_);
  auto added = file_.append(chamber_stream_, chamber_columns(time_s, reading));
  if (!added && added.error().kind == base::ErrorKind::bad_input) return added;
  last_chamber_t_s_ = time_s;
  for (UnitStream& unit : units_) unit.fresh.chamber_c = reading.air_c;
  return added;
}

void RunRecorder::add_supply(std::size_t unit, const hal::OutputReading& reading) {
  SlowReadings& fresh = units_.at(unit).fresh;
  fresh.supply_v = reading.voltage_v;
  fresh.supply_a = reading.current_a;
}

base::Status RunRecorder::add_event(double t_s, std::string_view kind, std::string_view text) {
  return file_.add_event(t_s, kind, text);
}

base::Status RunRecorder::flush() { return file_.flush(); }

void RunRecorder::reject(std::size_t unit, std::string reason) {
  const UnitStream& rows = units_.at(unit);
  Withdrawal withdrawal{rows.unit.serial, {}, std::move(reason)};
  if (rows.attempt) withdrawal.span = {rows.attempt->from_s, rows.attempt->to_s};
  sealed_.withdrawals.push_back(std::move(withdrawal));
}

// --- the end ----------------------------------------------------------------------------------------------------

base::Status RunRecorder::seal() {
  if (!sealed_.sha256.empty()) return {};
  double last_t_s = std::max(last_chamber_t_s_, 0.0);
  for (const UnitStream& unit : units_) last_t_s = std::max(last_t_s, unit.last_t_s);
  for (const UnitStream& unit : units_) {
    if (unit.rows > 0 || noted_silence_) continue;
    auto noted = file_.add_event(last_t_s, "no_samples", fmt::format("unit {} sent no sample", unit.unit.serial));
    if (!noted) return noted;
  }
  noted_silence_ = true;
  auto sha256 = file_.seal();
  if (!sha256) return base::forward_error(sha256);
  sealed_.sha256 = *std::move(sha256);
  return {};
}

base::Result<std::vector<db::RunRow>> RunRecorder::finish(const std::optional<std::string>& void_reason,
                                                          const std::map<std::string, std::string>& void_units) {
  if (const auto sealed = seal(); !sealed) return base::forward_error(sealed);
  sealed_.void_reason = void_reason;
  sealed_.void_units = void_units;
  return enter_run(*catalog_, sealed_);
}

base::Status enter_lost_runs(db::Catalog& catalog, EventLog& log) {
  const auto orphans = db::orphan_run_files(catalog);
  if (!orphans) return base::forward_error(orphans);
  for (const db::OrphanRunFile& orphan : *orphans) {
    // Files of other writers (an import that is at work) are theirs.
    if (!orphan.info || orphan.info->source != kRunSource) continue;
    const auto entered = enter_lost_run(catalog, orphan);
    // An empty file that was sealed before has been told of then.
    if (entered && *entered == 0 && orphan.sealed) continue;
    log.add("run", orphan.info->label,
            fmt::format("{} was left behind and {}", orphan.path.filename().string(), lost_run_text(entered)));
  }
  return {};
}

double estimated_bytes(double rate_hz, std::size_t units, double seconds) {
  return kBytesPerRow * rate_hz * static_cast<double>(units) * seconds;
}

}  // namespace soak::station
