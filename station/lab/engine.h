// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <deque>
#include <functional>
#include <future>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "base/result.h"
#include "db/catalog/catalog.h"
#include "station/config/station_config.h"
#include "station/lab/event_log.h"
#include "station/lab/history.h"
#include "station/lab/lab.h"
#include "station/lab/lab_service.h"
#include "station/lab/safe_end.h"
#include "station/lab/start_check.h"
#include "station/lab/step_task.h"

namespace soak::station {

/// Where the lab stands. docs/architecture.md has the table of all transitions.
enum class LabState : std::uint8_t {
  idle,
  running,
  paused,       ///< by the operator: the chamber holds its set point, units are recorded as on the way
  stopping,     ///< on the way to the safe state
  interrupted,  ///< soakd died in mid-campaign; resume begins the run anew that was cut short
  finished,
  aborted,
  failed,
};

[[nodiscard]] std::string_view name_of(LabState state);

/// Carries out campaigns: owns the devices and the run files, walks through the plan, persists each step's completion
/// before the next begins, ends safely whatever happens. Its thread is the only one that touches a device or the
/// catalog.
class Engine : public LabService {
 public:
  /// Makes the devices of the configuration; opens none. Seals what a killed predecessor left behind.
  [[nodiscard]] static base::Result<std::unique_ptr<Engine>> make(const StationConfig& config, db::Catalog& catalog);
  ~Engine() override;

  void run();
  /// Asks for the way to the safe state and the end of run(): what SIGTERM does.
  void stop();
  /// Whether run() has come to its end.
  [[nodiscard]] bool stopped() const { return stopped_; }

  [[nodiscard]] base::Result<nlohmann::json> start(const StartRequest& request) override;
  [[nodiscard]] base::Status pause(const std::string& user) override;
  [[nodiscard]] base::Status resume(const std::string& user) override;
  [[nodiscard]] base::Status abort(const std::string& user, const std::string& reason) override;
  [[nodiscard]] base::Status confirm(const std::string& user, std::int64_t prompt) override;
  [[nodiscard]] nlohmann::json status() const override;
  [[nodiscard]] std::uint64_t status_version() const override { return status_version_; }
  [[nodiscard]] nlohmann::json plan() const override;
  [[nodiscard]] nlohmann::json history(double after_s) const override { return history_.document(after_s); }
  [[nodiscard]] base::Result<nlohmann::json> noise(const std::string& unit) const override;
  [[nodiscard]] nlohmann::json log(std::int64_t after) const override { return log_.document(after); }

 private:
  Engine(const StationConfig& config, db::Catalog& catalog);
  [[nodiscard]] base::Status make_devices();
  /// What switches the units; null where that is done by hand.
  [[nodiscard]] base::Result<hal::UnitPower*> make_power();
  [[nodiscard]] base::Status take_over();
  [[nodiscard]] base::Status know_unfinished();
  void know_units_of(const db::CampaignRow& row);
  void make_units(const CheckedStart& checked);
  void settle_lost_runs();

  /// Runs a command on the engine's thread and waits for what it says.
  [[nodiscard]] base::Result<nlohmann::json> command(std::function<base::Result<nlohmann::json>()> work);
  void serve_commands();
  void wait();
  void wake();
  void turn();
  void advance();
  void watch_alarms();
  void watch_set_point();
  /// Writes the state into the journal; where that fails, again every second and before the next campaign.
  void keep_state();
  [[nodiscard]] bool hold_for_chamber();
  void remember();
  void publish();

  /// `resume_at`: the step at which an interrupted campaign goes on; nothing for a new one.
  [[nodiscard]] base::Result<nlohmann::json> do_start(const StartRequest& request,
                                                      std::optional<std::size_t> resume_at);
  [[nodiscard]] base::Result<nlohmann::json> do_resume(const std::string& user);
  [[nodiscard]] base::Status ready_for_start() const;
  /// Enters a campaign that begins, and what it is measured with from now on, into the catalog.
  [[nodiscard]] base::Status keep_start(const StartRequest& request, const CheckedStart& checked,
                                        const std::vector<calib::ReferenceUse>& references,
                                        const std::vector<std::string>& notes, bool is_resumed);
  [[nodiscard]] base::Status connect_devices();
  void begin_campaign(const StartRequest& request, CheckedStart checked, std::optional<std::size_t> resume_at);

  void enter_step(std::size_t step);
  [[nodiscard]] std::unique_ptr<StepTask> new_task(std::size_t index);
  void step_ended(const StepProgress& progress);
  /// False where the journal cannot be written: the campaign then ends.
  bool persist_step(const std::string& outcome, const std::string& text);
  /// Goes back to where the position was last proved: after a break the judgements of temperature and position are
  /// void.
  void repeat_step(const std::string& why);
  void end_campaign(LabState outcome, const std::string& reason, bool outputs_off = false);
  void set_state(LabState state, const std::string& reason);

  const StationConfig& config_;
  db::Catalog& catalog_;
  EventLog log_;
  History history_;
  std::unique_ptr<hal::Chamber> chamber_;
  std::unique_ptr<hal::Fixture> fixture_;
  std::unique_ptr<hal::UnitPower> power_;  ///< where it is a device of its own
  std::unique_ptr<Lab> lab_;

  LabState state_ = LabState::idle;
  LabState outcome_ = LabState::idle;  ///< of the safe end
  std::string reason_;
  std::size_t step_ = 0;
  std::map<std::size_t, int> step_attempts_;
  double step_started_utc_s_ = 0.0;
  double campaign_started_utc_s_ = 0.0;
  double step_started_s_ = 0.0;
  std::unique_ptr<StepTask> task_;
  std::unique_ptr<SafeEnd> safe_end_;
  std::optional<std::chrono::steady_clock::time_point> stale_since_;
  std::chrono::steady_clock::time_point next_keep_{};
  bool journal_is_behind_ = false;
  bool settle_fully_ = false;  ///< the next wait for stability is no short one after a turn
  int told_again_ = 0;         ///< how often the chamber had to be told the present set point again
  double told_c_ = 0.0;
  std::string unfinished_;      ///< campaign that can be resumed
  bool runs_are_lost_ = false;  ///< run files that a killed predecessor left are not entered yet

  std::mutex command_mutex_;
  std::deque<std::packaged_task<base::Result<nlohmann::json>()>> commands_;
  std::array<int, 2> wake_{-1, -1};  ///< a pipe that ends wait()
  std::atomic<bool> stop_requested_ = false;
  std::atomic<bool> stopped_ = false;

  mutable std::mutex status_mutex_;
  nlohmann::json status_;
  nlohmann::json plan_document_;
  std::map<std::string, std::shared_ptr<const NoiseWatch>> noise_;  ///< of the campaign's units
  std::atomic<std::uint64_t> status_version_ = 0;
  std::chrono::steady_clock::time_point published_{};
};

}  // namespace soak::station
