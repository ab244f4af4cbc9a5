// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <vector>

#include "station/lab/step_task.h"

namespace soak::station {
namespace {

constexpr double kLongestTurn_s = 180.0;    ///< process time
constexpr double kLongestSettle_s = 120.0;  ///< process time after the fixture stands
constexpr double kAskEvery_s = 0.2;         ///< process time
constexpr double kHostPatience_s = 20.0;    ///< beside both: a fast clock gives a slow host no chance otherwise

using std::chrono::steady_clock;

/// Turns the fixture and waits until the units' own accelerometers say that they have come to rest as they should.
class Move : public StepTask {
 public:
  explicit Move(const Step& step) : position_(step.position), run_(step.run) {}

  StepProgress poll(Lab& lab) override {
    switch (stage_) {
      case Stage::begin:
        return begin(lab);
      case Stage::command:
        return command(lab);
      case Stage::by_hand:
        return by_hand(lab);
      case Stage::turn:
        return turn(lab);
      case Stage::settle:
        return settle(lab);
    }
    return StepProgress::running();
  }

 private:
  enum class Stage { begin, command, by_hand, turn, settle };

  void enter(Lab& lab, Stage stage) {
    stage_ = stage;
    since_s_ = lab.now_s();
    since_host_ = steady_clock::now();
  }

  [[nodiscard]] bool overdue(const Lab& lab, double limit_s) const {
    return lab.now_s() - since_s_ > limit_s &&
           std::chrono::duration<double>(steady_clock::now() - since_host_).count() > kHostPatience_s;
  }

  StepProgress begin(Lab& lab) {
    lab.set_moving(true);
    for (const auto& unit : lab.units) unit->expect_position(position_);
    if (lab.fixture) {
      enter(lab, Stage::command);
    } else {
      ask(lab, "");
    }
    return StepProgress::running();
  }

  void ask(Lab& lab, const std::string& why) {
    lab.prompts.ask(fmt::format("{}Turn the fixture so that its {} points up, then confirm.", why, position_));
    enter(lab, Stage::by_hand);
  }

  StepProgress command(Lab& lab) {
    const auto sent = insistence_.attempt([&] { return lab.fixture->move_to(position_); });
    if (!sent) return StepProgress::failed(sent.error());
    if (*sent) enter(lab, Stage::turn);
    return StepProgress::running();
  }

  StepProgress by_hand(Lab& lab) {
    if (lab.prompts.take_answer()) {
      for (const auto& unit : lab.units) unit->expect_position(position_);
      enter(lab, Stage::settle);
    }
    return StepProgress::running();
  }

  StepProgress turn(Lab& lab) {
    if (lab.now_s() - asked_s_ < kAskEvery_s) return StepProgress::running();
    asked_s_ = lab.now_s();
    const auto reading = lab.ask_fixture();
    const bool there = reading && !reading->moving && reading->position == position_;
    if (there) enter(lab, Stage::settle);
    if (there || !overdue(lab, kLongestTurn_s)) return StepProgress::running();
    return StepProgress::failed(
        {base::ErrorKind::device,
         reading ? fmt::format("the fixture did not come to {} (it says: {}{}{})", position_,
                               reading->position.value_or("no position"), reading->moving ? ", moving" : "",
                               reading->angles.empty() ? "" : "; " + reading->angles)
                 : reading.error().message,
         lab.fixture->description()});
  }

  StepProgress settle(Lab& lab) {
    const std::vector<UnitChannel*> wrong = units_out_of_position(lab);
    if (wrong.empty()) {
      lab.set_moving(false);
      for (UnitChannel* unit : lab.active_units()) unit->disturb(lab.procedure().stability.after_turn_s);
      return StepProgress::done();
    }
    if (!overdue(lab, kLongestSettle_s)) return StepProgress::running();
    if (!lab.fixture) {
      ask(lab, attitudes_text(wrong) + ". ");
      return StepProgress::running();
    }
    // The pre-flight finds what is mounted wrongly. Later it is the unit that fails, if others stand as they should.
    const bool preflight = lab.campaign.plan.runs[static_cast<std::size_t>(run_)].preflight;
    if (!preflight && wrong.size() < lab.active_units().size()) {
      for (UnitChannel* unit : wrong) lab.lose(*unit, attitudes_text({unit}));
      return StepProgress::running();
    }
    return StepProgress::failed({base::ErrorKind::device,
                                 attitudes_text(wrong) +
                                     ": mounted otherwise than the station's configuration says (slot axes), or the "
                                     "fixture does not stand as it says",
                                 "position " + position_});
  }

  std::string position_;
  int run_;
  Stage stage_ = Stage::begin;
  double since_s_ = 0.0;
  double asked_s_ = 0.0;
  steady_clock::time_point since_host_{};
  Insistence insistence_;
};

}  // namespace

std::unique_ptr<StepTask> make_move(const Step& step) { return std::make_unique<Move>(step); }

}  // namespace soak::station
