// SPDX-License-Identifier: Apache-2.0
// Steps that bring the units into a position or to a rate, proved by the units' own sensors.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <vector>

#include "station/lab/steps.h"

namespace soak::station {
namespace {

// Process time.
constexpr double kTurnLimit_s = 180.0;    ///< until the fixture stands in its position
constexpr double kSettleLimit_s = 120.0;  ///< from then on, until the units confirm it
constexpr double kSpinLimit_s = 120.0;    ///< until the fixture's rate is steady, and until the units confirm it
constexpr double kFixturePoll_s = 0.2;
/// Until a unit that rests in a wrong position is told of; a fixture may still creep to its end.
constexpr double kTellWrong_s = 10.0;

constexpr double kRateShare = 0.01;  ///< of the commanded rate, by which the fixture's own reading may differ
constexpr double kRate_dps = 0.5;

/// Asks the operator to turn the whole fixture about the vertical: nothing of ours moves it, and no accelerometer sees
/// it.
class TurnFixture : public StepTask {
 public:
  explicit TurnFixture(const Step& step) : heading_deg_(step.heading_deg) {}

  StepProgress poll(Station& station) override {
    if (!asked_) {
      const std::string text =
          heading_deg_ == 0.0
              ? std::string("Turn the whole fixture back to its usual heading, then confirm.")
              : fmt::format(
                    "Turn the whole fixture by {:g}° {} (seen from above) from its usual heading, then confirm.",
                    std::abs(heading_deg_), heading_deg_ > 0.0 ? "clockwise" : "counter-clockwise");
      station.prompts.ask({text, "heading", {{"heading_deg", heading_deg_}}});
      asked_ = true;
      return StepProgress::running();
    }
    if (!station.prompts.take_answer()) return StepProgress::running();
    return StepProgress::done(fmt::format("the fixture is turned by {:+g}° from its usual heading", heading_deg_));
  }

 private:
  double heading_deg_;
  bool asked_ = false;
};

/// Turns the fixture and waits until the units' own accelerometers confirm that they are at rest in the position.
class Move : public StepTask {
 public:
  explicit Move(const Step& step) : position_(step.position), run_(step.run) {}

  StepProgress poll(Station& station) override {
    switch (stage_) {
      case Stage::begin:
        return begin(station);
      case Stage::command:
        return command(station);
      case Stage::by_hand:
        return by_hand(station);
      case Stage::turn:
        return wait_for_fixture(station);
      case Stage::settle:
        return wait_for_units(station);
    }
    return StepProgress::running();
  }

 private:
  enum class Stage { begin, command, by_hand, turn, settle };

  StepProgress enter(const Station& station, Stage stage) {
    stage_ = stage;
    timer_.start(station);
    return StepProgress::running();
  }

  StepProgress begin(Station& station) {
    station.set_moving(true);
    for (const auto& unit : station.units) unit->expect_position(position_);
    return station.fixture ? enter(station, Stage::command) : ask(station, {});
  }

  /// `wrong`: units that do not rest as it was confirmed last.
  StepProgress ask(Station& station, const std::vector<UnitChannel*>& wrong) {
    std::vector<std::string> serials;
    for (const UnitChannel* unit : wrong) serials.push_back(unit->serial());
    const std::string why = wrong.empty() ? "" : attitudes_text(wrong) + ". ";
    if (!wrong.empty()) station.log.add("position", position_, attitudes_text(wrong) + ": asked again");
    station.prompts.ask({fmt::format("{}Turn the fixture so that its {} points up, then confirm.", why, position_),
                         "position",
                         {{"position", position_}, {"wrong", serials}}});
    return enter(station, Stage::by_hand);
  }

  StepProgress command(Station& station) {
    const auto sent = retry_.attempt([&] { return station.fixture->move_to(position_); });
    if (!sent) return StepProgress::failed(sent.error());
    return *sent ? enter(station, Stage::turn) : StepProgress::running();
  }

