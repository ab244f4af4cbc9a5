// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/design/detail/campaign_timeline.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "base/random.h"
#include "hal/sim/unit/attitude.h"
#include "hal/sim/unit/draws.h"
#include "hal/sim/unit/simulated_unit.h"

namespace soak::hal::sim {
namespace {

constexpr double kAirTime_s = 60.0;
constexpr double kLoadTime_s = 1200.0;
constexpr double kUnitToAir_s = 200.0;
constexpr double kUnitToLoad_s = 2000.0;
constexpr double kLongestStep_s = 5.0;
constexpr double kCompressorCycle_s = 400.0;

/// Share of time that the compressor runs.
double compressor_duty(double air_c) { return std::clamp(0.5 - 0.006 * (air_c - 25.0), 0.25, 0.75); }

/// Heat and compressor of the chamber in a designed campaign. The set point moves at the ramp rate; the air follows it
/// with 60 s, the load follows the air with 1200 s, and the unit follows both (200 s and 2000 s). The compressor
/// toggles at random, also while the temperature is held: cycles of 400 s on average, three quarters of them on in the
/// cold and one quarter in the heat.
class DesignChamber {
 public:
  DesignChamber(double room_c, base::Random random);

  /// Everything has been at room temperature for long; the compressor goes on from where it was.
  void rest();
  void set_target(double target_c, double ramp_kps);
  void advance(double duration_s);

  [[nodiscard]] double air_c() const { return air_c_; }
  [[nodiscard]] double unit_c() const { return unit_c_; }
  [[nodiscard]] bool compressor_runs() const { return compressor_runs_; }

 private:
  void step(double duration_s);
  [[nodiscard]] double drawn_stay_s();

  double room_c_;
  base::Random random_;
  double target_c_;
  double ramp_kps_ = 0.0;
  double set_point_c_;
  double air_c_;
  double load_c_;
  double unit_c_;
  bool compressor_runs_ = false;
  double stays_s_ = 0.0;  ///< until the compressor toggles
};

DesignChamber::DesignChamber(double room_c, base::Random random) : room_c_(room_c), random_(random) {
  rest();
  stays_s_ = drawn_stay_s();
}

void DesignChamber::rest() {
  target_c_ = set_point_c_ = air_c_ = load_c_ = unit_c_ = room_c_;
  ramp_kps_ = 0.0;
}

void DesignChamber::set_target(double target_c, double ramp_kps) {
  target_c_ = target_c;
  ramp_kps_ = ramp_kps;
}

void DesignChamber::advance(double duration_s) {
  while (duration_s > 0.0) {
    const double step_s = std::min(duration_s, kLongestStep_s);
    step(step_s);
    duration_s -= step_s;
  }
}

void DesignChamber::step(double duration_s) {
  const double to_go_c = target_c_ - set_point_c_;
  set_point_c_ += std::clamp(to_go_c, -ramp_kps_ * duration_s, ramp_kps_ * duration_s);
  const double unit_kps = (air_c_ - unit_c_) / kUnitToAir_s + (load_c_ - unit_c_) / kUnitToLoad_s;
  load_c_ += duration_s / kLoadTime_s * (air_c_ - load_c_);
  air_c_ += duration_s / kAirTime_s * (set_point_c_ - air_c_);
  unit_c_ += duration_s * unit_kps;
  stays_s_ -= duration_s;
  if (stays_s_ <= 0.0) {
    compressor_runs_ = !compressor_runs_;
    stays_s_ += drawn_stay_s();
  }
}

double DesignChamber::drawn_stay_s() {
  const double duty = compressor_duty(air_c_);
  const double mean_s = kCompressorCycle_s * (compressor_runs_ ? duty : 1.0 - duty);
  return -mean_s * std::log(1.0 - random_.uniform());
}

constexpr Range kBetweenPasses_h = {16.0, 40.0};
constexpr double kPreparation_s = 7200.0;
constexpr double kPreparationStep_s = 60.0;
constexpr double kPreparationRamp_kps = 2.0 / 60.0;
constexpr double kPowerOnWait_s = 60.0;
constexpr double kPowerOff_s = 30.0;

/// Lets time pass and keeps what happens.
class TimelineBuilder {
 public:
  TimelineBuilder(const CampaignConfig& config, CampaignTimeline& timeline)
      : config_(config),
        design_(*config.design),
        timeline_(timeline),
        random_(config.seed, stream_of(Purpose::design_visit)),
        chamber_(config.lab.plant.room_c, base::Random(config.seed, stream_of(Purpose::compressor))),
        supply_(config.seed) {
    if (design_.known_effects) earth_ = config.earth;
  }

