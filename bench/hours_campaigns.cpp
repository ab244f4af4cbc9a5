// SPDX-License-Identifier: Apache-2.0
// What campaigns leave of a made-up gyro whose curve is known: a line of CSV per unit and campaign, for hours.py.
//
// Units and readings come from this file and the C++ library alone: no basis function, no random number and no noise of
// `calib`. The programs under test see rows only. `bench_hours UNITS [SEED]`: so many units of each fleet.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "calib/curve/baselines.h"
#include "calib/curve/curve_fit.h"
#include "station/config/plan.h"
#include "station/config/procedure.h"
#include "station/plan/campaign_plan.h"

namespace soak {
namespace {

using Generator = std::mt19937_64;

constexpr double kLow_c = -30.0;
constexpr double kHigh_c = 70.0;
constexpr double kRoom_c = 25.0;
constexpr double kRun_dps = 0.01;          // a power-on's level
constexpr double kWhite_dps_rthz = 0.012;  // density; a visit's bias is the mean of two positions
constexpr double kInstability_dps = 4e-4;  // of each of three first-order processes, 2 min, 20 min and 3 h
constexpr std::array kInstability_s = {120.0, 1200.0, 10800.0};

double uniform(Generator& g, double low, double high) { return std::uniform_real_distribution<double>(low, high)(g); }
double sign(Generator& g) { return uniform(g, -1.0, 1.0) < 0.0 ? -1.0 : 1.0; }

/// A unit's bias in deg/s, and the half gap of its hysteresis.
struct Unit {
  std::function<double(double)> curve;
  double half_gap = 0.0;

  /// Opens in the middle and closes where the temperature turns.
  [[nodiscard]] double loop(double temp_c) const {
    const double z = (temp_c - 20.0) / 50.0;
    return half_gap * std::max(0.0, 1.0 - z * z);
  }
};

enum class Fleet { smooth, features, kinks, hysteresis };
constexpr std::array kFleetNames = {"smooth", "features", "kinks", "hysteresis"};

Unit draw_unit(Fleet fleet, Generator& g) {
  const double bend = uniform(g, 0.1, 0.3) * sign(g);
  const double centre_c = uniform(g, -20.0, 60.0);
  const double width_c = uniform(g, 25.0, 50.0);
  const double slope = uniform(g, -0.002, 0.002);
  const double height = uniform(g, 0.01, 0.03) * sign(g);
  const double place_c = uniform(g, -22.0, 62.0);
  const double half_width_c = uniform(g, 2.5, 4.5);  // 5 to 9 degrees wide at half height
  const double kink = uniform(g, 0.001, 0.004) * sign(g);
  Unit unit;
  if (fleet == Fleet::hysteresis) unit.half_gap = uniform(g, 0.004, 0.01) * sign(g);
  unit.curve = [=](double temp_c) {
    double value = bend * std::tanh((temp_c - centre_c) / width_c) + slope * temp_c;
    if (fleet == Fleet::features) value += height * std::exp2(-std::pow((temp_c - place_c) / half_width_c, 2));
    if (fleet == Fleet::kinks) value += kink * std::abs(temp_c - place_c);
    return value;
  };
  return unit;
}

/// Slow noise of a gyro, in the order of time.
class Instability {
 public:
  explicit Instability(Generator& g) {
    for (double& state : states_) state = kInstability_dps * normal_(g);
  }
  double after(double seconds, Generator& g) {
    double sum = 0.0;
    for (std::size_t i = 0; i < states_.size(); ++i) {
      const double kept = std::exp(-seconds / kInstability_s[i]);
      states_[i] = kept * states_[i] + std::sqrt(1.0 - kept * kept) * kInstability_dps * normal_(g);
      sum += states_[i];
    }
    return sum;
  }

