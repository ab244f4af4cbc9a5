// SPDX-License-Identifier: Apache-2.0
#include "station/lab/station.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "station/import/slow_channel.h"
#include "station/io/host.h"

namespace soak::station {
namespace {

constexpr double kSilenceLimit_s = 15.0;  ///< host time without a sample after which a unit is given up
constexpr std::chrono::seconds kFlushInterval{5};
/// Of a unit, while the operator is asked: however long that takes, they are bounded. A minute and a half at 200 Hz.
constexpr std::size_t kMostBeforeRun = 20'000;

/// Process time between readings of what switches the units.
double supply_poll_s(const StationConfig& config) {
  constexpr double kHubPoll_s = 1.0;
  if (const auto* map = std::get_if<hal::DeviceMap>(&config.power)) return map->link.poll_s;
  return std::holds_alternative<hal::UsbHubs>(config.power) ? kHubPoll_s : config.chamber.link.poll_s;
}

/// The position as it stands on a fixture that is turned about the vertical.
void turn(calib::Position& position, double turned_deg) {
  if (!position.azimuth_deg || turned_deg == 0.0) return;
  position.azimuth_deg = std::fmod(*position.azimuth_deg + turned_deg, 360.0);
}

}  // namespace

Station::Station(const StationConfig& config_, db::Catalog& catalog_, EventLog& log_, hal::Chamber& chamber_,
                 hal::Fixture* fixture_, hal::UnitPower* power_)
    : config(config_),
      catalog(catalog_),
      log(log_),
      time(config_.clock_rate),
      chamber(chamber_, config_.chamber.link.poll_s),
      fixture(fixture_),
      sealer(catalog_.data_folder()) {
  if (power_) supply.emplace(*power_, supply_poll_s(config), config.clock_rate);
}

std::vector<UnitChannel*> Station::active_units() const {
  std::vector<UnitChannel*> active;
  for (const auto& unit : units) {
    if (unit->active()) active.push_back(unit.get());
  }
  return active;
}

bool Station::simulated() const {
  return config.clock_rate != 1.0 ||
         std::any_of(units.begin(), units.end(), [](const auto& unit) { return unit->simulated(); });
}

base::Status Station::poll() {
  std::optional<double> furthest_s;
  base::Status stored;
  for (const auto& unit : units) {
    if (const auto at_s = poll_unit(*unit)) furthest_s = std::max(furthest_s.value_or(*at_s), *at_s);
    if (const auto status = record(*unit); !status) stored = status;
    unit->noise->refresh(std::chrono::steady_clock::now());
  }
  time.advance(std::chrono::steady_clock::now(), furthest_s);
  if (chamber.poll(now_s())) {
    if (const auto status = record_chamber(); !status) stored = status;
  }
  find_silent_units();
  watch_supply();
  const auto host_now = std::chrono::steady_clock::now();
  if (recorder_ && host_now - flushed_ >= kFlushInterval) {
    flushed_ = host_now;
    if (const auto status = recorder_->flush(); !status) stored = status;
  }
  return stored;
}

std::optional<double> Station::poll_unit(UnitChannel& unit) {
  unit.poll();
  if (unit.streaming()) return unit.clock.follow(now_s(), unit.clock_restarted(), unit.advance_s());
  unit.clock.lose();
  return std::nullopt;
}

base::Status Station::record(UnitChannel& unit) {
  if (unit.fresh().empty() || !unit.active() || recording_is_held_) return {};
  if (!recorder_) {
    if (expecting_run_) buffer_samples(unit);
    return {};
  }
  const std::uint32_t power_on = run_power_on_[unit.serial()];
  // Samples from before the unit was switched on belong to no run.
  auto samples = unit.fresh();
  while (!samples.empty() && samples.front().power_on < power_on) samples = samples.subspan(1);
  const auto restart =
      std::find_if(samples.begin(), samples.end(), [&](const auto& s) { return s.power_on != power_on; });
  const bool restarted = restart != samples.end();
  samples = samples.first(static_cast<std::size_t>(restart - samples.begin()));
  if (const auto added = add_rows(unit, samples); !added) return added;
  if (restarted) lose(unit, "it restarted during the run; its samples after that belong to no run");
  return {};
}

void Station::buffer_samples(const UnitChannel& unit) {
  auto& kept = samples_before_run_[unit.serial()];
  for (const hal::ImuSample& sample : unit.fresh()) {
    if (!kept.empty() && kept.back().power_on != sample.power_on) kept.clear();
    kept.push_back(sample);
  }
  if (!prompts.open() || kept.size() < 2 * kMostBeforeRun) return;
  kept.erase(kept.begin(), kept.end() - kMostBeforeRun);
}

base::Status Station::add_rows(UnitChannel& unit, std::span<const hal::ImuSample> samples) {
  std::vector<bool> in_segment;
  for (const hal::ImuSample& sample : samples) in_segment.push_back(unit.capture && unit.capture->takes(sample));
  for (std::size_t first = 0; first < samples.size();) {
    std::size_t last = first + 1;
    while (last < samples.size() && in_segment[last] == in_segment[first]) ++last;
    RowLabels labels = labels_;
    labels.phase = in_segment[first] ? calib::Phase::soak : calib::Phase::ramp;
    labels.position = moving_ ? "" : unit.position().label;
    const auto added = recorder_->add(unit.recorder_index, samples.subspan(first, last - first), labels);
    if (!added) return added;
    // What a turning fixture adds is not the unit's noise.
    if (in_segment[first] && labels.rate_dps == 0.0) unit.noise->add(samples.subspan(first, last - first));
    first = last;
  }
  return {};
}

base::Status Station::record_chamber() {
  if (!recorder_ || recording_is_held_) return {};
  const auto active = active_units();
  const auto clock =
      std::find_if(active.begin(), active.end(), [](const auto* unit) { return unit->latest().has_value(); });
  return clock == active.end() ? base::Status{} : recorder_->add_chamber((*clock)->latest()->t_s, *chamber.reading());
}

void Station::find_silent_units() {
  if (!recorder_) return;
  for (UnitChannel* unit : active_units()) {
    if (unit->streaming() || unit->silent_s() < kSilenceLimit_s) continue;
    lose(*unit, unit->trouble().empty() ? "it has stopped sending" : unit->trouble());
  }
}

void Station::watch_supply() {
  if (!recorder_ || !supply) return;
  std::vector<int> outputs;
  for (const UnitChannel* unit : active_units()) {
    const auto& output = unit->slot().power_output;
    if (output && supply->measures(*output)) outputs.push_back(*output);
  }
  if (outputs.empty()) return;
  const bool answered_before = supply->trouble().empty();
  const bool fresh = supply->poll(outputs, now_s());
  if (answered_before != supply->trouble().empty()) {
    log.add(
        "device", "power",
        answered_before ? "cannot be read, volts and amps are not recorded: " + supply->trouble() : "answers again");
  }
  if (!fresh) return;
  for (UnitChannel* unit : active_units()) judge_supply(*unit);
}

void Station::judge_supply(UnitChannel& unit) {
  const auto& output = unit.slot().power_output;
  const auto reading = output ? supply->reading(*output) : std::nullopt;
  if (!reading) return;
  recorder_->add_supply(unit.recorder_index, *reading);
  const auto trouble = supply->fault_of(*output);
  if (!trouble) return;
  cut_off(unit);
  lose(unit, *trouble + "; switched off");
}

void Station::cut_off(const UnitChannel& unit) {
  const int output = *unit.slot().power_output;
  if (const auto off = supply->switch_off(output, now_s()); !off) {
    log.add("power", unit.serial(), fmt::format("output {} cannot be switched off: {}", output, off.error().message));
  }
}

void Station::lose(UnitChannel& unit, const std::string& why) {
  log.add("unit", unit.serial(), fmt::format("lost for the rest of the run: {}", why));
  if (recorder_) {
    // The run file keeps what was recorded. A note that cannot be written there is still in the catalog's log.
    (void)recorder_->add_event(unit.latest() ? unit.latest()->t_s : 0.0, "unit lost", unit.serial() + ": " + why);
  }
  close_capture(unit, "the unit was lost: " + why);
  lost_[unit.serial()] = "the unit was lost: " + why;
  if (recorder_) campaign.missing_units.push_back(fmt::format("{} in {}", unit.serial(), recorder_->info().label));
  unit.drop(why);
}

void Station::expect_run() {
  expecting_run_ = true;
  samples_before_run_.clear();
}

void Station::expect_no_run() {
  expecting_run_ = false;
  samples_before_run_.clear();
}

std::string Station::free_label(const std::string& label) const {
  const auto runs = catalog.runs({.unit = {}, .campaign = campaign.name, .run = {}});
  if (!runs) return label;
  std::string free = label;
  for (int again = 2; std::any_of(runs->begin(), runs->end(), [&](const auto& run) { return run.label == free; });
       ++again) {
    free = fmt::format("{}.{}", label, again);
  }
  return free;
}

/// Run id of the newest part of the run `label` that was cut short; empty where there is none.
std::string Station::part_before(const std::string& label) const {
  const auto runs = catalog.runs({.unit = {}, .campaign = campaign.name, .run = {}});
  std::string before;
  for (const db::RunRow& run : runs ? *runs : std::vector<db::RunRow>()) {
    const bool same = run.label == label || run.label.starts_with(label + ".");
    if (same && !run.cut_short.empty()) before = run.run_id;
  }
  return before;
}

base::Status Station::open_recorder(const PlannedRun& run) {
  db::RunInfo info;
  info.run_id = new_run_id();
  info.label = free_label(run.label);
  info.continues = part_before(run.label);
  info.campaign = campaign.name;
  info.procedure = procedure().name;
  info.created_utc_s = now_utc_s();
  info.clock_rate = config.clock_rate;
  info.simulated = simulated();
  info.source = kRunSource;
  info.site = config.site;
  std::vector<RecordedUnit> recorded;
  for (UnitChannel* unit : active_units()) {
    unit->recorder_index = recorded.size();
    auto positions = positions_of(unit->slot(), config);
    for (calib::Position& position : positions) turn(position, procedure().turned_deg);
    const auto& output = unit->slot().power_output;
    const bool measured = supply && output && supply->measures(*output);
    recorded.push_back({unit->serial(), unit->type().name, unit->type(), std::move(positions), measured});
  }
  const Purpose purpose = run.preflight ? Purpose::diagnosis : procedure().purpose;
  auto recorder = RunRecorder::begin(catalog, info, std::string(name_of(purpose)), std::move(recorded),
                                     !procedure().rate_positions.empty());
  if (!recorder) return base::forward_error(recorder);
  if (auto noted = recorder->add_event(0.0, "begun", campaign.begun_by); !noted) return noted;
  recorder_ = *std::move(recorder);
  run_is_preflight_ = purpose == Purpose::diagnosis;
  return {};
}

base::Status Station::begin_run(const PlannedRun& run) {
  if (auto status = open_recorder(run); !status) return status;
  expecting_run_ = false;
  labels_ = {};
  moving_ = true;
  lost_.clear();
  flushed_ = std::chrono::steady_clock::now();
  for (UnitChannel* unit : active_units()) {
    run_power_on_[unit->serial()] = unit->power_on();
    unit->noise->begin_run();
    if (auto status = add_rows(*unit, samples_before_run_[unit->serial()]); !status) return status;
  }
  samples_before_run_.clear();
  const std::string& before = recorder_->info().continues;
  log.add("run", recorder_->info().label,
          fmt::format("begins as {}{}{}", recorder_->info().run_id, before.empty() ? "" : ", goes on with ", before));
  return {};
}

base::Status Station::flush() { return recorder_ ? recorder_->flush() : base::Status{}; }

base::Result<bool> Station::end_run(const std::optional<std::string>& why_cut, bool aborted) {
  expecting_run_ = false;
  if (sealer.busy()) return follow_sealing();
  if (recorder_) {
    break_segment(why_cut.value_or("the run ended"));
    sealer.begin(*std::exchange(recorder_, std::nullopt), end_of_run(why_cut, aborted));
    if (supply) supply->forget();
    return false;
  }
  if (!sealer.has_run()) return true;
  sealer.retry();
  return false;
}

RunEnd Station::end_of_run(const std::optional<std::string>& why_cut, bool aborted) const {
  const bool keeps_parts = procedure().on_break == BreakOutcome::resume && !aborted && !run_is_preflight_;
  return {why_cut, lost_, keeps_parts};
}

base::Result<bool> Station::follow_sealing() {
  const auto sealed = sealer.take();
  if (!sealed) return false;
  seal_trouble_ = sealed->status ? "" : sealed->status.error().message;
  if (!sealed->status) return base::forward_error(sealed->status);
  const RunEnd& end = sealed->end;
  log.add("run", sealed->label,
          fmt::format("sealed, {} segments withdrawn{}{}", sealed->rejected,
                      !end.void_reason  ? ""
                      : end.keeps_parts ? "; cut short, what is complete is kept: "
                                        : "; voided: ",
                      end.void_reason.value_or("")));
  return true;
}

base::Result<bool> Station::enter_left_runs(const std::string& aborted_campaign) {
  if (!sealer.busy()) sealer.begin_lost_runs(aborted_campaign);
  if (!sealer.enters_lost_runs()) return false;
  const auto lost = sealer.take_lost_runs();
  if (!lost) return false;
  if (!*lost) return base::forward_error(*lost);
  for (const LostRun& run : **lost) log.add("run", run.label, run.text);
  return true;
}

void Station::set_plateau(std::optional<double> plateau_c, calib::Sweep sweep, int visit) {
  labels_.plateau_c = plateau_c;
  labels_.sweep = sweep;
  labels_.visit = visit;
}

base::Result<hal::FixtureReading> Station::read_fixture() {
  auto reading = fixture->read();
  fixture_reading_ = reading ? std::optional(*reading) : std::nullopt;
  return reading;
}

base::Status Station::halt_fixture() {
  if (labels_.rate_dps != 0.0) set_moving(true);
  return fixture == nullptr ? base::Status{} : fixture->halt();
}

void Station::begin_segment(double seconds) {
  for (UnitChannel* unit : active_units()) {
    unit->capture.emplace(seconds);
    unit->noise->begin_recording();
  }
}

std::string Station::position_label(const UnitChannel& unit) const {
  const std::string& label = unit.position().label;
  return labels_.rate_dps == 0.0 ? label : label_at_rate(label, labels_.rate_dps);
}

void Station::close_capture(UnitChannel& unit, const std::optional<std::string>& why_not) {
  if (!unit.capture) return;
  const bool has_rows = unit.capture->samples() > 0;
  unit.capture.reset();
  if (!has_rows) return;
  if (!why_not) {
    if (recorder_) recorder_->accept(unit.recorder_index);
    return;
  }
  if (recorder_) recorder_->reject(unit.recorder_index, *why_not);
  log.add("segment", unit.serial(), fmt::format("{} is not used: {}", position_label(unit), *why_not));
}

void Station::end_segment(const std::map<std::string, std::string>& why_not) {
  for (const auto& unit : units) {
    const auto reason = why_not.find(unit->serial());
    close_capture(*unit, reason == why_not.end() ? std::nullopt : std::optional(reason->second));
  }
}

void Station::break_segment(const std::string& reason) {
  for (const auto& unit : units) close_capture(*unit, reason);
}

void Station::withdraw_visit(int visit, const std::string& reason) {
  if (!recorder_) return;
  for (const UnitChannel* unit : active_units()) {
    const std::size_t count = recorder_->withdraw_visit(unit->recorder_index, visit, reason);
    if (count > 0) log.add("segment", unit->serial(), fmt::format("{} are not used: {}", count, reason));
  }
}

}  // namespace soak::station
