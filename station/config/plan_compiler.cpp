// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "calib/vocabulary/position.h"
#include "station/config/plan.h"

namespace soak::station {
namespace {

constexpr double kTurn_s = 10.0;
constexpr double kByHand_s = 300.0;
constexpr double kSecondsPerMinute = 60.0;

calib::Sweep sweep_of(double from_c, double to_c, calib::Sweep before) {
  if (to_c > from_c) return calib::Sweep::up;
  return to_c < from_c ? calib::Sweep::down : before;
}

char label_letter(Purpose purpose) {
  switch (purpose) {
    case Purpose::calibration:
      return 'R';
    case Purpose::verification:
      return 'V';
    case Purpose::diagnosis:
      return 'D';
  }
  return 'R';
}

int rotation_of_run(PositionChange change, int run) {
  switch (change) {
    case PositionChange::rotate:
      return run;
    case PositionChange::rotate_and_reverse:
      return run / 2;
    case PositionChange::same:
    case PositionChange::reverse:
      return 0;
  }
  return 0;
}

bool is_reversed(PositionChange change, int run) {
  const bool reverses = change == PositionChange::reverse || change == PositionChange::rotate_and_reverse;
  return reverses && run % 2 == 1;
}

/// Where each axis begins in the order.
std::vector<std::size_t> axis_begins(const std::vector<std::string>& order) {
  std::vector<std::size_t> begins;
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (i == 0 || order[i].back() != order[i - 1].back()) begins.push_back(i);
  }
  return begins;
}

class Compiler {
 public:
  Compiler(const Procedure& procedure, double room_c) : room_c_(room_c), air_c_(room_c) { plan_.procedure = procedure; }

  Plan compile() {
    if (procedure().preflight_position_s > 0.0) add_preflight();
    for (int pass = 0; pass < procedure().runs; ++pass) add_pass(pass);
    plan_.steps.back().seconds = 0.0;  // nothing follows: no need to stay off
    plan_.steps.back().estimate_s = 0.0;
    if (procedure().turned_deg != 0.0) turn_fixture(0.0);
    return std::move(plan_);
  }

 private:
  [[nodiscard]] const Procedure& procedure() const { return plan_.procedure; }

  void add_preflight() {
    begin_run("P00", true);
    for (const std::string_view position : calib::kSixPositionLabels) {
      move_to(std::string(position));
      record(procedure().preflight_position_s);
    }
    add(StepKind::check);
    power_off();
  }

  /// Once over all set points: one run, or with power cycles one more than there are of them.
  void add_pass(int number) {
    begin_run(next_label(), false);
    const auto order = positions_of_run(procedure(), number);
    const auto& set_points_c = procedure().set_points_c;
    for (std::size_t k = 0; k < set_points_c.size(); ++k) {
      add_visit(set_points_c[k], order);
      if (procedure().cycle_at_visit != static_cast<int>(k)) continue;
      for (int cycle = 0; cycle < procedure().cycles; ++cycle) {
        cycle_power();
        add_visit(set_points_c[k], order);
      }
    }
    end_visits();
    warm_end();
    power_off();
  }

  void add_visit(double temp_c, const std::vector<std::string>& order) {
    begin_visit(temp_c);
    if (visit_ == 0 || position_ != order.front()) move_to(order.front());
    set_temperature();
    if (procedure().kind != ProcedureKind::ramp) visit_positions(order);
    visit_rates();
  }

  /// The chamber stays where it is; the visit that follows at this set point keeps its sweep.
  void cycle_power() {
    const double set_point_c = set_point_c_;
    const calib::Sweep sweep = sweep_;
    end_visits();
    power_off();
    begin_run(next_label(), false);
    set_point_c_ = set_point_c;
    sweep_ = sweep;
  }

  std::string next_label() { return fmt::format("{}{:02}", label_letter(procedure().purpose), ++labels_); }

  void visit_positions(const std::vector<std::string>& order) {
    for (const std::string& position : order) {
      const bool turned = position != position_;
      if (turned) move_to(position);
      wait_stable(turned);
      record(procedure().dwell_s);
    }
  }

  /// Each begins with a turn, also where the fixture stands there already: a break goes back to it, not farther.
  void visit_rates() {
    for (const std::string& position : procedure().rate_positions) {
      move_to(position);
      wait_stable(true);
      for (const double rate_dps : procedure().rates_dps) {
        spin(rate_dps);
        record(procedure().rate_dwell_s);
        plan_.steps.back().rate_dps = rate_dps;
      }
      spin(0.0);
      position_.clear();  // it comes to rest wherever it does
    }
  }