 private:
  std::normal_distribution<double> normal_;
  std::array<double, kInstability_s.size()> states_{};
};

/// The rows that the visits of a compiled plan would give: one per visit.
calib::CurveData measure(const Unit& unit, const station::Plan& plan, Generator& g) {
  std::normal_distribution<double> normal;
  calib::CurveData data;
  Instability slow(g);
  const double noise = kWhite_dps_rthz / std::sqrt(4.0 * plan.procedure.dwell_s);
  double before_c = kRoom_c;
  double way = 0.0;  // of the last change of the temperature, power-ons between or not
  for (const station::PlannedRun& planned : plan.runs) {
    if (planned.preflight) continue;
    const int run = static_cast<int>(data.runs.size());
    data.runs.push_back(planned.label);
    const double level = kRun_dps * normal(g);
    double since_s = 0.0;
    double t_s = 0.0;
    for (std::size_t i = planned.first_step; i <= planned.last_step; ++i) {
      const station::Step& step = plan.steps[i];
      since_s += step.estimate_s;
      t_s += step.estimate_s;
      const bool end = step.kind == station::StepKind::warm_end;
      if (!end && step.kind != station::StepKind::set_temperature) continue;
      if (step.temp_c != before_c) way = step.temp_c > before_c ? 1.0 : -1.0;
      before_c = step.temp_c;
      if (end) continue;
      const double temp_c = step.temp_c + 0.15 * normal(g);
      const double value =
          unit.curve(temp_c) + way * unit.loop(temp_c) + level + slow.after(since_s, g) + noise * normal(g);
      since_s = 0.0;
      data.rows.push_back({run, run, step.sweep, t_s, temp_c, value, noise});
    }
  }
  data.branches = data.runs;
  return data;
}

/// Errors of a curve against the truth.
struct Errors {
  double worst_shape = 0.0;
  double level = 0.0;
};

Errors errors_of(const std::function<double(double)>& curve, const Unit& unit) {
  std::vector<double> errors;
  double mean = 0.0;
  for (double temp_c = kLow_c + 0.5; temp_c <= kHigh_c - 0.5; temp_c += 0.25)
    errors.push_back(curve(temp_c) - unit.curve(temp_c));
  for (const double error : errors) mean += error / static_cast<double>(errors.size());
  Errors result{0.0, std::abs(mean)};
  for (const double error : errors) result.worst_shape = std::max(result.worst_shape, std::abs(error - mean));
  return result;
}

station::Plan plan_of(const station::PassDesign& design, const calib::UnitType& type) {
  const auto procedure =
      station::parse_procedure(station::procedure_text(design, {kLow_c, kHigh_c, type}, "bench", ""), "bench", {type});
  if (!procedure) throw std::runtime_error(procedure.error().message);
  return station::compile_plan(*procedure);
}

/// One line: fleet, unit, campaign, hours, worst shape error, level error, whether the bands of the curve and of a
/// fresh power-on held at one temperature that is drawn.
void print_line(const char* fleet, int unit, const char* campaign, double hours, const Errors& errors,
                const std::string& held) {
  std::printf("%s,%d,%s,%.2f,%.6g,%.6g,%s\n", fleet, unit, campaign, hours, errors.worst_shape, errors.level,
              held.c_str());
  std::fflush(stdout);
}

void run_campaign(const char* fleet, int number, const char* campaign, const station::PassDesign& design,
                  const Unit& unit, const calib::UnitType& type, Generator& g) {
  const station::Plan plan = plan_of(design, type);
  const auto fit = calib::fit_curve(measure(unit, plan, g), {}, {"gyro_x", "deg/s", 1.0});
  if (!fit) throw std::runtime_error(fit.error().message);
  const auto at = static_cast<std::size_t>(uniform(g, 1.0, static_cast<double>(fit->points.size()) - 1.0));
  const calib::CurvePoint& point = fit->points[at];
  const double error = point.value - unit.curve(point.temp_c);
  const double way = sign(g) * unit.loop(point.temp_c);
  const double fresh = error - way - kRun_dps * std::normal_distribution<double>()(g);
  const bool curve_held = std::abs(error) <= point.ci95;
  const bool fresh_held = point.pi95 && std::abs(fresh) <= *point.pi95;
  print_line(fleet, number, campaign, plan.estimate_s() / 3600.0,
             errors_of([&](double temp_c) { return evaluate(fit->curve, temp_c); }, unit),
             std::string(curve_held ? "1" : "0") + (fresh_held ? ",1" : ",0"));
}

/// One run up and down at 1 K/min without a stop, after which a cubic is fitted to readings of half a minute; the
/// sensing element lags 30 s behind the thermometer. It states no bands.
void run_ramp(const char* fleet, int number, const Unit& unit, Generator& g) {
  constexpr double kRamp_kpmin = 1.0;
  constexpr double kLag_c = kRamp_kpmin * 0.5;
  std::normal_distribution<double> normal;
  anfis::TrainingData rows;
  Instability slow(g);
  const double level = kRun_dps * normal(g);
  for (const double way : {1.0, -1.0}) {
    for (double temp_c = kLow_c; temp_c <= kHigh_c; temp_c += 0.5 * kRamp_kpmin) {
      rows.x.push_back(temp_c);
      rows.y.push_back(unit.curve(temp_c - way * kLag_c) + way * unit.loop(temp_c) + level + slow.after(30.0, g) +
                       kWhite_dps_rthz / std::sqrt(60.0) * normal(g));
      rows.weight.push_back(1.0);
    }
  }
  const auto cubic = calib::fit_polynomial(rows, 3);
  if (!cubic) throw std::runtime_error(cubic.error().message);
  // From the room to the cold end at 2 K/min with 25 min to settle, up and down, and back to the room.
  const double minutes = 2.0 * (25.0 - kLow_c) / 2.0 + 25.0 + 2.0 * (kHigh_c - kLow_c) / kRamp_kpmin;
  print_line(fleet, number, "ramp-cubic", minutes / 60.0,
             errors_of([&](double temp_c) { return evaluate(cubic->curve, temp_c); }, unit), ",");
}

/// What a laboratory knows of a fleet of which five units have been through four passes both ways.
station::TypePicture learnt_picture(Fleet fleet, const calib::UnitType& type, Generator& g) {
  std::vector<calib::StoredCurve> stored;
  for (int i = 0; i < 5; ++i) {
    stored.push_back({measure(draw_unit(fleet, g), plan_of({.passes = 4, .plateaus = 21}, type), g), 600.0});
  }
  const auto learnt = calib::learn_picture(stored);
  if (!learnt) throw std::runtime_error(learnt.error().message);
  station::TypePicture picture;
  picture.sensors[0] = learnt->picture;
  picture.low_c = kLow_c;
  picture.high_c = kHigh_c;
  return picture;
}

void run_fleet(Fleet fleet, int units, std::uint64_t seed) {
  const char* name = kFleetNames[static_cast<std::size_t>(fleet)];
  Generator g(seed + 1000 * static_cast<std::uint64_t>(fleet));
  calib::UnitType type;
  type.name = "bench";
  type.temp_min_c = -40.0;
  type.temp_max_c = 85.0;
  const auto plan = station::plan_campaign(learnt_picture(fleet, type, g), type, {});
  if (!plan) throw std::runtime_error(plan.error().message);
  const station::PassDesign planned = plan->options[plan->chosen].design;
  std::fprintf(stderr, "%s: planned %d passes, %d plateaus, back every %d, %d power cycles in a pass, dwell %.0f s\n",
               name, planned.passes, planned.plateaus, planned.return_every, planned.power_cycles, planned.dwell_s);
  for (int i = 0; i < units; ++i) {
    const Unit unit = draw_unit(fleet, g);
    run_campaign(name, i, "full", station::full_campaign(kLow_c, kHigh_c), unit, type, g);
    run_campaign(name, i, "six-runs", {.passes = 6, .plateaus = 21, .return_every = 0}, unit, type, g);
    run_campaign(name, i, "coarse", {.passes = 6, .plateaus = 6}, unit, type, g);
    run_ramp(name, i, unit, g);
    run_campaign(name, i, "planned", planned, unit, type, g);
  }
}

}  // namespace
}  // namespace soak

int main(int argc, char** argv) {
  const int units = argc > 1 ? std::atoi(argv[1]) : 25;
  const auto seed = static_cast<std::uint64_t>(argc > 2 ? std::atoi(argv[2]) : 1);
  if (units < 1) {
    std::fputs("usage: bench_hours [UNITS [SEED]], one unit or more of each fleet\n", stderr);
    return 2;
  }
  std::puts("fleet,unit,campaign,hours,worst_shape_dps,level_dps,curve_held,fresh_held");
  using soak::Fleet;
  for (const Fleet fleet : {Fleet::smooth, Fleet::features, Fleet::kinks, Fleet::hysteresis})
    soak::run_fleet(fleet, units, seed);
  return 0;
}
