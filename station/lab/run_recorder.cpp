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
#include "station/import/slow_channel.h"
#include "station/runs/run_streams.h"

namespace soak::station {
namespace {

constexpr std::string_view kChamberStream = "chamber";
constexpr double kNever_s = -std::numeric_limits<double>::infinity();

/// One recording of a position: what a segment will be made of.
struct Attempt {
  int visit = 0;
  std::string position;
  int number = 0;
  double from_s = 0.0;
  double to_s = 0.0;
};

/// What is known of one unit's rows so far.
struct UnitState {
  RecordedUnit unit;
  std::size_t stream = 0;
  std::optional<std::size_t> position_stream;  ///< where azimuths are known
  std::set<std::string> placed;                ///< labels of the rows in it
  std::uint64_t rows = 0;
  double last_t_s = kNever_s;
  SlowReadings fresh;      ///< for the next row
  int counted_visit = -1;  ///< where the labels do not number the visits
  std::optional<double> last_plateau_c;
  bool recording = false;  ///< the last row belongs to the last attempt
  std::vector<Attempt> attempts;

  /// Visit of the rows with these labels; nothing outside plateaus.
  std::optional<int> visit_of(const RowLabels& labels);
  void follow_attempts(const RowLabels& labels, std::optional<int> visit, double from_s, double to_s);
};

std::optional<int> UnitState::visit_of(const RowLabels& labels) {
  if (labels.visit >= 0) return labels.visit;
  if (labels.phase != calib::Phase::soak || !labels.plateau_c) return std::nullopt;
  if (labels.plateau_c != last_plateau_c) ++counted_visit;
  last_plateau_c = labels.plateau_c;
  return counted_visit;
}

void UnitState::follow_attempts(const RowLabels& labels, std::optional<int> visit, double from_s, double to_s) {
  const bool records = labels.phase == calib::Phase::soak && !labels.position.empty();
  const int number = visit.value_or(-1);
  const std::string place = labels.rate_dps == 0.0 ? labels.position : label_at_rate(labels.position, labels.rate_dps);
  const bool continues = records && recording && attempts.back().position == place && attempts.back().visit == number;
  recording = records;
  if (continues) attempts.back().to_s = to_s;
  if (!records || continues) return;
  const auto before = std::count_if(attempts.begin(), attempts.end(),
                                    [&](const Attempt& a) { return a.visit == number && a.position == place; });
  attempts.push_back({number, place, static_cast<int>(before), from_s, to_s});
}

bool is_position(std::string_view label) {
  const auto& labels = calib::kSixPositionLabels;
  return std::find(labels.begin(), labels.end(), label) != labels.end();
}

base::Status check_purpose(const std::string& purpose) {
  if (db::is_purpose(purpose)) return {};
  return base::bad_input(fmt::format("'{}' is no purpose of a run", purpose));
}

base::Status check_units(const std::vector<RecordedUnit>& units) {
  std::set<std::string> serials;
  for (const RecordedUnit& unit : units) {
    if (unit.serial.empty()) return base::bad_input("a unit needs a serial number");
    if (!serials.insert(unit.serial).second) {
      return base::bad_input(fmt::format("unit '{}' stands twice in one run", unit.serial));
    }
  }
  if (units.empty()) return base::bad_input("a run needs a unit");
  return {};
}

/// What the catalog would refuse only after hours of recording.
base::Status check_label(const db::Catalog& catalog, const db::RunInfo& info, const std::vector<RecordedUnit>& units) {
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

base::Status enter_units(db::Catalog& catalog, const std::vector<RecordedUnit>& units) {
  return catalog.all_or_nothing([&]() -> base::Status {
    for (const RecordedUnit& unit : units) {
      if (const auto known = catalog.ensure_unit(unit.serial, unit.type); !known) return base::forward_error(known);
    }
    return {};
  });
}

}  // namespace

struct RunRecorder::Impl {
  Impl(db::Catalog& where, db::RunFileWriter opened) : catalog(where), file(std::move(opened)) {}

  [[nodiscard]] base::Status add_streams(const std::vector<RecordedUnit>& added);
  [[nodiscard]] base::Status check_rows(const UnitState& unit, std::span<const hal::ImuSample> samples,
                                        const RowLabels& labels) const;
  [[nodiscard]] base::Status place(UnitState& unit, const std::string& label, double t_s);
  [[nodiscard]] base::Status seal();
  [[nodiscard]] const Attempt* attempt_of(const Rejected& rejected) const;
  [[nodiscard]] double last_t_s() const;