  void begin_run(std::string label, bool preflight) {
    end_visits();
    position_.clear();
    plan_.runs.push_back({std::move(label), preflight, plan_.steps.size(), plan_.steps.size()});
    if (plan_.runs.size() == 1 && procedure().turned_deg != 0.0) turn_fixture(procedure().turned_deg);
    Step& step = add(StepKind::power_on);
    step.seconds = procedure().warm_up_s;
    step.estimate_s = procedure().warm_up_s;
  }

  void begin_visit(double temp_c) {
    ++visit_;
    sweep_ = sweep_of(set_point_c_, temp_c, sweep_);
    set_point_c_ = temp_c;
  }

  void end_visits() {
    visit_ = -1;
    sweep_ = calib::Sweep::unknown;
    set_point_c_ = room_c_;
  }

  /// Appends a step at the current place of the plan.
  Step& add(StepKind kind) {
    Step step;
    step.kind = kind;
    step.run = static_cast<int>(plan_.runs.size()) - 1;
    step.visit = visit_;
    step.temp_c = set_point_c_;
    step.sweep = sweep_;
    step.position = position_;
    plan_.runs.back().last_step = plan_.steps.size();
    return plan_.steps.emplace_back(std::move(step));
  }

  void turn_fixture(double heading_deg) {
    Step& step = add(StepKind::turn_fixture);
    step.heading_deg = heading_deg;
    step.estimate_s = kByHand_s;
  }

  void move_to(const std::string& position) {
    position_ = position;
    add(StepKind::move).estimate_s = kTurn_s;
  }

  void spin(double rate_dps) {
    Step& step = add(StepKind::spin);
    step.rate_dps = rate_dps;
    step.estimate_s = kTurn_s;
  }

  /// Expected time until the air has gone to `temp_c`, from where it was left.
  double drive_s(double temp_c) {
    const double rate_kpmin = std::min(procedure().estimate_rate_kpmin,
                                       procedure().ramp_rate_kpmin.value_or(procedure().estimate_rate_kpmin));
    const double seconds = std::abs(temp_c - air_c_) / rate_kpmin * kSecondsPerMinute;
    air_c_ = temp_c;
    return seconds;
  }

  void set_temperature() { add(StepKind::set_temperature).estimate_s = drive_s(set_point_c_); }

  void wait_stable(bool after_turn) {
    Step& step = add(StepKind::wait_stable);
    step.seconds = procedure().stability.timeout_s;
    step.after_turn = after_turn;
    step.estimate_s = after_turn ? procedure().stability.after_turn_s : procedure().estimate_settle_s;
  }

  void record(double seconds) {
    Step& step = add(StepKind::record);
    step.seconds = seconds;
    step.estimate_s = seconds;
  }

  /// Units colder than the end follow the air; warmer ones gather no dew.
  void warm_end() {
    const bool units_are_cold = air_c_ < procedure().end_c;
    Step& step = add(StepKind::warm_end);
    step.temp_c = procedure().end_c;
    step.estimate_s = drive_s(procedure().end_c) + (units_are_cold ? procedure().estimate_settle_s : 0.0);
  }

  void power_off() {
    Step& step = add(StepKind::power_off);
    step.seconds = procedure().power_off_s;
    step.estimate_s = procedure().power_off_s;
  }

  Plan plan_;
  double room_c_;
  double air_c_;              ///< where the plan has driven the air
  double set_point_c_ = 0.0;  ///< of the current visit, else the room's temperature
  int labels_ = 0;            ///< runs that have one, but for the pre-flight
  int visit_ = -1;
  calib::Sweep sweep_ = calib::Sweep::unknown;
  std::string position_;
};

}  // namespace

std::vector<std::string> positions_of_run(const Procedure& procedure, int run) {
  std::vector<std::string> order = procedure.positions;
  const auto begins = axis_begins(order);
  const auto first_axis = static_cast<std::size_t>(rotation_of_run(procedure.position_change, run)) % begins.size();
  std::rotate(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(begins[first_axis]), order.end());
  if (is_reversed(procedure.position_change, run)) std::reverse(order.begin(), order.end());
  return order;
}

Plan compile_plan(const Procedure& procedure, double room_c) { return Compiler(procedure, room_c).compile(); }

}  // namespace soak::station