  void add_pass(int pass) {
    pass_ = pass;
    const RunProfile& profile = timeline_.passes[static_cast<std::size_t>(pass)];
    place_ = resting(profile.positions[0], earth_);
    prepare(profile);
    switch_on();
    for (std::size_t visit = 0; visit < profile.set_points.size(); ++visit) add_visit(profile, visit);
    powered_ = false;
    visit_ = -1;
    time_s_ += 3600.0 * drawn_from(random_, kBetweenPasses_h);
  }

 private:
  void prepare(const RunProfile& profile) {
    chamber_.rest();
    add_moment(false);
    chamber_.set_target(target_c(profile.set_points[0]), kPreparationRamp_kps);
    for (double t_s = 0.0; t_s < kPreparation_s; t_s += kPreparationStep_s) pass_time(kPreparationStep_s, false);
  }

  void switch_on() {
    powered_ = true;
    power_on_s_ = time_s_;
    const int run = static_cast<int>(timeline_.runs.size()) + 1;
    timeline_.runs.push_back({run_label(run), pass_, kFirstUtc_s + time_s_});
    add_moment(false);
  }

  void add_visit(const RunProfile& profile, std::size_t visit) {
    const std::vector<int>& points = profile.set_points;
    const std::size_t at = visit == 0 ? 1 : visit;  // the first visit counts to the sweep that follows
    sweep_ = points[at] > points[at - 1] ? calib::Sweep::up : calib::Sweep::down;
    visit_ = static_cast<int>(visit);
    set_point_ = points[visit];
    place_ = resting(profile.positions[0], earth_);
    if (visit == 0) {
      pass_time(kPowerOnWait_s, false);
    } else {
      add_ramp(profile, points[visit - 1]);
    }
    for (std::size_t position = 0; position < profile.positions.size(); ++position) {
      if (position > 0) add_turn(profile, position);
      add_stay(static_cast<int>(position));
    }
  }

  void add_ramp(const RunProfile& profile, int from) {
    phase_ = calib::Phase::ramp;
    chamber_.set_target(target_c(set_point_), profile.ramp_kps);
    if (visit_ == profile.power_cycle_visit) cycle_power();
    const double way_c = std::abs(design_.set_point_c(set_point_) - design_.set_point_c(from));
    const double duration_s = kDesignRowInterval_s * std::ceil((way_c / profile.ramp_kps + profile.soak_s) / 10.0);
    double t_s = 0.0;
    for (; t_s + design_.ramp_row_interval_s < duration_s; t_s += design_.ramp_row_interval_s) {
      pass_time(design_.ramp_row_interval_s, true);
    }
    pass_time(duration_s - t_s, false);
    phase_ = calib::Phase::soak;
  }

  void cycle_power() {
    powered_ = false;
    pass_time(kPowerOff_s, false);
    switch_on();
  }

  void add_turn(const RunProfile& profile, std::size_t position) {
    place_ = turning(profile.positions[position - 1], profile.positions[position], 0.5, 2.0 * kDesignRowInterval_s);
    add_moment(true);
    place_ = resting(profile.positions[position], earth_);
    pass_time(kDesignRowInterval_s, false, false);
  }

