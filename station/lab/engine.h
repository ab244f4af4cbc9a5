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
#include "station/io/data_folder.h"
#include "station/lab/campaign_log.h"
#include "station/lab/campaign_note.h"
#include "station/lab/campaign_queue.h"
#include "station/lab/campaign_state.h"
#include "station/lab/chamber_guard.h"
#include "station/lab/chamber_watch.h"
#include "station/lab/journal.h"
#include "station/lab/safe_end.h"
#include "station/lab/start_check.h"
#include "station/lab/station.h"
#include "station/lab/station_service.h"
#include "station/lab/steps.h"
#include "station/lab/suspenders.h"

namespace soak::station {

/// Carries out campaigns: owns the devices and the run files, walks through the plan, persists each step's completion
/// before the next begins, ends safely whatever happens. Its thread is the only one that touches a device or the
/// catalog, but for those of the chamber's watch, the journal and the sealing of runs, which have connections of their
/// own, and those that look into the slots while the station is idle.
class Engine : public StationService {
 public:
  /// Makes the devices of the configuration; opens none. Takes over what a killed predecessor left behind.
  [[nodiscard]] static base::Result<std::unique_ptr<Engine>> make(const StationConfig& config, db::Catalog& catalog);
  ~Engine() override;

  /// Works until stop(). `turned`: called after each turn of the loop, some 50 times a second. Fails (device) where the
  /// chamber was not safe in the end because for two hours it had not answered, or had refused to go off
  /// (SafeEnd::why_hopeless()); the campaign then is open for the next soakd to take over.
  [[nodiscard]] base::Status run(const std::function<void()>& turned = [] {});
  /// Asks for the way to the safe state and the end of run(): what SIGTERM does.
  void stop();
  /// Keeps campaigns from beginning and looks into the slots from being taken: the station is to begin anew with other
  /// settings. Refuses (bad_input, where == "state") while a campaign is under way or will go on, one is in the queue,
  /// or the units are being asked. Any thread may call.
  [[nodiscard]] base::Status hold_for_settings();
  /// Nothing has come of it.
  void end_hold();
  /// Whether run() has come to its end.
  [[nodiscard]] bool stopped() const { return stopped_; }

  [[nodiscard]] base::Result<nlohmann::json> start(const StartRequest& request) override;
  [[nodiscard]] base::Result<nlohmann::json> queue(const StartRequest& request) override;
  [[nodiscard]] base::Result<nlohmann::json> check(const StartRequest& request) override;
  [[nodiscard]] base::Result<nlohmann::json> look(const std::string& user) override;
  [[nodiscard]] base::Status unqueue(const std::string& user, const std::string& campaign) override;
  [[nodiscard]] base::Status next(const std::string& user, const std::string& campaign) override;
  [[nodiscard]] base::Status pause(const std::string& user) override;
  [[nodiscard]] base::Status resume(const std::string& user) override;
  [[nodiscard]] base::Status abort(const std::string& user, const std::string& reason) override;
  [[nodiscard]] base::Status confirm(const std::string& user, std::int64_t prompt) override;
  [[nodiscard]] nlohmann::json status() const override;
  void note(const std::string& kind, const std::string& subject, const std::string& text,
            const std::string& user) override {
    log_.add(kind, subject, text, user);
  }
  [[nodiscard]] std::uint64_t status_version() const override { return status_version_; }
  [[nodiscard]] base::Result<nlohmann::json> plan(std::optional<std::int64_t> around) const override;
  [[nodiscard]] nlohmann::json history(double after_s) const override { return history_.document(after_s); }
  [[nodiscard]] base::Result<nlohmann::json> noise(const std::string& unit) const override;
  [[nodiscard]] base::Result<nlohmann::json> stored() override;
  [[nodiscard]] nlohmann::json procedures(const std::string& file) const override;
  [[nodiscard]] nlohmann::json types() const override;
  [[nodiscard]] nlohmann::json log(std::int64_t after) const override { return log_.document(after); }

 private:
  /// Process time before a campaign begins or goes on by itself, for people to see it and to stop it; and between
  /// tries.
  static constexpr double kGrace_s = 300.0;
  static constexpr std::string_view kHeld = "the station is about to begin anew with other settings: wait some seconds";
  static constexpr std::string_view kNothingLeft =
      "all units of this run were dropped: no unit is left, and nothing to record";

