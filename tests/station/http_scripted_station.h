// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "station/alarms/alarm_rules.h"
#include "station/config/plan.h"
#include "station/lab/station_service.h"

namespace soak::station {

/// A laboratory that says what a test tells it to say and remembers the commands that it got.
class ScriptedStation : public StationService {
 public:
  using json = nlohmann::json;

  /// A whole status document of a campaign that runs.
  static json running_status() {
    return json::parse(R"({
      "state": "running", "reason": null,
      "campaign": {"name": "acceptance", "procedure": "six-position-soak", "purpose": "calibration", "run_label": "run 2",
        "run": 2, "runs": 5, "step": 30, "steps": 240, "step_kind": "record", "step_text": "record at -20 °C, +X up",
        "step_trouble": null, "on_way_back": false,
        "progress": 0.31, "remaining_s": 86400.0, "started_utc_s": 1790000000.0},
      "suspension": null, "ending": null, "journal": {"queued": 0, "discarded": 0, "trouble": null},
      "data": {"folder": "/var/lib/soak", "trouble": null}, "prompt": null,
      "chamber": {"description": "scripted chamber", "connected": true, "air_c": -20.04, "set_point_c": -20.0,
        "output_percent": 37.5, "air_rh_percent": null, "running": true, "alarms": [], "age_s": 0.4},
      "fixture": {"description": "by hand", "connected": true, "position": "+X", "moving": false},
      "units": [
        {"slot": "A", "serial": "SN0042", "type": "xsens-mti", "state": "recording", "dropped": null, "powered": true, "supply_v": null,
         "supply_a": null, "simulated": true,
         "temp_c": -19.31, "slope_kpmin": 0.004, "slope_half_width_kpmin": 0.006, "stable": true, "position": "+X",
         "attitude": {"up": "+Y", "expected": "+X", "right": false},
         "samples": 123456, "lost": 0, "gyro_dps": [0.12, -0.03, 0.4], "accel_mps2": [9.79, 0.02, -0.11],
         "noise": {"tau_s": 0.96, "gyro_dps": [0.0375, 0.0381, 0.0369], "accel_mps2": [0.00167, 0.00171, 0.00166]}},
        {"slot": "B", "serial": "SN0043", "type": "xsens-mti", "state": "settling", "dropped": null, "powered": true, "supply_v": null,
         "supply_a": null, "simulated": true,
         "temp_c": null, "slope_kpmin": null, "slope_half_width_kpmin": null, "stable": false, "position": null,
         "attitude": null,
         "samples": 0, "lost": 7, "gyro_dps": null, "accel_mps2": null,
         "noise": {"tau_s": 0.96, "gyro_dps": null, "accel_mps2": null}}],
      "resumable": null, "resumes_by_itself": false,
      "queue": {"campaigns": [], "waits_for": null, "begins_utc_s": null, "trouble": null}, "room": {"temp_c": 23.0, "dew_point_c": 12.0, "dew_point_assumed": false},
      "clock": {"rate": 60.0, "process_s": 39000.0, "utc_s": 1790000650.0}, "simulated": true, "version": "0.1.0"})");
  }

  static json idle_status() {
    json status = running_status();
    status["state"] = "idle";
    status["campaign"] = nullptr;
    return status;
  }

  /// Of a unit that has recorded nothing yet.
  static json no_noise(const std::string& unit) {
    json sensors;
    for (const char* axis : {"x", "y", "z"}) {
      sensors[std::string("gyro_") + axis] = {{"unit", "deg/s"}, {"oadev", json::array()}, {"mdev", json::array()}};
      sensors[std::string("accel_") + axis] = {{"unit", "m/s2"}, {"oadev", json::array()}, {"mdev", json::array()}};
    }
    return {{"unit", unit}, {"rate_hz", 100.0}, {"samples", 0}, {"tau_s", json::array()}, {"sensors", sensors}};
  }

