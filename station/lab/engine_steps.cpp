// SPDX-License-Identifier: Apache-2.0
// The engine's way from step to step: what is kept of each in the journal, and what a break repeats.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "station/io/host.h"
#include "station/lab/engine.h"

namespace soak::station {
namespace {

/// Steps that stand on a judgement of temperature and position, which a break makes void.
bool stands_on_judgement(StepKind kind) {
  return kind == StepKind::move || kind == StepKind::spin || kind == StepKind::set_temperature ||
         kind == StepKind::wait_stable || kind == StepKind::record;
}

}  // namespace

void Engine::enter_step(std::size_t step) {
  step_ = step;
  step_started_utc_s_ = now_utc_s();
  step_started_s_ = lab_->now_s();
  lab_->prompts.withdraw();
  task_ = new_task(step);
  published_ = {};
}

std::unique_ptr<StepTask> Engine::new_task(std::size_t index) {
  const Plan& plan = lab_->campaign.plan;
  if (!settle_fully_ || plan.steps[index].kind != StepKind::wait_stable) return make_task(plan, index);
  settle_fully_ = false;
  Step step = plan.steps[index];
  step.after_turn = false;
  return make_wait_stable(plan, step);
}

void Engine::step_ended(const StepProgress& progress) {
  const Plan& plan = lab_->campaign.plan;
  if (progress.state == StepState::failed) {
    log_.add("step", describe(plan, step_), "failed: " + progress.text);
    persist_step("failed", progress.text);
    end_campaign(LabState::failed,
                 progress.error.where.empty() ? progress.text : progress.error.where + ": " + progress.text);
    return;
  }
  if (!progress.text.empty()) log_.add("step", describe(plan, step_), progress.text);
  const bool skip = progress.state == StepState::skip_visit;
  if (!persist_step(skip ? "skipped" : "done", progress.text)) return;
  std::size_t next = step_ + 1;
  if (skip) {
    const Step& here = plan.steps[step_];
    while (next < plan.steps.size() && plan.steps[next].run == here.run && plan.steps[next].visit == here.visit) ++next;
  }
  if (next < plan.steps.size()) {
    enter_step(next);
  } else {
    task_.reset();
    step_ = plan.steps.size();
    const auto& losses = lab_->campaign.losses;
    set_state(LabState::finished, losses.empty() ? "" : fmt::format("without {}", fmt::join(losses, ", ")));
  }
}

bool Engine::persist_step(const std::string& outcome, const std::string& text) {
  db::StepRow row;
  row.campaign = lab_->campaign.name;
  row.index = static_cast<std::int32_t>(step_);
  row.attempt = step_attempts_[step_]++;
  row.started_utc_s = step_started_utc_s_;
  row.ended_utc_s = now_utc_s();
  row.outcome = outcome;
  row.text = text;
  row.run_id = lab_->run_id();
  const auto kept = catalog_.complete_step(row);
  if (!kept) end_campaign(LabState::failed, "the journal cannot be written: " + kept.error().message);
  return kept.has_value();
}

void Engine::repeat_step(const std::string& why) {
  const Plan& plan = lab_->campaign.plan;
  lab_->break_segment(why);
  if (!stands_on_judgement(plan.steps[step_].kind)) return;
  std::size_t step = step_;
  const auto same_visit = [&](std::size_t other) {
    return plan.steps[other].run == plan.steps[step].run && plan.steps[other].visit == plan.steps[step].visit;
  };
  while (step > 0 && plan.steps[step].kind != StepKind::move && same_visit(step - 1) &&
         stands_on_judgement(plan.steps[step - 1].kind)) {
    --step;
  }
  settle_fully_ = plan.steps[step_].visit >= 0;
  enter_step(step);
}

}  // namespace soak::station