  StepProgress by_hand(Station& station) {
    if (!station.prompts.take_answer()) return StepProgress::running();
    for (const auto& unit : station.units) unit->expect_position(position_);
    return enter(station, Stage::settle);
  }

  StepProgress wait_for_fixture(Station& station) {
    if (station.now_s() - polled_s_ < kFixturePoll_s) return StepProgress::running();
    polled_s_ = station.now_s();
    const auto reading = station.read_fixture();
    if (reading && !reading->moving && reading->position == position_) return enter(station, Stage::settle);
    if (!timer_.overdue(station, kTurnLimit_s)) return StepProgress::running();
    return StepProgress::device_failed(
        reading ? fmt::format("the fixture did not reach {} (it reports: {}{}{})", position_,
                              reading->position.value_or("no position"), reading->moving ? ", moving" : "",
                              reading->angles.empty() ? "" : "; " + reading->angles)
                : reading.error().message,
        station.fixture->description());
  }

  StepProgress wait_for_units(Station& station) {
    const std::vector<UnitChannel*> wrong = units_out_of_position(station);
    if (wrong.empty()) {
      station.set_moving(false);
      for (UnitChannel* unit : station.active_units()) unit->disturb(station.procedure().stability.after_turn_s);
      return StepProgress::done();
    }
    // Whoever turned it stands beside it: a unit at rest with a wrong face up is told at once.
    const std::vector<UnitChannel*> at_rest = at_rest_in_another(wrong);
    if (!station.fixture && !at_rest.empty()) return ask(station, at_rest);
    if (!told_ && !at_rest.empty() && timer_.overdue(station, kTellWrong_s, 0.0)) {
      told_ = true;
      station.log.add("position", position_, attitudes_text(at_rest) + ": waiting for it");
    }
    if (!timer_.overdue(station, kSettleLimit_s)) return StepProgress::running();
    if (!station.fixture) return ask(station, wrong);
    // The pre-flight finds what is mounted wrongly. Later it is the unit that fails, if the others confirm the
    // position.
    const bool preflight = station.campaign.plan.runs[static_cast<std::size_t>(run_)].preflight;
    if (!preflight && wrong.size() < station.active_units().size()) {
      for (UnitChannel* unit : wrong) station.lose(*unit, attitudes_text({unit}));
      return StepProgress::running();
    }
    return StepProgress::device_failed(attitudes_text(wrong) +
                                           ": either the unit is not mounted as the station's configuration says (slot "
                                           "axes), or the fixture is not where it reports to be",
                                       "position " + position_);
  }

  static std::vector<UnitChannel*> at_rest_in_another(std::vector<UnitChannel*> units) {
    std::erase_if(units, [](const UnitChannel* unit) { return unit->attitude().state() != Attitude::wrong; });
    return units;
  }

  std::string position_;
  int run_;
  bool told_ = false;  ///< that a unit rests in a wrong position
  Stage stage_ = Stage::begin;
  WaitTimer timer_;
  double polled_s_ = 0.0;
  CommandRetry retry_;
};

/// Turns the fixture at a rate and waits until the units' own gyros confirm it; at rate 0 halts it.
class Spin : public StepTask {
 public:
  explicit Spin(const Step& step) : position_(step.position), rate_dps_(step.rate_dps) {}

  StepProgress poll(Station& station) override {
    switch (stage_) {
      case Stage::begin:
        station.set_moving(true);
        return enter(station, Stage::command);
      case Stage::command:
        return command(station);
      case Stage::fixture:
        return wait_for_fixture(station);
      case Stage::units:
        return wait_for_units(station);
    }
    return StepProgress::running();
  }

 private:
  enum class Stage { begin, command, fixture, units };

  StepProgress enter(const Station& station, Stage stage) {
    stage_ = stage;
    timer_.start(station);
    return StepProgress::running();
  }

  StepProgress command(Station& station) {
    const auto sent = retry_.attempt(
        [&] { return rate_dps_ == 0.0 ? station.fixture->halt() : station.fixture->spin(position_, rate_dps_); });
    if (!sent) return StepProgress::failed(sent.error());
    return *sent ? enter(station, Stage::fixture) : StepProgress::running();
  }