  void set_status(json status) {
    const std::lock_guard lock(mutex_);
    status_ = std::move(status);
    ++version_;
  }

  /// One member of the status, or of an object in it: "/campaign/step".
  void set(const std::string& pointer, const json& value) {
    const std::lock_guard lock(mutex_);
    status_[json::json_pointer(pointer)] = value;
    ++version_;
  }

  void add_log(const std::string& text) {
    const std::lock_guard lock(mutex_);
    const std::size_t number = log_.size() + 1;
    log_.push_back(
        {{"number", number}, {"utc_s", 1790000000.0}, {"kind", "note"}, {"subject", "test"}, {"text", text}});
  }

  /// What the next command answers.
  void fail_next(const base::Error& error) {
    const std::lock_guard lock(mutex_);
    failure_ = error;
  }

  void set_history(json history) {
    const std::lock_guard lock(mutex_);
    history_ = std::move(history);
  }

  void set_plan(json plan) {
    const std::lock_guard lock(mutex_);
    plan_ = std::move(plan);
  }

  void set_stored(json stored) {
    const std::lock_guard lock(mutex_);
    stored_ = std::move(stored);
  }

  /// The types of units that there are.
  void set_types(json types) {
    const std::lock_guard lock(mutex_);
    types_ = std::move(types);
  }

  /// What the question for the noise of that document's unit answers.
  void set_noise(json noise) {
    const std::lock_guard lock(mutex_);
    const auto unit = noise.at("unit").get<std::string>();
    noise_[unit] = std::move(noise);
  }

  [[nodiscard]] std::size_t noise_calls() const {
    const std::lock_guard lock(mutex_);
    return noise_calls_;
  }

  [[nodiscard]] std::vector<std::string> commands() const {
    const std::lock_guard lock(mutex_);
    return commands_;
  }

  [[nodiscard]] std::size_t status_calls() const {
    const std::lock_guard lock(mutex_);
    return status_calls_;
  }

