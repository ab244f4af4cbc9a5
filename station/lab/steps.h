// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/result.h"
#include "station/config/plan.h"
#include "station/lab/station.h"

namespace soak::station {

enum class StepState : std::uint8_t {
  running,
  done,
  skip_visit,  ///< this plateau cannot be recorded: continue with the next one
  failed,
};

/// How a step stands. `text`: what there is to say about its end.
struct StepProgress {
  StepState state = StepState::running;
  std::string text;
  base::Error error;  ///< where it failed

  static StepProgress running() { return {}; }
  static StepProgress done(std::string text = {}) { return {StepState::done, std::move(text), {}}; }
  static StepProgress failed(base::Error error) { return {StepState::failed, error.message, std::move(error)}; }
  /// The failure of a device, at `where`.
  static StepProgress device_failed(std::string message, std::string where) {
    return failed({base::ErrorKind::device, std::move(message), std::move(where)});
  }
};

/// A step of the plan while it is carried out. Nothing happens before the first poll(); each poll() returns at once.
class StepTask {
 public:
  StepTask() = default;
  StepTask(const StepTask&) = delete;
  StepTask& operator=(const StepTask&) = delete;
  virtual ~StepTask() = default;

  [[nodiscard]] virtual StepProgress poll(Station& station) = 0;
  /// What keeps it from its end until somebody comes; empty as a rule.
  [[nodiscard]] virtual std::string trouble() const { return {}; }
};

/// The task for `step`, one of the plan's or one that the caller has changed.
[[nodiscard]] std::unique_ptr<StepTask> make_task(const Plan& plan, const Step& step);

/// The tasks by subject, one source file each (power_steps.cpp, position_steps.cpp...).
[[nodiscard]] std::unique_ptr<StepTask> make_power_task(const Plan& plan, const Step& step);
[[nodiscard]] std::unique_ptr<StepTask> make_position_task(const Step& step);
[[nodiscard]] std::unique_ptr<StepTask> make_temperature_task(const Plan& plan, const Step& step);
[[nodiscard]] std::unique_ptr<StepTask> make_record_task(const Plan& plan, const Step& step);

/// "unit A1 in slot 2 reads -Z up where +Z is expected", for each of them.
[[nodiscard]] std::string attitudes_text(const std::vector<UnitChannel*>& units);
/// The active units whose accelerometers do not confirm their position.
[[nodiscard]] std::vector<UnitChannel*> units_out_of_position(const Station& station);

/// Repeats a command to a device once a second of host time until it succeeds, for `timeout_s` of host time.
class CommandRetry {
 public:
  explicit CommandRetry(double timeout_s = 30.0) : timeout_s_(timeout_s) {}

  /// True once the command has succeeded; its error after the time-out, or at once where it is no device's.
  template <class Command>
  [[nodiscard]] base::Result<bool> attempt(Command command) {
    const auto now = std::chrono::steady_clock::now();
    if (!first_) first_ = now;
    if (last_ && now - *last_ < std::chrono::seconds(1)) return false;
    last_ = now;
    base::Status status = command();
    if (status) return true;
    const bool timed_out = std::chrono::duration<double>(now - *first_).count() > timeout_s_;
    if (timed_out || status.error().kind != base::ErrorKind::device) return base::forward_error(status);
    return false;
  }

 private:
  double timeout_s_;
  std::optional<std::chrono::steady_clock::time_point> first_;
  std::optional<std::chrono::steady_clock::time_point> last_;
};

/// How long something has been waited for. Both clocks count: with a fast simulated clock process time alone would give
/// a slow host no chance.
class WaitTimer {
 public:
  void start(const Station& station) {
    process_s_ = station.now_s();
    host_ = std::chrono::steady_clock::now();
  }
  /// Whether more than `process_limit_s` of process time and `host_limit_s` of host time have passed.
  [[nodiscard]] bool overdue(const Station& station, double process_limit_s, double host_limit_s = 20.0) const {
    const std::chrono::duration<double> host = std::chrono::steady_clock::now() - host_;
    return station.now_s() - process_s_ > process_limit_s && host.count() > host_limit_s;
  }

 private:
  double process_s_ = 0.0;
  std::chrono::steady_clock::time_point host_{};
};

}  // namespace soak::station