  Engine(const StationConfig& config, db::Catalog& catalog, std::unique_ptr<Journal> journal);
  [[nodiscard]] base::Status make_devices();
  /// What switches the units; null where that is done by hand.
  [[nodiscard]] base::Result<hal::UnitPower*> make_power();
  [[nodiscard]] base::Status take_over();
  [[nodiscard]] base::Status restore_unfinished();
  void restore_units(const db::CampaignRow& row);
  /// Lets the campaign go on by itself after a restart, unless somebody is just stopping it.
  void allow_to_go_on();
  /// Goes on with a campaign that was cut short, once nothing hinders it.
  void resume_by_itself();
  [[nodiscard]] base::Status try_to_resume();
  void restore_queue();
  void drop_what_has_begun();
  void hold_queue();
  void let_queue_go_on();
  void give_notice();
  void follow_with_queue(CampaignState ended);
  [[nodiscard]] bool next_begins_by_itself() const;
  /// Begins the next campaign of the queue, once nothing hinders it.
  void begin_next_by_itself();
  [[nodiscard]] base::Status try_to_begin(const QueuedCampaign& first);
  /// Keeps what the next soakd is to know if this one ends now. Called in every turn, and whenever the state changes.
  void keep_note();
  [[nodiscard]] CampaignNote note_now() const;
  [[nodiscard]] CampaignNote ended_note(CampaignState outcome) const;
  void make_units(const CheckedStart& checked);
  /// True once there is nothing left to enter, or it failed.
  [[nodiscard]] bool runs_of_predecessor_are_entered();

  /// Runs a command on the engine's thread and waits for its answer. `late`: called here where that takes half a
  /// minute.
  [[nodiscard]] base::Result<nlohmann::json> command(
      std::function<base::Result<nlohmann::json>()> work, const std::function<void()>& late = [] {});
  [[nodiscard]] base::Status status_command(
      std::function<base::Status()> work, const std::function<void()>& late = [] {});
  /// A command that may begin a campaign: run files that were left behind are entered first. Who asks waits for that,
  /// the loop does not.
  [[nodiscard]] base::Result<nlohmann::json> command_after_left_runs(
      const std::function<base::Result<nlohmann::json>()>& work);
  void run_commands();
  void wait();
  void wake();
  static void wake_at(int fd);
  /// One turn of the loop in run().
  void cycle();
  void advance();
  void watch_alarms();
  /// Ends the campaign where chamber and units do not fit together.
  void watch_guard();
  /// Arms the chamber's watch while a campaign drives the chamber, and ends the campaign where it has tripped.
  void heed_watch();
  /// Heating and cooling must stop, now and on the way to the safe state.
  void switch_off_chamber(const std::string& why);
  void follow_safe_end();
  /// Keeps what was recorded, and says that somebody must look after the chamber.
  [[nodiscard]] base::Status leave_chamber(const std::string& why);
  void watch_set_point();
  /// Notices a data folder that was unmounted, deleted or replaced: what is written from then on nobody finds again.
  void watch_data_folder();
  /// Suspends the campaign where it cannot be carried on, and goes on with it once it can.
  void watch_conditions();
  /// A short silence of the chamber: nothing begins meanwhile.
  void hold_for_chamber();
  [[nodiscard]] StationConditions conditions() const;
  [[nodiscard]] std::optional<double> air_off_k() const;
  /// Whether the air is, in this step, on its way or where people let it go: they turn the fixture at the open door.
  [[nodiscard]] bool air_may_leave(const Step& step) const;
  void follow_air();
  /// Whether all units of the open run were dropped.
  [[nodiscard]] bool nothing_is_left_to_record() const;
  [[nodiscard]] bool ends_without_plateau() const;
  [[nodiscard]] std::vector<StationConditions::Supply> supplies() const;
  /// Whether the present step leads to the safe state, for which nothing but the chamber is needed.
  [[nodiscard]] bool makes_safe() const;
  /// Whether what holds suspends the present step.
  [[nodiscard]] bool must_wait() const;
  /// Looks whether there is room on the disk, and whether what could not be written can be written now.
  void probe_storage();
  void suspend();
  /// What was judged and recorded at the present visit counts no more: it begins again when the campaign goes on.
  void void_visit(const std::string& why);
  void go_on();
  void record_history();
  /// Publishes the status document where it has changed, ten times a second at most.
  void publish();
  [[nodiscard]] nlohmann::json status_document() const;
  [[nodiscard]] nlohmann::json campaign_document() const;
  [[nodiscard]] nlohmann::json suspension_document() const;
  [[nodiscard]] nlohmann::json ending_document() const;
  [[nodiscard]] nlohmann::json queue_document() const;
  [[nodiscard]] std::string_view shown_state() const;
  [[nodiscard]] bool waits_for_journal() const;
  [[nodiscard]] std::string step_trouble() const;
  [[nodiscard]] std::string shown_reason() const;
  [[nodiscard]] std::string reason_of_state() const;