  base::Result<json> start(const StartRequest& request) override {
    const auto done = note("start " + text_of(request));
    if (!done) return base::forward_error(done);
    return json{{"campaign", request.campaign},
                {"runs", 5},
                {"steps", 240},
                {"estimate_s", 126000.0},
                {"notes", json::array()}};
  }
  base::Result<json> queue(const StartRequest& request) override {
    const auto done = note("queue " + text_of(request));
    if (!done) return base::forward_error(done);
    return json{{"campaign", request.campaign}, {"runs", 5},  {"steps", 240}, {"estimate_s", 126000.0},
                {"notes", json::array()},       {"before", 1}};
  }
  base::Result<json> check(const StartRequest& request) override {
    if (const auto done = note("check " + text_of(request)); !done) return base::forward_error(done);
    return json{{"procedure", nullptr},
                {"units", json::array()},
                {"mistakes", json::array()},
                {"notes", json::array()},
                {"disk", {{"needed_bytes", nullptr}, {"free_bytes", nullptr}}}};
  }
  base::Result<json> look(const std::string& user) override {
    if (const auto done = note("look by " + user); !done) return base::forward_error(done);
    return json::parse(R"({"slots": [{"slot": "A", "power_output": null, "answer": "identified", "serial": "SN0042",
      "product": "MTi-300", "firmware": "1.8.2", "trouble": null}]})");
  }
  base::Status unqueue(const std::string& user, const std::string& campaign) override {
    return note_and_set("unqueue " + campaign + " by " + user, "running");
  }
  base::Status next(const std::string& user, const std::string& campaign) override {
    return note_and_set("next " + campaign + " by " + user, "running");
  }
  base::Status pause(const std::string& user) override { return note_and_set("pause by " + user, "paused"); }
  base::Status resume(const std::string& user) override { return note_and_set("resume by " + user, "running"); }
  base::Status abort(const std::string& user, const std::string& reason) override {
    return note_and_set("abort by " + user + ": " + reason, "stopping");
  }
  base::Status confirm(const std::string& user, std::int64_t prompt) override {
    const auto done = note("confirm " + std::to_string(prompt) + " by " + user);
    if (done) set("/prompt", nullptr);
    if (done) set("/state", "running");
    return done;
  }

  void note(const std::string& kind, const std::string& subject, const std::string& text,
            const std::string& user) override {
    const std::lock_guard lock(mutex_);
    notes_.push_back(kind + " " + subject + ": " + text + (user.empty() ? "" : " by " + user));
  }

  /// What was entered into the event log.
  [[nodiscard]] std::vector<std::string> notes() const {
    const std::lock_guard lock(mutex_);
    return notes_;
  }

  json status() const override {
    const std::lock_guard lock(mutex_);
    ++status_calls_;
    json shown = status_;
    if (shown.is_object()) shown["alarms"] = alarms_of(shown);
    return shown;
  }
  std::uint64_t status_version() const override {
    const std::lock_guard lock(mutex_);
    return version_;
  }
  base::Result<json> plan(std::optional<std::int64_t> around) const override {
    const std::lock_guard lock(mutex_);
    if (!around || plan_.is_null()) return plan_;
    return plan_around(plan_, *around);
  }
  base::Result<json> stored() override {
    const std::lock_guard lock(mutex_);
    return stored_;
  }
  json procedures(const std::string&) const override { return {{"procedures", json::array()}}; }
  json types() const override {
    const std::lock_guard lock(mutex_);
    return {{"folder", "units"}, {"types", types_}, {"troubles", json::array()}};
  }
  json history(double after_s) const override {
    const std::lock_guard lock(mutex_);
    json answer = history_;
    answer["after_s"] = after_s;
    return answer;
  }
  base::Result<json> noise(const std::string& unit) const override {
    const std::lock_guard lock(mutex_);
    ++noise_calls_;
    const auto found = noise_.find(unit);
    if (found == noise_.end()) return base::bad_input("there is no unit '" + unit + "'", "unit");
    return found->second;
  }
  json log(std::int64_t after) const override {
    const std::lock_guard lock(mutex_);
    const auto begin = log_.begin() + std::min<std::ptrdiff_t>(after, std::ssize(log_));
    return {{"entries", std::vector<json>(begin, begin + std::min<std::ptrdiff_t>(500, log_.end() - begin))}};
  }

 private:
  static std::string text_of(const StartRequest& request) {
    std::string units;
    for (const auto& [slot, serial] : request.units) units += " " + slot + "=" + serial;
    return request.campaign + " " + request.procedure_file + " [" + request.procedure_text + "]" + units + " by " +
           request.user;
  }

  base::Status note(const std::string& command) {
    const std::lock_guard lock(mutex_);
    commands_.push_back(command);
    if (!failure_) return {};
    const base::Error error = *std::exchange(failure_, std::nullopt);
    return tl::unexpected(error);
  }

  base::Status note_and_set(const std::string& command, const std::string& state) {
    const auto done = note(command);
    if (done) set("/state", state);
    return done;
  }

  mutable std::mutex mutex_;
  json status_ = running_status();
  json plan_;
  json types_ = json::array();
  json stored_ = {{"slots", json::array()}, {"units", json::array()}, {"campaigns", json::array()}};
  json history_ = {
      {"t_s", json::array()}, {"chamber_c", json::array()}, {"set_point_c", json::array()}, {"units", json::object()}};
  std::map<std::string, json> noise_ = {{"SN0042", no_noise("SN0042")}, {"SN0043", no_noise("SN0043")}};
  mutable std::size_t noise_calls_ = 0;
  std::uint64_t version_ = 1;
  std::vector<json> log_;
  std::vector<std::string> commands_;
  std::vector<std::string> notes_;
  std::optional<base::Error> failure_;
  mutable std::size_t status_calls_ = 0;
};

}  // namespace soak::station
