// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iterator>
#include <vector>

#include "station/lab/step_task.h"

namespace soak::station {
namespace {

constexpr double kLongest_s = 120.0;      ///< process time until the fixture is steady, and until the units say so
constexpr double kAskEvery_s = 0.2;       ///< process time
constexpr double kHostPatience_s = 20.0;  ///< beside both: a fast clock gives a slow host no chance otherwise
constexpr double kSteadyShare = 0.01;     ///< of the asked rate, that the fixture's own may be off
constexpr double kSteady_dps = 0.5;

using std::chrono::steady_clock;

/// Turns the fixture at a rate and waits until the units' own gyros say so; at rate 0 halts it.
class Spin : public StepTask {
 public:
  explicit Spin(const Step& step) : position_(step.position), rate_dps_(step.rate_dps) {}

  StepProgress poll(Lab& lab) override {
    switch (stage_) {
      case Stage::begin:
        lab.set_moving(true);
        enter(lab, Stage::command);
        return StepProgress::running();
      case Stage::command:
        return command(lab);
      case Stage::fixture:
        return wait_for_fixture(lab);
      case Stage::units:
        return wait_for_units(lab);
    }
    return StepProgress::running();
  }

 private:
  enum class Stage { begin, command, fixture, units };

  void enter(Lab& lab, Stage stage) {
    stage_ = stage;
    since_s_ = lab.now_s();
    since_host_ = steady_clock::now();
  }

  [[nodiscard]] bool overdue(const Lab& lab) const {
    return lab.now_s() - since_s_ > kLongest_s &&
           std::chrono::duration<double>(steady_clock::now() - since_host_).count() > kHostPatience_s;
  }

  StepProgress command(Lab& lab) {
    const auto sent = insistence_.attempt(
        [&] { return rate_dps_ == 0.0 ? lab.fixture->halt() : lab.fixture->spin(position_, rate_dps_); });
    if (!sent) return StepProgress::failed(sent.error());
    if (*sent) enter(lab, Stage::fixture);
    return StepProgress::running();
  }

  [[nodiscard]] bool is_there(const hal::FixtureReading& reading) const {
    if (rate_dps_ == 0.0) return !reading.moving;
    return reading.rate_dps &&
           std::abs(*reading.rate_dps - rate_dps_) <= kSteady_dps + kSteadyShare * std::abs(rate_dps_);
  }

  StepProgress wait_for_fixture(Lab& lab) {
    if (lab.now_s() - asked_s_ < kAskEvery_s) return StepProgress::running();
    asked_s_ = lab.now_s();
    const auto reading = lab.ask_fixture();
    if (reading && is_there(*reading)) {
      if (rate_dps_ == 0.0) return StepProgress::done();
      for (const auto& unit : lab.units) unit->expect_rate(rate_dps_);
      enter(lab, Stage::units);
      return StepProgress::running();
    }
    if (!overdue(lab)) return StepProgress::running();
    return StepProgress::failed(
        {base::ErrorKind::device,
         reading ? fmt::format("the fixture did not come to {:g} deg/s (it says: {})", rate_dps_, reading->angles)
                 : reading.error().message,
         lab.fixture->description()});
  }

  StepProgress wait_for_units(Lab& lab) {
    const auto active = lab.active_units();
    std::vector<UnitChannel*> wrong;
    std::ranges::copy_if(active, std::back_inserter(wrong),
                         [](const UnitChannel* unit) { return !unit->rate().right(); });
    if (wrong.empty()) {
      lab.set_moving(false, rate_dps_);
      return StepProgress::done();
    }
    if (!overdue(lab)) return StepProgress::running();
    if (wrong.size() < active.size()) {
      for (UnitChannel* unit : wrong) lab.lose(*unit, describe(*unit));
      return StepProgress::running();
    }
    std::string text;
    for (const UnitChannel* unit : wrong) text += (text.empty() ? "" : "; ") + describe(*unit);
    return StepProgress::failed({base::ErrorKind::device, text + ": the fixture does not turn as it says",
                                 fmt::format("position {}, {:g} deg/s", position_, rate_dps_)});
  }

  [[nodiscard]] std::string describe(const UnitChannel& unit) const {
    const auto seen = unit.rate().seen_dps();
    return fmt::format("unit {} in slot {} turns at {} about its {} where {:g} deg/s is expected", unit.serial(),
                       unit.slot().name, seen ? fmt::format("{:.1f} deg/s", *seen) : "no known rate",
                       unit.position().label, rate_dps_);
  }

  std::string position_;
  double rate_dps_;
  Stage stage_ = Stage::begin;
  double since_s_ = 0.0;
  double asked_s_ = 0.0;
  steady_clock::time_point since_host_{};
  Insistence insistence_;
};

}  // namespace

std::unique_ptr<StepTask> make_spin(const Step& step) { return std::make_unique<Spin>(step); }

}  // namespace soak::station