  /// `resumed`: the way back into a campaign that was cut short; nothing for a new one.
  [[nodiscard]] base::Result<nlohmann::json> do_start(const StartRequest& request,
                                                      const std::optional<WayBack>& resumed);
  /// Of a request of which nothing has begun yet: mistakes, cost, notes.
  [[nodiscard]] base::Result<nlohmann::json> reviewed_document(const StartRequest& request) const;
  [[nodiscard]] base::Result<nlohmann::json> check_for_queue(const StartRequest& request, QueuedCampaign& queued);
  /// Begins the first campaign of the queue and takes it out.
  [[nodiscard]] base::Result<nlohmann::json> begin_first(const QueuedCampaign& first, const std::string& user);
  [[nodiscard]] base::Status begin_hold();
  /// Keeps the units' links for a look into the slots: no campaign begins meanwhile.
  [[nodiscard]] base::Status begin_look();
  [[nodiscard]] base::Status do_pause(const std::string& user);
  [[nodiscard]] base::Status do_resume(const std::string& user);
  [[nodiscard]] base::Status do_abort(const std::string& user, const std::string& reason);
  [[nodiscard]] base::Status do_confirm(const std::string& user, std::int64_t prompt);
  [[nodiscard]] base::Status ready_for_start() const;
  /// Enters a campaign that begins, and what it is measured with from now on, into the catalog.
  [[nodiscard]] base::Status store_start(const StartRequest& request, const CheckedStart& checked,
                                         const std::vector<calib::ReferenceUse>& references,
                                         const std::vector<std::string>& notes, const std::optional<WayBack>& resumed);
  [[nodiscard]] base::Status connect_devices();
  void begin_campaign(const StartRequest& request, CheckedStart checked, const std::optional<WayBack>& resumed);

  /// Whether the present step is on the way back into a run, and not the last one of it.
  [[nodiscard]] bool is_on_way_back() const { return way_at_ + 1 < way_back_.size(); }
  /// Process time to the end of the campaign, by the plan's estimates. Of one that is paused, suspended, or has a
  /// chamber that does not answer: what remains if it goes on now. Of one that is over: from the step where it ended.
  [[nodiscard]] double remaining_s() const;
  /// The same from a step on: from its place on the way back while it is there, else from its number in the plan.
  [[nodiscard]] double left_from_s(std::size_t at) const;
  /// Where a campaign goes on that is held in mid-step, as repeat_step() and repeat_visit() go there; counted as
  /// left_from_s().
  [[nodiscard]] std::size_t begins_again_at() const;
  void enter_step(std::size_t step);
  void step_failed(const StepProgress& progress);
  /// A step has come to its end that had never come so far in this campaign.
  void note_progress();
  /// Gives the end of the present step to the journal and waits, from turn to turn, until it is written: nothing begins
  /// before.
  [[nodiscard]] bool step_is_stored();
  Journal::Written follow_end_of_step();
  void forget_end_of_step();
  [[nodiscard]] db::StepRow step_row(const std::string& outcome, const std::string& text);
  void leave_step();
  void enter_next_step();
  void forget_way();
  /// All steps have ended.
  void finish();
  /// Goes back to where the position was last confirmed: after a break nothing that was judged of temperature and
  /// position counts any more.
  void repeat_step(const std::string& why);
  /// Goes back to the begin of the present visit, by way of where the temperature turned if it has left the plan's.
  void repeat_visit();
  void go_to_visit(bool air_was_away);
  [[nodiscard]] bool begins_anew(const Step& step) const;
  void end_campaign(CampaignState outcome, const std::string& reason, bool outputs_off = false,
                    const std::string& user = {});
  /// `user`: who asked for it; empty where the station decided.
  void set_state(CampaignState state, const std::string& reason, const std::string& user = {});
  /// The same where the catalog knows of it already, or must not yet.
  void show_state(CampaignState state, const std::string& reason, const std::string& user);

  const StationConfig& config_;
  db::Catalog& catalog_;
  const OpenedFolder data_folder_;
  std::string folder_trouble_;
  std::chrono::steady_clock::time_point next_folder_look_{};
  std::unique_ptr<Journal> journal_;
  CampaignNoteKeeper notes_;  ///< before the chamber's watch, which withdraws them
  EventLog log_;
  TemperatureLog history_;
  std::unique_ptr<hal::Chamber> chamber_;
  std::unique_ptr<hal::Fixture> fixture_;
  std::unique_ptr<hal::UnitPower> power_;  ///< where it is a device of its own
  std::unique_ptr<Station> station_;

