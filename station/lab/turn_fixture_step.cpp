// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>

#include "station/lab/step_task.h"

namespace soak::station {
namespace {

/// Asks the operator to turn the whole fixture about the vertical: nothing of ours moves it, and no accelerometer sees
/// it.
class TurnFixture : public StepTask {
 public:
  explicit TurnFixture(const Step& step) : heading_deg_(step.heading_deg) {}

  StepProgress poll(Lab& lab) override {
    if (!asked_) {
      lab.prompts.ask(heading_deg_ == 0.0
                          ? std::string("Turn the whole fixture back to its usual heading, then confirm.")
                          : fmt::format("Turn the whole fixture by {:g}° {} (seen from above) from its usual heading, "
                                        "then confirm.",
                                        std::abs(heading_deg_), heading_deg_ > 0.0 ? "clockwise" : "anticlockwise"));
      asked_ = true;
      return StepProgress::running();
    }
    if (!lab.prompts.take_answer()) return StepProgress::running();
    return StepProgress::done(fmt::format("the fixture stands {:+g}° from its usual heading", heading_deg_));
  }

 private:
  double heading_deg_;
  bool asked_ = false;
};

}  // namespace

std::unique_ptr<StepTask> make_turn_fixture(const Step& step) { return std::make_unique<TurnFixture>(step); }

}  // namespace soak::station
