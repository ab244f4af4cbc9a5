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
#include "station/lab/lab.h"

namespace soak::station {

enum class StepState : std::uint8_t {
  running,
  done,
  skip_visit,  ///< the plateau cannot be had: go on with the next one
  failed,
};

/// How a step stands. `text`: what there is to say of its end.
struct StepProgress {
  StepState state = StepState::running;
  std::string text;
  base::Error error;  ///< where it failed

  static StepProgress running() { return {}; }
  static StepProgress done(std::string text = {}) { return {StepState::done, std::move(text), {}}; }
  static StepProgress failed(base::Error error) { return {StepState::failed, error.message, std::move(error)}; }
};

/// A step of the plan while it is carried out. Nothing happens before the first poll(); each poll() returns at once.
class StepTask {
 public:
  StepTask() = default;
  StepTask(const StepTask&) = delete;
  StepTask& operator=(const StepTask&) = delete;
  virtual ~StepTask() = default;

  [[nodiscard]] virtual StepProgress poll(Lab& lab) = 0;
};

[[nodiscard]] std::unique_ptr<StepTask> make_task(const Plan& plan, std::size_t step);

/// What each kind of step does; one source file each.
[[nodiscard]] std::unique_ptr<StepTask> make_turn_fixture(const Step& step);
[[nodiscard]] std::unique_ptr<StepTask> make_power_on(const Plan& plan, const Step& step);
[[nodiscard]] std::unique_ptr<StepTask> make_move(const Step& step);
[[nodiscard]] std::unique_ptr<StepTask> make_spin(const Step& step);
[[nodiscard]] std::unique_ptr<StepTask> make_set_temperature(const Plan& plan, const Step& step);
[[nodiscard]] std::unique_ptr<StepTask> make_wait_stable(const Plan& plan, const Step& step);
[[nodiscard]] std::unique_ptr<StepTask> make_record(const Plan& plan, const Step& step);
[[nodiscard]] std::unique_ptr<StepTask> make_check();
[[nodiscard]] std::unique_ptr<StepTask> make_warm_end(const Step& step);
[[nodiscard]] std::unique_ptr<StepTask> make_power_off(const Step& step);

/// "unit A1 in slot 2 reads -Z up where +Z is expected", for each of them.
[[nodiscard]] std::string attitudes_text(const std::vector<UnitChannel*>& units);
/// Those of the active units whose accelerometers do not say that they stand as they should.
[[nodiscard]] std::vector<UnitChannel*> units_out_of_position(const Lab& lab);

/// Tries a command to a device again and again, once a second of host time, for `patience_s` of host time.
class Insistence {
 public:
  explicit Insistence(double patience_s = 30.0) : patience_s_(patience_s) {}

  /// True once the command has succeeded; an error when patience has ended.
  template <class Command>
  [[nodiscard]] base::Result<bool> attempt(Command command) {
    const auto now = std::chrono::steady_clock::now();
    if (!first_) first_ = now;
    if (last_ && now - *last_ < std::chrono::seconds(1)) return false;
    last_ = now;
    base::Status status = command();
    if (status) return true;
    if (status.error().kind != base::ErrorKind::device) return base::forward_error(status);
    if (std::chrono::duration<double>(now - *first_).count() > patience_s_) return base::forward_error(status);
    return false;
  }

 private:
  double patience_s_;
  std::optional<std::chrono::steady_clock::time_point> first_;
  std::optional<std::chrono::steady_clock::time_point> last_;
};

}  // namespace soak::station