  [[nodiscard]] bool is_there(const hal::FixtureReading& reading) const {
    if (rate_dps_ == 0.0) return !reading.moving;
    return reading.rate_dps && std::abs(*reading.rate_dps - rate_dps_) <= kRate_dps + kRateShare * std::abs(rate_dps_);
  }

  StepProgress wait_for_fixture(Station& station) {
    if (station.now_s() - polled_s_ < kFixturePoll_s) return StepProgress::running();
    polled_s_ = station.now_s();
    const auto reading = station.read_fixture();
    if (reading && is_there(*reading)) {
      if (rate_dps_ == 0.0) return StepProgress::done();
      for (const auto& unit : station.units) unit->expect_rate(rate_dps_);
      return enter(station, Stage::units);
    }
    if (!timer_.overdue(station, kSpinLimit_s)) return StepProgress::running();
    return StepProgress::device_failed(
        reading ? fmt::format("the fixture did not reach {:g} deg/s (it reports: {})", rate_dps_, reading->angles)
                : reading.error().message,
        station.fixture->description());
  }

  StepProgress wait_for_units(Station& station) {
    const auto active = station.active_units();
    std::vector<UnitChannel*> wrong;
    std::ranges::copy_if(active, std::back_inserter(wrong),
                         [](const UnitChannel* unit) { return !unit->rate().right(); });
    if (wrong.empty()) {
      station.set_moving(false, rate_dps_);
      return StepProgress::done();
    }
    if (!timer_.overdue(station, kSpinLimit_s)) return StepProgress::running();
    if (wrong.size() < active.size()) {
      for (UnitChannel* unit : wrong) station.lose(*unit, text_of(*unit));
      return StepProgress::running();
    }
    std::string text;
    for (const UnitChannel* unit : wrong) text += (text.empty() ? "" : "; ") + text_of(*unit);
    return StepProgress::device_failed(text + ": the fixture does not turn at the rate that it reports",
                                       fmt::format("position {}, {:g} deg/s", position_, rate_dps_));
  }

  [[nodiscard]] std::string text_of(const UnitChannel& unit) const {
    const auto measured = unit.rate().measured_dps();
    return fmt::format("unit {} in slot {} measures {} about its {} where {:g} deg/s is expected", unit.serial(),
                       unit.slot().name, measured ? fmt::format("{:.1f} deg/s", *measured) : "no steady rate",
                       unit.position().label, rate_dps_);
  }

  std::string position_;
  double rate_dps_;
  Stage stage_ = Stage::begin;
  WaitTimer timer_;
  double polled_s_ = 0.0;
  CommandRetry retry_;
};

}  // namespace

std::string attitudes_text(const std::vector<UnitChannel*>& units) {
  std::string text;
  for (const UnitChannel* unit : units) {
    const std::string up = unit->attitude().up_axis();
    const std::string& expected = unit->position().label;
    text += fmt::format("{}unit {} in slot {} reads ", text.empty() ? "" : "; ", unit->serial(), unit->slot().name);
    // The face up is the axis nearest to the vertical: it may be the right one and lean all the same.
    text += up == expected ? fmt::format("{} up, but is tilted, or does not read gravity", up)
                           : fmt::format("{} up where {} is expected", up, expected);
  }
  return text;
}

std::vector<UnitChannel*> units_out_of_position(const Station& station) {
  std::vector<UnitChannel*> wrong = station.active_units();
  std::erase_if(wrong, [](const UnitChannel* unit) { return unit->attitude().state() == Attitude::right; });
  return wrong;
}

std::unique_ptr<StepTask> make_position_task(const Step& step) {
  if (step.kind == StepKind::turn_fixture) return std::make_unique<TurnFixture>(step);
  if (step.kind == StepKind::spin) return std::make_unique<Spin>(step);
  return std::make_unique<Move>(step);
}

}  // namespace soak::station