  CampaignState state_ = CampaignState::idle;
  CampaignState outcome_ = CampaignState::idle;  ///< of the safe end
  std::string reason_;
  std::optional<std::string> reason_behind_way_;  ///< that of a resumed campaign once its first visit is over
  std::string state_user_;                        ///< who asked for the state; empty where the station decided
  std::size_t step_ = 0;
  std::vector<std::size_t> way_back_;  ///< steps that come first after a break
  std::size_t way_at_ = 0;             ///< place of the present step among them
  std::map<std::size_t, int> step_attempts_;
  double step_started_utc_s_ = 0.0;
  double campaign_started_utc_s_ = 0.0;
  double step_started_s_ = 0.0;
  std::unique_ptr<StepTask> task_;
  std::optional<StepProgress> ended_;      ///< how the present step ended, until the journal has it
  std::optional<db::StepRow> ended_row_;   ///< its entry
  std::optional<Journal::Ticket> ticket_;  ///< of the last try to enter it
  std::optional<std::string> broken_;      ///< why what follows it must be judged anew
  std::string step_error_;                 ///< why it could not be entered so far
  std::chrono::steady_clock::time_point next_entry_{};
  std::unique_ptr<SafeEnd> safe_end_;
  ChamberGuard guard_;
  std::unique_ptr<ChamberWatch> watch_;  ///< null where the controller takes no second connection
  bool watch_is_blind_ = false;
  Suspenders suspenders_;
  bool chamber_is_silent_ = false;
  std::chrono::steady_clock::time_point silent_since_{};
  bool visit_is_void_ = false;          ///< the campaign was suspended, and has not gone on since
  bool air_was_away_ = false;           ///< meanwhile
  bool air_has_arrived_ = false;        ///< at the set point, since the last step that may have moved it from there
  bool chamber_is_left_alone_ = false;  ///< it was silent for long while people had it in hand: until they resume
  std::string storage_error_;           ///< why what was measured could not be written
  std::optional<double> disk_free_bytes_;
  std::chrono::steady_clock::time_point next_disk_look_{};
  std::chrono::steady_clock::time_point next_probe_{};
  bool settle_fully_ = false;  ///< the next wait for stability is no short one after a turn
  int set_point_repeats_ = 0;  ///< how often the present set point had to be commanded again
  double repeated_c_ = 0.0;
  std::string unfinished_;          ///< campaign that can be resumed
  CampaignNote note_;               ///< that was kept last
  double interrupted_utc_s_ = 0.0;  ///< when the predecessor's campaign was cut short
  bool has_come_on_ = false;        ///< since the campaign was started or resumed
  bool was_asking_ = false;         ///< somebody, when the campaign was suspended; no step has ended since
  bool resumes_by_itself_ = false;
  double next_resume_s_ = 0.0;  ///< process time
  std::string resume_trouble_;  ///< of the last try
  CampaignQueue queue_;
  bool queue_is_held_ = false;      ///< its next campaign waits for somebody, whatever finishes
  bool device_was_silent_ = false;  ///< at the last try to begin it
  double queue_since_s_ = 0.0;      ///< process time since which it is the next one's turn
  double next_begin_s_ = 0.0;       ///< process time of the next try
  double next_begin_utc_s_ = 0.0;   ///< the same by the host's clock
  std::string queue_trouble_;       ///< of the last try
  bool is_held_ = false;            ///< for other settings: nothing begins
  bool looks_into_slots_ = false;   ///< threads of look() have the units' links
  bool runs_are_lost_ = false;      ///< run files that a killed predecessor left are not entered yet

  std::mutex command_mutex_;
  std::deque<std::packaged_task<base::Result<nlohmann::json>()>> commands_;
  std::array<int, 2> wake_{-1, -1};  ///< a pipe that ends wait()
  std::atomic<bool> stop_requested_ = false;
  std::atomic<bool> stopped_ = false;
  std::atomic<int> stop_commands_ = 0;  ///< aborts and pauses that somebody waits for

  mutable std::mutex status_mutex_;
  nlohmann::json status_;
  nlohmann::json plan_document_;
  std::map<std::string, std::shared_ptr<const NoiseWatch>> noise_;  ///< of the campaign's units
  std::atomic<std::uint64_t> status_version_ = 0;
  std::chrono::steady_clock::time_point published_{};
};

}  // namespace soak::station
