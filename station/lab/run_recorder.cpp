// SPDX-License-Identifier: Apache-2.0
#include "station/lab/run_recorder.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "calib/vocabulary/position.h"
#include "db/catalog/catalog.h"
#include "db/run/run_file.h"
#include "station/import/slow_channel.h"
#include "station/lab/start_check.h"
#include "station/runs/run_streams.h"

namespace soak::station {
namespace {

constexpr std::string_view kChamberStream = "chamber";
// Eight four-byte channels that compress little, and the slower ones beside them.
constexpr double kBytesPerRow = 34.0;
constexpr std::string_view kLostRunReason = "soakd ended in mid-run";
/// Events by which a run file tells of its attempts; their text is JSON.
constexpr std::string_view kRejected = "rejected";
constexpr std::string_view kAccepted = "recorded";
/// The event by which a sealed file tells how its run ended (docs/file-formats.md).
constexpr std::string_view kEnded = "ended";
/// The event by which a file tells in which epoch of each unit its run began (docs/file-formats.md).
constexpr std::string_view kEpochs = "epochs";
constexpr std::string_view kUnknownUnitType = "generic";
constexpr double kLossEvent_s = 60.0;  ///< device time that one event of lost packets tells of, at most

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

/// Units that are known already do not wait for the catalog's lock.
base::Status enter_recorded_units(db::Catalog& catalog, const std::vector<RecordedUnit>& units) {
  const bool all_known = std::ranges::all_of(units, [&](const RecordedUnit& unit) {
    const auto known = catalog.unit(unit.serial);
    return known && *known;
  });
  if (all_known) return {};
  return catalog.all_or_nothing([&]() -> base::Status {
    for (const RecordedUnit& unit : units) {
      if (const auto known = catalog.ensure_unit(unit.serial, unit.type); !known) return base::forward_error(known);
    }
    return {};
  });
}

/// Notes of each unit the epoch in which the run begins: it may be repaired before the run is entered.
base::Status take_epochs(const db::Catalog& catalog, std::vector<RecordedUnit>& units) {
  for (RecordedUnit& unit : units) {
    const auto known = catalog.unit(unit.serial);
    if (!known) return base::forward_error(known);
    if (*known) unit.epoch = (*known)->epoch;
  }
  return {};
}

std::string epochs_text(const std::vector<RecordedUnit>& units) {
  nlohmann::json epochs = nlohmann::json::object();
  for (const RecordedUnit& unit : units) epochs[unit.serial] = unit.epoch.value_or(0);
  return epochs.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

/// What a run file says of the epoch in which the run of a unit began; nothing of those of versions that did not write
/// it.
std::optional<std::int32_t> told_epoch(const std::vector<db::RunEvent>& events, const std::string& serial) {
  const auto found = std::ranges::find(events, kEpochs, &db::RunEvent::kind);
  if (found == events.end()) return std::nullopt;
  const auto epochs = nlohmann::json::parse(found->text, nullptr, false);
  if (!epochs.is_object() || !epochs.contains(serial)) return std::nullopt;
  const nlohmann::json& epoch = epochs[serial];
  const bool is_sound = epoch.is_number_unsigned() && epoch.get<std::uint64_t>() <= std::numeric_limits<int>::max();
  return is_sound ? std::optional(epoch.get<std::int32_t>()) : std::nullopt;
}

std::string attempt_text(const std::string& unit, const std::optional<std::pair<double, double>>& span,
                         const std::string& reason) {
  nlohmann::json text = {{"unit", unit}, {"reason", reason}};
  if (span) text["from_s"] = span->first;
  if (span) text["to_s"] = span->second;
  return text.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

std::string ended_text(const RunEnd& end, const std::vector<RecordedUnit>& units) {
  nlohmann::json types = nlohmann::json::object();
  for (const RecordedUnit& unit : units) types[unit.serial] = unit.type;
  const nlohmann::json text = {{"cut_short", end.void_reason ? nlohmann::json(*end.void_reason) : nlohmann::json()},
                               {"units_cut_short", end.void_units},
                               {"keeps_parts", end.keeps_parts},
                               {"types", std::move(types)}};
  return text.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

/// What a run file tells of its run's end.
struct ToldEnd {
  RunEnd end;
  std::map<std::string, std::string> types;  ///< of its units, by serial number
};

/// Nothing of a file that was never sealed by who recorded it, and of those of versions that did not write it.
std::optional<ToldEnd> told_end(const std::vector<db::RunEvent>& events) {
  const auto found = std::ranges::find(events, kEnded, &db::RunEvent::kind);
  if (found == events.end()) return std::nullopt;
  try {
    const auto text = nlohmann::json::parse(found->text);
    ToldEnd told;
    if (const auto& reason = text.at("cut_short"); !reason.is_null()) told.end.void_reason = reason;
    text.at("units_cut_short").get_to(told.end.void_units);
    text.at("keeps_parts").get_to(told.end.keeps_parts);
    text.at("types").get_to(told.types);
    return told;
  } catch (const nlohmann::json::exception&) {
    return std::nullopt;
  }
}

/// Device time of a unit's last row; nothing where it has none.
base::Result<std::optional<double>> last_time_s(const db::RunFileReader& file, const std::string& unit) {
  const auto stream = find_stream(file, kImuStream, unit);
  if (!stream || file.rows(*stream) == 0) return std::nullopt;
  const auto last = file.read(*stream, 0, file.rows(*stream) - 1, 1);
  if (!last) return base::forward_error(last);
  const db::ChannelInfo& channel = file.streams()[*stream].channels.front();
  return db::values_of(*last, channel.scale, channel.offset).front();
}

/// The attempts that a run file itself calls rejected.
std::vector<Withdrawal> rejected_in(const std::vector<db::RunEvent>& events) {
  std::vector<Withdrawal> withdrawals;
  for (const db::RunEvent& event : events) {
    if (event.kind != kRejected) continue;
    const auto text = nlohmann::json::parse(event.text, nullptr, false);
    if (!text.is_object() || !text.contains("to_s")) continue;
    withdrawals.push_back(
        {text.value("unit", ""), {{text.value("from_s", 0.0), text.value("to_s", 0.0)}}, text.value("reason", "")});
  }
  return withdrawals;
}

/// Of each unit the last attempt, where it ends with the file and was never accepted.
base::Result<std::vector<Withdrawal>> under_way_in(const db::RunFileReader& file,
                                                   const std::vector<db::RunEvent>& events,
                                                   const std::vector<std::string>& units) {
  std::map<std::string, double> accepted_to_s;
  for (const db::RunEvent& event : events) {
    if (event.kind != kAccepted) continue;
    const auto text = nlohmann::json::parse(event.text, nullptr, false);
    if (text.is_object()) accepted_to_s[text.value("unit", "")] = text.value("to_s", 0.0);
  }
  std::vector<Withdrawal> withdrawals;
  for (const std::string& unit : units) {
    const auto last_s = last_time_s(file, unit);
    if (!last_s) return base::forward_error(last_s);
    if (!*last_s) continue;
    const auto accepted = accepted_to_s.find(unit);
    if (accepted != accepted_to_s.end() && accepted->second >= **last_s) continue;
    withdrawals.push_back({unit, {{**last_s, **last_s}}, std::string(kLostRunReason)});
  }
  return withdrawals;
}

/// Whether the run's own campaign keeps what was recorded before a break.
bool keeps_lost_part(const db::Catalog& catalog, const db::RunInfo& info, const std::string& aborted_campaign) {
  if (info.purpose == "diagnosis" || (!info.campaign.empty() && info.campaign == aborted_campaign)) return false;
  const auto row = catalog.campaign(info.campaign);
  if (!row || !*row) return true;
  if ((*row)->state == "aborted") return false;
  const auto request = request_of(**row);
  if (!request) return true;
  const auto procedure = parse_procedure(request->procedure_text, request->procedure_file);
  return !procedure || procedure->on_break == BreakOutcome::resume;
}

/// What becomes of a run whose file is sealed, by what that says. Its units' types are read from there, too: a catalog
/// that was restored may not know them.
base::Status judge_lost_run(const db::Catalog& catalog, const db::OrphanRunFile& orphan,
                            const std::string& aborted_campaign, SealedRun& run) {
  const auto file = db::RunFileReader::open(orphan.path);
  if (!file) return base::forward_error(file);
  const auto events = file->events();
  if (!events) return base::forward_error(events);
  run.withdrawals = rejected_in(*events);
  const auto told = told_end(*events);
  for (const std::string& serial : orphan.units) {
    const bool known = told && told->types.contains(serial);
    RecordedUnit& unit = run.units.emplace_back();
    unit.serial = serial;
    unit.type = known ? told->types.at(serial) : std::string(kUnknownUnitType);
    unit.epoch = told_epoch(*events, serial);
  }
  if (told) {
    run.void_reason = told->end.void_reason;
    run.void_units = told->end.void_units;
    run.keeps_parts = told->end.keeps_parts;
    return {};
  }
  const auto under_way = under_way_in(*file, *events, orphan.units);
  if (!under_way) return base::forward_error(under_way);
  run.withdrawals.insert(run.withdrawals.end(), under_way->begin(), under_way->end());
  run.void_reason = kLostRunReason;
  run.keeps_parts = keeps_lost_part(catalog, *orphan.info, aborted_campaign);
  return {};
}

/// Number of units whose samples were entered; 0 where the file holds none.
base::Result<std::size_t> enter_lost_run(db::Catalog& catalog, const db::OrphanRunFile& orphan,
                                         const std::string& aborted_campaign) {
  auto sha256 = db::RunFileWriter::seal_interrupted(orphan.path, kLostRunReason);
  if (!sha256) return base::forward_error(sha256);
  SealedRun run;
  run.path = orphan.path;
  run.sha256 = *std::move(sha256);
  if (auto judged = judge_lost_run(catalog, orphan, aborted_campaign, run); !judged) return base::forward_error(judged);
  const auto rows = enter_run(catalog, run);
  if (!rows) return base::forward_error(rows);
  return rows->size();
}

std::string lost_run_text(const base::Result<std::size_t>& entered) {
  if (!entered) return "stays as it is: " + entered.error().message;
  return *entered > 0 ? "is sealed and entered: what was complete is kept" : "is sealed; it holds no samples";
}

}  // namespace

base::Result<RunRecorder> RunRecorder::begin(db::Catalog& catalog, const db::RunInfo& info, std::string purpose,
                                             std::vector<RecordedUnit> units, bool with_rates) {
  if (const auto valid = check_recorded_units(units); !valid) return base::forward_error(valid);
  if (const auto valid = check_run_purpose(purpose); !valid) return base::forward_error(valid);
  if (const auto valid = check_run_label(catalog, info, units); !valid) return base::forward_error(valid);
  if (const auto entered = enter_recorded_units(catalog, units); !entered) return base::forward_error(entered);
  if (const auto taken = take_epochs(catalog, units); !taken) return base::forward_error(taken);
  db::RunInfo stated = info;
  stated.purpose = std::move(purpose);
  stated.simulated = info.simulated || info.clock_rate != 1.0;
  const auto path = catalog.data_folder() / "runs" / (info.run_id + ".soakrun");
  auto file = db::RunFileWriter::create(path, stated);
  if (!file) return base::forward_error(file);
  RunRecorder recorder(catalog, *std::move(file), std::move(stated), with_rates);
  if (const auto noted = recorder.file_.add_event(0.0, kEpochs, epochs_text(units)); !noted) {
    return base::forward_error(noted);
  }
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
  const std::string place_before = rows.recording ? rows.attempt->position : "";
  auto added = file_.append(rows.stream, imu_columns(samples, labels, visit, rows.fresh, with_rates_));
  // Every other error leaves the rows in the writer's memory.
  if (!added && added.error().kind == base::ErrorKind::bad_input) return added;
  if (const auto noted = note_position(rows, labels.position, samples.front().t_s); added && !noted) added = noted;
  rows.follow_attempt(labels, visit, samples.front().t_s, samples.back().t_s);
  const bool same_stretch = place_before == (rows.recording ? rows.attempt->position : "");
  if (const auto noted = note_losses(rows, samples, same_stretch); added && !noted) added = noted;
  rows.rows += samples.size();
  rows.last_t_s = samples.back().t_s;
  rows.fresh = SlowReadings{};
  rows.fresh.with_supply = rows.unit.supply_is_measured;
  return added;
}

/// One event a minute at most, and one for each stretch that a segment is made of: a bad link loses packets all the
/// time.
base::Status RunRecorder::note_losses(UnitStream& unit, std::span<const hal::ImuSample> samples, bool same_stretch) {
  base::Status written = same_stretch ? base::Status() : write_loss(unit);
  for (const hal::ImuSample& sample : samples) {
    // What was lost before the first row was not this run's.
    if (sample.lost == 0 || (unit.rows == 0 && &sample == &samples.front())) continue;
    PacketLoss& loss = unit.loss;
    if (loss.packets > 0 && sample.t_s - loss.from_s > kLossEvent_s) {
      if (const auto status = write_loss(unit); !status) written = status;
    }
    if (loss.packets == 0) loss = {unit.unit.serial, sample.t_s, sample.t_s, 0};
    loss.packets += sample.lost;
    loss.to_s = sample.t_s;
  }
  return written;
}

base::Status RunRecorder::write_loss(UnitStream& unit) {
  const PacketLoss loss = std::exchange(unit.loss, {});
  if (loss.packets == 0) return {};
  return file_.add_event(std::max(loss.to_s, unit.last_t_s), kLostPacketsEvent, text_of(loss));
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
  withdraw(rows, rows.attempt, std::move(reason));
}

void RunRecorder::withdraw(const UnitStream& rows, const std::optional<Attempt>& attempt, std::string reason) {
  Withdrawal withdrawal{rows.unit.serial, {}, std::move(reason)};
  if (attempt) withdrawal.span = {attempt->from_s, attempt->to_s};
  // What cannot be written now stays in the writer's memory.
  (void)file_.add_event(rows.last_t_s, kRejected, attempt_text(withdrawal.unit, withdrawal.span, withdrawal.reason));
  sealed_.withdrawals.push_back(std::move(withdrawal));
}

void RunRecorder::accept(std::size_t unit) {
  const UnitStream& rows = units_.at(unit);
  if (!rows.attempt) return;
  (void)file_.add_event(rows.last_t_s, kAccepted,
                        attempt_text(rows.unit.serial, {{rows.attempt->from_s, rows.attempt->to_s}}, ""));
  accepted_.push_back({unit, *rows.attempt});
}

std::size_t RunRecorder::withdraw_visit(std::size_t unit, int visit, const std::string& reason) {
  const auto counts_no_more = [&](const Accepted& accepted) {
    return accepted.unit == unit && accepted.attempt.visit == visit;
  };
  for (const Accepted& accepted : accepted_) {
    if (counts_no_more(accepted)) withdraw(units_.at(unit), accepted.attempt, reason);
  }
  return std::erase_if(accepted_, counts_no_more);
}

// --- the end ----------------------------------------------------------------------------------------------------

base::Status RunRecorder::seal(const RunEnd& end) {
  if (!sealed_.sha256.empty()) return {};
  double last_t_s = std::max(last_chamber_t_s_, 0.0);
  for (UnitStream& unit : units_) {
    last_t_s = std::max(last_t_s, unit.last_t_s);
    if (auto written = write_loss(unit); !written) return written;
  }
  if (!noted_end_) {
    if (auto noted = note_end(last_t_s, end); !noted) return noted;
  }
  noted_end_ = true;
  auto sha256 = file_.seal();
  if (!sha256) return base::forward_error(sha256);
  sealed_.sha256 = *std::move(sha256);
  return {};
}

/// What the catalog is told of the run's end stands in the file as well: the catalog may be lost, or restored to a
/// state from before the run.
base::Status RunRecorder::note_end(double t_s, const RunEnd& end) {
  for (const UnitStream& unit : units_) {
    if (unit.rows > 0) continue;
    auto noted = file_.add_event(t_s, "no_samples", fmt::format("unit {} sent no sample", unit.unit.serial));
    if (!noted) return noted;
  }
  return file_.add_event(t_s, kEnded, ended_text(end, sealed_.units));
}

base::Result<std::vector<db::RunRow>> RunRecorder::finish(db::Catalog& catalog, const RunEnd& end) {
  if (const auto sealed = seal(end); !sealed) return base::forward_error(sealed);
  sealed_.void_reason = end.void_reason;
  sealed_.void_units = end.void_units;
  sealed_.keeps_parts = end.keeps_parts;
  return enter_run(catalog, sealed_);
}

base::Result<std::vector<LostRun>> enter_lost_runs(db::Catalog& catalog, const std::string& aborted_campaign) {
  std::vector<LostRun> lost;
  const auto orphans = db::orphan_run_files(catalog);
  if (!orphans) return base::forward_error(orphans);
  for (const db::OrphanRunFile& orphan : *orphans) {
    // Files of other writers (an import that is at work) are theirs.
    if (!orphan.info || orphan.info->source != kRunSource) continue;
    const auto entered = enter_lost_run(catalog, orphan, aborted_campaign);
    // An empty file that was sealed before has been told of then.
    if (entered && *entered == 0 && orphan.sealed) continue;
    lost.push_back({orphan.info->label,
                    fmt::format("{} was left behind and {}", orphan.path.filename().string(), lost_run_text(entered))});
  }
  return lost;
}

base::Status enter_lost_runs(db::Catalog& catalog, EventLog& log) {
  const auto lost = enter_lost_runs(catalog, "");
  if (!lost) return base::forward_error(lost);
  for (const LostRun& run : *lost) log.add("run", run.label, run.text);
  return {};
}

double estimated_bytes(double rate_hz, std::size_t units, double seconds) {
  return kBytesPerRow * rate_hz * static_cast<double>(units) * seconds;
}

}  // namespace soak::station