  void add_stay(int position) {
    position_ = position;
    const int rows = design_.blocks * kRowsPerBlock;
    for (int row = 0; row < rows; ++row) {
      block_ = row / kRowsPerBlock;
      add_moment(true);
      pass_time(kDesignRowInterval_s, false, false);
    }
    position_ = block_ = -1;
  }

  void pass_time(double duration_s, bool recorded, bool keep = true) {
    chamber_.advance(duration_s);
    time_s_ += duration_s;
    if (keep) add_moment(recorded);
  }

  void add_moment(bool recorded) {
    Moment moment;
    Conditions& now = moment.conditions;
    now.time_s = time_s_;
    now.utc_s = kFirstUtc_s + time_s_;
    now.powered = powered_;
    now.since_power_on_s = powered_ ? time_s_ - power_on_s_ : 0.0;
    now.run = static_cast<int>(timeline_.runs.size()) - (powered_ ? 1 : 0);
    now.mounting = pass_;
    now.thermometer_c = now.element_c = chamber_.unit_c();
    now.air_c = chamber_.air_c();
    now.up = place_.up;
    now.compressor = chamber_.compressor_runs() ? 1.0 : 0.0;
    now.supply_v = supply_.at(time_s_, now.run);
    moment.rate_rps = place_.rate_rps;
    moment.recorded = recorded;
    moment.phase = phase_;
    moment.sweep = sweep_;
    moment.visit = visit_;
    moment.set_point = set_point_;
    moment.position = position_;
    moment.block = block_;
    timeline_.moments.push_back(moment);
  }

  [[nodiscard]] double target_c(int set_point) {
    return design_.set_point_c(set_point) + drawn_within(random_, config_.thermometer.visit_offset_half_width_c);
  }

  const CampaignConfig& config_;
  const DesignConfig& design_;
  CampaignTimeline& timeline_;
  base::Random random_;
  DesignChamber chamber_;
  SupplyVoltage supply_;
  std::optional<EarthFrame> earth_;
  double time_s_ = 0.0;
  double power_on_s_ = 0.0;
  bool powered_ = false;
  Attitude place_;
  calib::Phase phase_ = calib::Phase::soak;
  calib::Sweep sweep_ = calib::Sweep::unknown;
  int pass_ = 0;
  int visit_ = -1;
  int set_point_ = -1;
  int position_ = -1;
  int block_ = -1;
};

bool is_visit(const Moment& moment, const PlannedVisit& visit) {
  return moment.conditions.mounting == visit.pass && moment.visit == visit.visit;
}

}  // namespace

CampaignTimeline campaign_timeline(const CampaignConfig& config) {
  CampaignTimeline timeline;
  timeline.passes = run_profiles(*config.design, config.seed);
  timeline.mistakes = drawn_mistakes(*config.design, config.seed);
  TimelineBuilder builder(config, timeline);
  for (int pass = 0; pass < config.design->runs; ++pass) builder.add_pass(pass);
  return timeline;
}

std::vector<double> design_set_points_c(const DesignConfig& design) {
  std::vector<double> points_c;
  for (int i = 0; i < design.set_points; ++i) points_c.push_back(design.set_point_c(i));
  return points_c;
}

bool is_written(const CampaignTimeline& timeline, const DesignConfig& design, const Moment& moment) {
  if (!moment.recorded || is_visit(moment, timeline.mistakes.dropped)) return false;
  return design.kind != DesignKind::missing_logs || moment.phase == calib::Phase::soak;
}

std::string position_label(const CampaignTimeline& timeline, const Moment& moment) {
  if (moment.position < 0) return {};
  const RunProfile& pass = timeline.passes[static_cast<std::size_t>(moment.conditions.mounting)];
  std::string label = pass.positions[static_cast<std::size_t>(moment.position)].label;
  const PlannedVisit& wrong = timeline.mistakes.wrongly_labelled;
  if (is_visit(moment, wrong) && moment.position == wrong.position) label[0] = label[0] == '+' ? '-' : '+';
  return label;
}

}  // namespace soak::hal::sim
