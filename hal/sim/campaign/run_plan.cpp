// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/campaign/run_plan.h"

#include <algorithm>
#include <cmath>

namespace soak::hal::sim {
namespace {

/// `count` set points up from `first_c`, and down again without the turning one.
std::vector<SetPoint> up_and_down(double first_c, double step_c, int count) {
  std::vector<SetPoint> points;
  points.reserve(2 * static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) points.push_back({first_c + step_c * i, calib::Sweep::up});
  for (int i = count - 2; i >= 0; --i) points.push_back({first_c + step_c * i, calib::Sweep::down});
  return points;
}

int step_count(const CampaignConfig& config) {
  return static_cast<int>(std::lround((config.turn_c - config.start_c) / config.step_c));
}

/// Appends rows to a plan and keeps the time.
class Planner {
 public:
  Planner(const CampaignConfig& config, RunPlan& plan) : config_(config), plan_(plan) {}

  void add_visit(const SetPoint& set_point) {
    Visit visit{set_point, t_s_, t_s_, t_s_};
    if (!plan_.visits.empty()) {
      add_ramp();
      visit.t_soak_s = t_s_;
    }
    for (std::size_t i = 0; i < plan_.positions.size(); ++i) {
      if (i > 0) add_turn(plan_.positions[i - 1], plan_.positions[i]);
      add_segment(i);
    }
    visit.t_end_s = t_s_ - config_.row_interval_s;
    plan_.visits.push_back(visit);
  }

 private:
  void add_row(double t_s, calib::Phase phase, std::int32_t position, const Attitude& attitude) {
    plan_.rows.push_back({t_s, plan_.visits.size(), phase, position, attitude});
  }

  void add_ramp() {
    const Attitude attitude = resting(plan_.positions[0], config_.earth);
    for (int i = 0; i < config_.ramp_rows; ++i) {
      add_row(t_s_ + config_.ramp_s * i / config_.ramp_rows, calib::Phase::ramp, -1, attitude);
    }
    t_s_ += config_.ramp_s;
  }

  void add_turn(const calib::Position& from, const calib::Position& to) {
    const int steps = config_.moving_rows + 1;
    for (int i = 1; i < steps; ++i) {
      const double fraction = static_cast<double>(i) / steps;
      add_row(t_s_, calib::Phase::soak, -1, turning(from, to, fraction, steps * config_.row_interval_s));
      t_s_ += config_.row_interval_s;
    }
  }

  void add_segment(std::size_t position) {
    const Attitude attitude = resting(plan_.positions[position], config_.earth);
    for (int i = 0; i < config_.rows_per_position; ++i) {
      add_row(t_s_, calib::Phase::soak, static_cast<std::int32_t>(position), attitude);
      t_s_ += config_.row_interval_s;
    }
  }

  const CampaignConfig& config_;
  RunPlan& plan_;
  double t_s_ = 0.0;
};

}  // namespace

std::vector<SetPoint> campaign_set_points(const CampaignConfig& config) {
  return up_and_down(config.start_c, config.step_c, step_count(config) + 1);
}

std::vector<SetPoint> verification_set_points(const CampaignConfig& config) {
  return up_and_down(config.start_c + 0.5 * config.step_c, config.step_c, step_count(config));
}

std::array<calib::Position, 6> position_order(int run) {
  std::array<calib::Position, 6> order;
  const auto first = static_cast<std::size_t>(run % 3) * 2;
  for (std::size_t i = 0; i < order.size(); ++i) {
    order[i] = calib::position_named(calib::kSixPositionLabels[(first + i) % 6]).value_or(calib::Position{});
  }
  if (run % 2 != 0) std::reverse(order.begin(), order.end());
  return order;
}

RunPlan plan_run(const CampaignConfig& config, const std::vector<SetPoint>& set_points, int run) {
  RunPlan plan;
  plan.positions = position_order(run);
  Planner planner(config, plan);
  for (const SetPoint& set_point : set_points) planner.add_visit(set_point);
  return plan;
}

}  // namespace soak::hal::sim
