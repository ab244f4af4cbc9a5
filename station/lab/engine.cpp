// SPDX-License-Identifier: Apache-2.0
// The engine's beginning and its loop.
#include "station/lab/engine.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <thread>
#include <utility>

namespace soak::station {
namespace {

using std::chrono::steady_clock;

constexpr int kLongestWait_ms = 20;
/// soakd's end waits so long for a catalog that is locked. What is not written then is lost but for soakd's own log;
/// the campaign is open there, and the next soakd takes it over.
constexpr std::chrono::seconds kLongestGoodbye{30};
constexpr std::chrono::milliseconds kGoodbyeTurn{100};
constexpr std::chrono::seconds kLastEntry{1};

std::filesystem::path note_path(const db::Catalog& catalog) { return catalog.data_folder() / "soakd.campaign"; }
std::filesystem::path queue_path(const db::Catalog& catalog) { return catalog.data_folder() / "soakd.queue"; }

}  // namespace

std::unique_ptr<StepTask> make_task(const Plan& plan, const Step& step) {
  switch (step.kind) {
    case StepKind::power_on:
    case StepKind::power_off:
      return make_power_task(plan, step);
    case StepKind::turn_fixture:
    case StepKind::move:
    case StepKind::spin:
      return make_position_task(step);
    case StepKind::set_temperature:
    case StepKind::wait_stable:
    case StepKind::warm_end:
      return make_temperature_task(plan, step);
    case StepKind::record:
    case StepKind::check:
      return make_record_task(plan, step);
  }
  return nullptr;
}

// --- beginning --------------------------------------------------------------------------------------------------

Engine::Engine(const StationConfig& config, db::Catalog& catalog, std::unique_ptr<Journal> journal)
    : config_(config),
      catalog_(catalog),
      data_folder_(catalog.data_folder()),
      journal_(std::move(journal)),
      notes_(note_path(catalog)),
      log_(*journal_),
      queue_(queue_path(catalog)) {
  note_ = notes_.found().note;
  interrupted_utc_s_ = notes_.found().noted_utc_s;
}

Engine::~Engine() {
  (void)journal_->wait_until_written(kLastEntry);  // what could not be sent any more is noted after run()
  journal_->end();                                 // it wakes the engine
  for (const int fd : wake_) {
    if (fd >= 0) ::close(fd);
  }
}

base::Result<std::unique_ptr<Engine>> Engine::make(const StationConfig& config, db::Catalog& catalog) {
  std::array<int, 2> pipe{-1, -1};
  if (::pipe2(pipe.data(), O_CLOEXEC | O_NONBLOCK) != 0) {
    return base::fail(base::ErrorKind::internal, "cannot make a pipe");
  }
  auto journal = Journal::open(catalog.data_folder(), [fd = pipe[1]] { wake_at(fd); });
  if (!journal) {
    for (const int fd : pipe) ::close(fd);
    return base::forward_error(journal);
  }
  std::unique_ptr<Engine> engine(new Engine(config, catalog, *std::move(journal)));
  engine->wake_ = pipe;
  if (auto status = engine->make_devices(); !status) return base::forward_error(status);
  if (auto status = engine->take_over(); !status) return base::forward_error(status);
  engine->restore_queue();
  engine->publish();
  return engine;
}

base::Status Engine::make_devices() {
  auto chamber = hal::make_chamber(config_.chamber);
  if (!chamber) return base::forward_error(chamber);
  chamber_ = *std::move(chamber);
  watch_ = ChamberWatch::make(config_.chamber, config_.clock_rate,
                              [this](bool outputs_off) { notes_.withdraw(outputs_off); });
  if (config_.fixture) {
    auto fixture = hal::make_fixture(*config_.fixture);
    if (!fixture) return base::forward_error(fixture);
    fixture_ = *std::move(fixture);
  }
  const auto power = make_power();
  if (!power) return base::forward_error(power);
  station_ = std::make_unique<Station>(config_, catalog_, log_, *chamber_, fixture_.get(), *power);
  return {};
}

base::Result<hal::UnitPower*> Engine::make_power() {
  if (const auto* map = std::get_if<hal::DeviceMap>(&config_.power)) {
    auto made = hal::make_unit_power(*map);
    if (!made) return base::forward_error(made);
    power_ = *std::move(made);
  }
  if (const auto* hubs = std::get_if<hal::UsbHubs>(&config_.power)) power_ = hal::make_usb_hub_power(*hubs);
  const bool from_chamber = std::holds_alternative<PowerFromChamber>(config_.power);
  hal::UnitPower* power = from_chamber ? chamber_->unit_power() : power_.get();
  if (from_chamber && power == nullptr) {
    return base::bad_input("'power.from' is \"chamber\", but the chamber's map has no 'unit_power_1'", config_.file);
  }
  for (const Slot& slot : config_.slots) {
    if (!power || !slot.power_output) continue;
    const auto able = power->check(*slot.power_output, slot.supply);
    if (!able) return base::bad_input(fmt::format("slot {}: {}", slot.name, able.error().message), config_.file);
  }
  return power;
}

void Engine::make_units(const CheckedStart& checked) {
  station_->units.clear();
  const hal::Imu::Settings settings{checked.plan.procedure.rate_hz, checked.plan.procedure.temp_rate_hz};
  for (const CheckedUnit& unit : checked.units) {
    station_->units.push_back(std::make_unique<UnitChannel>(unit.slot, unit.serial, unit.type,
                                                            hal::make_imu(link_of(unit.slot, unit.type)), settings));
  }
  const std::lock_guard lock(status_mutex_);
  noise_.clear();
  for (const auto& unit : station_->units) noise_[unit->serial()] = unit->noise;
}

// --- the loop ---------------------------------------------------------------------------------------------------

base::Status Engine::run(const std::function<void()>& turned) {
  base::Status ended;
  while (true) {
    wait();
    heed_watch();  // before a command: what has tripped is not switched on once more
    run_commands();
    cycle();
    publish();
    turned();
    if (!stop_requested_) continue;
    end_campaign(CampaignState::interrupted, "soakd was asked to stop");
    if (state_ != CampaignState::stopping) break;
    const std::string why = safe_end_ ? safe_end_->why_hopeless(*station_) : "";
    if (why.empty()) continue;
    ended = leave_chamber(why);
    break;
  }
  const auto longest = steady_clock::now() + kLongestGoodbye;
  const auto all_is_written = [&] {
    return journal_->wait_until_written(kGoodbyeTurn) && notes_.wait_until_kept(kGoodbyeTurn);
  };
  while (!all_is_written() && steady_clock::now() < longest) {
    run_commands();
    turned();
  }
  for (const auto& unit : station_->units) unit->close();
  stopped_ = true;
  run_commands();
  return ended;
}

base::Status Engine::leave_chamber(const std::string& why) {
  std::string text =
      "soakd ends, and the chamber was not confirmed safe: " + why + ". Go to the chamber, and switch it off by hand";
  if (const std::string units = safe_end_->leave_units(*station_); !units.empty()) text += "; " + units;
  log_.add("alarm", "chamber", text);
  if (const auto flushed = station_->flush(); !flushed) log_.add("run", station_->run_id(), flushed.error().message);
  return base::fail(base::ErrorKind::device, text, chamber_->description());
}

void Engine::stop() {
  stop_requested_ = true;
  wake();
}

void Engine::wake() { wake_at(wake_[1]); }

void Engine::wake_at(int fd) {
  const char byte = 0;
  // A full pipe wakes as well.
  (void)!::write(fd, &byte, 1);
}

void Engine::wait() {
  std::vector<pollfd> fds{{wake_[0], POLLIN, 0}};
  for (const auto& unit : station_->units) {
    if (unit->wait_fd() >= 0) fds.push_back({unit->wait_fd(), POLLIN, 0});
  }
  ::poll(fds.data(), fds.size(), kLongestWait_ms);
  std::array<char, 64> bytes{};
  while (::read(wake_[0], bytes.data(), bytes.size()) > 0) {
  }
}

void Engine::cycle() {
  if (const base::Status stored = station_->poll(); !stored) {
    storage_error_ = stored.error().message;
    // Nobody looks for room any more: what cannot be written must not pile up.
    if (state_ == CampaignState::stopping) station_->hold_recording(true);
  }
  watch_data_folder();
  if (is_under_way(state_)) {
    record_history();
    watch_alarms();
  }
  if (is_under_way(state_) || state_ == CampaignState::stopping) watch_guard();
  if (is_under_way(state_)) watch_conditions();
  if (is_under_way(state_) && !chamber_is_silent_) watch_set_point();
  if (state_ == CampaignState::running && !chamber_is_silent_) advance();
  if (state_ == CampaignState::interrupted && resumes_by_itself_ && !stop_requested_) resume_by_itself();
  if (next_begins_by_itself()) begin_next_by_itself();
  if (state_ == CampaignState::stopping) follow_safe_end();
  keep_note();
}

void Engine::record_history() {
  const auto& reading = station_->chamber.reading();
  std::vector<std::optional<double>> units_c;
  for (const auto& unit : station_->units) units_c.push_back(unit->streaming() ? unit->temp_c() : std::nullopt);
  history_.add(station_->now_s(), reading ? std::optional(reading->air_c) : std::nullopt,
               reading ? std::optional(reading->set_point_c) : std::nullopt, units_c);
}

}  // namespace soak::station