  db::Catalog& catalog;
  db::RunFileWriter file;
  db::RunInfo info;
  SealedRun sealed;  ///< `sha256` is empty while the file is open
  bool with_rates = false;
  bool noted_silence = false;  ///< the events of units without rows are in the file
  std::vector<UnitState> units;
  std::size_t chamber_stream = 0;
  double last_chamber_t_s = kNever_s;
};

RunRecorder::RunRecorder(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
RunRecorder::RunRecorder(RunRecorder&&) noexcept = default;
RunRecorder& RunRecorder::operator=(RunRecorder&&) noexcept = default;
RunRecorder::~RunRecorder() = default;

base::Status RunRecorder::Impl::add_streams(const std::vector<RecordedUnit>& added) {
  for (const RecordedUnit& unit : added) {
    const auto stream =
        file.add_stream({std::string(kImuStream), unit.serial, imu_channels(unit.supply_is_measured, with_rates)});
    if (!stream) return base::forward_error(stream);
    UnitState state;
    state.unit = unit;
    state.fresh.with_supply = unit.supply_is_measured;
    state.stream = *stream;
    if (!unit.positions.empty()) {
      const auto positions = add_position_stream(file, unit.serial, unit.positions);
      if (!positions) return base::forward_error(positions);
      state.position_stream = *positions;
    }
    units.push_back(std::move(state));
  }
  const auto stream = file.add_stream({std::string(kChamberStream), "", chamber_channels()});
  if (!stream) return base::forward_error(stream);
  chamber_stream = *stream;
  return file.flush();
}

base::Result<RunRecorder> RunRecorder::begin(db::Catalog& catalog, const db::RunInfo& info, std::string purpose,
                                             std::vector<RecordedUnit> units, bool with_rates) {
  if (const auto valid = check_units(units); !valid) return base::forward_error(valid);
  if (const auto valid = check_purpose(purpose); !valid) return base::forward_error(valid);
  if (const auto valid = check_label(catalog, info, units); !valid) return base::forward_error(valid);
  if (const auto entered = enter_units(catalog, units); !entered) return base::forward_error(entered);
  db::RunInfo stated = info;
  stated.purpose = std::move(purpose);
  stated.simulated = info.simulated || info.clock_rate != 1.0;
  const auto path = catalog.data_folder() / "runs" / (info.run_id + ".soakrun");
  auto file = db::RunFileWriter::create(path, stated);
  if (!file) return base::forward_error(file);
  auto impl = std::make_unique<Impl>(catalog, *std::move(file));
  impl->info = std::move(stated);
  impl->with_rates = with_rates;
  if (const auto added = impl->add_streams(units); !added) return base::forward_error(added);
  impl->sealed.path = path;
  impl->sealed.units = std::move(units);
  return RunRecorder(std::move(impl));
}

base::Status RunRecorder::Impl::check_rows(const UnitState& unit, std::span<const hal::ImuSample> samples,
                                           const RowLabels& labels) const {
  if (!labels.position.empty() && !is_position(labels.position)) {
    return base::bad_input(fmt::format("'{}' is none of the six positions", labels.position), unit.unit.serial);
  }
  if (labels.visit > std::numeric_limits<std::int16_t>::max()) {
    return base::bad_input(fmt::format("{} is no number of a visit", labels.visit), unit.unit.serial);
  }
  double last_t_s = unit.last_t_s;
  for (const hal::ImuSample& sample : samples) {
    if (!(sample.t_s > last_t_s) || !std::isfinite(sample.t_s)) {
      return base::bad_input(fmt::format("the device time does not rise from {} s to {} s", last_t_s, sample.t_s),
                             unit.unit.serial);
    }
    last_t_s = sample.t_s;
  }
  return {};
}

/// Notes a position of known azimuth where it occurs for the first time.
base::Status RunRecorder::Impl::place(UnitState& unit, const std::string& label, double t_s) {
  if (!unit.position_stream || label.empty() || !unit.placed.insert(label).second) return {};
  const auto& positions = unit.unit.positions;
  const auto found = std::ranges::find(positions, label, &calib::Position::label);
  if (found == positions.end()) return {};
  return append_position(file, *unit.position_stream, positions, static_cast<std::size_t>(found - positions.begin()),
                         t_s);
}

base::Status RunRecorder::add(std::size_t unit, std::span<const hal::ImuSample> samples, const RowLabels& labels) {
  if (unit >= impl_->units.size()) return base::bad_input(fmt::format("the run has no unit number {}", unit));
  UnitState& state = impl_->units[unit];
  if (auto valid = impl_->check_rows(state, samples, labels); !valid) return valid;
  if (samples.empty()) return {};
  const std::optional<int> visit = state.visit_of(labels);
  auto added = impl_->file.append(state.stream, imu_columns(samples, labels, visit, state.fresh, impl_->with_rates));
  // Every other error leaves the rows in the writer's memory.
  if (!added && added.error().kind == base::ErrorKind::bad_input) return added;
  if (const auto noted = impl_->place(state, labels.position, samples.front().t_s); added && !noted) added = noted;
  state.follow_attempts(labels, visit, samples.front().t_s, samples.back().t_s);
  state.rows += samples.size();
  state.last_t_s = samples.back().t_s;
  state.fresh = SlowReadings{};
  state.fresh.with_supply = state.unit.supply_is_measured;
  return added;
}

base::Status RunRecorder::add_chamber(double t_s, const hal::ChamberReading& reading) {
  if (!std::isfinite(t_s)) return base::bad_input("the time of a chamber reading must be finite");
  const double time_s = std::max(t_s, impl_->last_chamber_t_s);
  auto added = impl_->file.append(impl_->chamber_stream, chamber_columns(time_s, reading));
  if (!added && added.error().kind == base::ErrorKind::bad_input) return added;
  impl_->last_chamber_t_s = time_s;
  for (UnitState& unit : impl_->units) unit.fresh.chamber_c = reading.air_c;
  return added;
}

void RunRecorder::add_supply(std::size_t unit, const hal::OutputReading& reading) {
  SlowReadings& fresh = impl_->units.at(unit).fresh;
  fresh.supply_v = reading.voltage_v;
  fresh.supply_a = reading.current_a;
}

base::Status RunRecorder::add_event(double t_s, std::string_view kind, std::string_view text) {
  return impl_->file.add_event(t_s, kind, text);
}

base::Status RunRecorder::flush() { return impl_->file.flush(); }

double RunRecorder::Impl::last_t_s() const {
  double last_t_s = std::max(last_chamber_t_s, 0.0);
  for (const UnitState& unit : units) last_t_s = std::max(last_t_s, unit.last_t_s);
  return last_t_s;
}

base::Status RunRecorder::Impl::seal() {
  if (!sealed.sha256.empty()) return {};
  for (const UnitState& unit : units) {
    if (unit.rows > 0 || noted_silence) continue;
    auto noted = file.add_event(last_t_s(), "no_samples", fmt::format("unit {} gave no sample", unit.unit.serial));
    if (!noted) return noted;
  }
  noted_silence = true;
  auto sha256 = file.seal();
  if (!sha256) return base::forward_error(sha256);
  sealed.sha256 = *std::move(sha256);
  return {};
}

/// The rows that are meant; null where there are none.
const Attempt* RunRecorder::Impl::attempt_of(const Rejected& rejected) const {
  for (const UnitState& unit : units) {
    if (unit.unit.serial != rejected.unit) continue;
    for (const Attempt& attempt : unit.attempts) {
      const bool meant = attempt.visit == rejected.visit && attempt.position == rejected.position;
      if (meant && attempt.number == rejected.attempt) return &attempt;
    }
  }
  return nullptr;
}

base::Result<std::vector<db::RunRow>> RunRecorder::finish(const std::vector<Rejected>& rejected,
                                                          const std::optional<std::string>& void_reason,
                                                          const std::map<std::string, std::string>& void_units) {
  if (const auto sealed = impl_->seal(); !sealed) return base::forward_error(sealed);
  SealedRun run = impl_->sealed;
  run.void_reason = void_reason;
  run.void_units = void_units;
  for (const Rejected& one : rejected) {
    Withdrawal withdrawal{one.unit, {}, one.reason};
    if (const Attempt* attempt = impl_->attempt_of(one)) withdrawal.span = {attempt->from_s, attempt->to_s};
    run.withdrawals.push_back(std::move(withdrawal));
  }
  return enter_run(impl_->catalog, run);
}

const db::RunInfo& RunRecorder::info() const { return impl_->info; }

std::uint64_t RunRecorder::rows(std::size_t unit) const { return impl_->units.at(unit).rows; }

}  // namespace soak::station
