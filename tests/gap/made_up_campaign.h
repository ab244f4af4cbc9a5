// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "base/random.h"
#include "calib/gap/campaign/campaign.h"

/// Campaigns of one unit made up block by block, from physics written down here anew, with an effect of the test's own.
namespace soak::calib::gap::made_up {

/// Fewer of what a test repeats for more certainty where every step is checked, and slow.
constexpr std::uint64_t fewer_under_sanitizers(std::uint64_t count) {
#if defined(__SANITIZE_ADDRESS__)
  return count < 4 ? 1 : count / 4;
#else
  return count;
#endif
}

/// The state of a unit at one moment of a run.
struct Moment {
  int run = 0;
  int visit = 0;
  bool heating = true;
  double t_s = 0.0;
  double in_placement_s = 0.0;
  double temp_c = 0.0;
  double rate_kps = 0.0;
  double supply_v = 5.0;
  double duty = 0.0;
  Vector3 up{};
};

/// What an effect adds to a sensor, SI; called in the order of time, run after run.
using Hidden = std::function<double(Sensor, const Moment&)>;

struct Plan {
  std::uint64_t seed = 1;
  int runs = 6;
  int levels = 7;
  double low_c = -20.0;
  double high_c = 70.0;
  double soak_s = 1800.0;
  double settling_s = 400.0;
  double gyro_block = 7e-5;  ///< rad/s
  double accel_block = 2e-3;
  double placement_share = 0.5;  ///< of the block's standard deviation
  double visit_share = 0.5;
  double run_share = 5.0;
  bool backwards_every_other_run = false;  ///< the order of the positions
};

inline double bias(Sensor sensor, double temp_c) {
  const double k = static_cast<double>(index_of(sensor)) + 1.0;
  const double size = is_gyro(sensor) ? 0.004 : 0.15;
  return size * (std::atan((temp_c - 10.0 * k + 20.0) / 30.0) + 0.3 * std::sin(temp_c / (15.0 + 3.0 * k)));
}

/// Up and down over the levels, six positions of three one-minute blocks at each; the first visit begins settled.
inline LoggedCampaign campaign(const Plan& plan, const Hidden& hidden) {
  LoggedCampaign made;
  made.unit = "U";
  base::Random random(plan.seed);
  const double step_c = (plan.high_c - plan.low_c) / (plan.levels - 1);
  for (int r = 0; r < plan.runs; ++r) {
    LoggedRun run;
    run.run.run_id = run.run.label = "R" + std::to_string(r + 1);
    run.run.site.gravity_mps2 = 9.81;
    run.start_utc_s = 1.7e9 + 100000.0 * r;
    std::array<double, kSensorCount> offset{};
    for (const Sensor sensor : kSensors) {
      const double block = is_gyro(sensor) ? plan.gyro_block : plan.accel_block;
      offset[index_of(sensor)] = plan.run_share * block * random.gaussian();
    }
    double t_s = 0.0;
    double temp_c = plan.low_c;
    const auto advance = [&](double set_c, double seconds, const Moment& moment) {
      for (double done = 0.0; done < seconds; done += 10.0) {
        const double next = set_c + (temp_c - set_c) * std::exp(-10.0 / plan.settling_s);
        Moment here = moment;
        here.t_s = t_s;
        here.temp_c = temp_c;
        here.rate_kps = (next - temp_c) / 10.0;
        here.in_placement_s = done;
        for (const Sensor sensor : kSensors) (void)hidden(sensor, here);
        run.log.t_s.push_back(t_s);
        run.log.temp_c.push_back(temp_c + 0.01 * random.gaussian());
        run.log.t_since_power_s.push_back(t_s);
        run.log.chamber_c.push_back(set_c);
        run.log.compressor.push_back(moment.duty);
        run.log.supply_v.push_back(moment.supply_v);
        temp_c = next;
        t_s += 10.0;
      }
    };
    for (int visit = 0; visit < 2 * plan.levels - 1; ++visit) {
      const int k = visit < plan.levels ? visit : 2 * plan.levels - 2 - visit;
      const double set_c = plan.low_c + step_c * k + 0.2 * (2.0 * random.uniform() - 1.0);
      Moment moment;
      moment.run = r;
      moment.visit = visit;
      moment.heating = visit < plan.levels;
      moment.supply_v = 5.0 + 0.05 * random.gaussian();
      if (visit > 0) advance(set_c, plan.soak_s, moment);
      std::array<double, kSensorCount> at_visit{};
      for (double& x : at_visit) x = plan.visit_share * random.gaussian();
      for (int p = 0; p < 6; ++p) {
        Segment segment;
        const bool backwards = plan.backwards_every_other_run && r % 2 == 1;
        const auto label = kSixPositionLabels[static_cast<std::size_t>(backwards ? 5 - (p + r) % 6 : (p + r) % 6)];
        segment.position = position_named(label);
        segment.key = {run.run.run_id, "U", visit, std::string(label), 0};
        segment.plateau_c = plan.low_c + step_c * k;
        segment.sweep = moment.heating ? Sweep::up : Sweep::down;
        segment.t_start_s = t_s;
        moment.up = segment.position->up;
        std::array<double, kSensorCount> at_placement{};
        for (double& x : at_placement) x = plan.placement_share * random.gaussian();
        for (int b = 0; b < 3; ++b) {
          Block block;
          moment.duty = random.uniform() < 0.5 ? 0.0 : 1.0;
          const double begin_s = t_s;
          const double begin_c = temp_c;
          advance(set_c, 60.0, moment);
          block.t_s = 0.5 * (begin_s + t_s);
          block.duration_s = 60.0;
          block.temp_c = 0.5 * (begin_c + temp_c);
          block.sensor_temp_c.fill(block.temp_c);
          Moment middle = moment;
          middle.t_s = block.t_s;
          middle.temp_c = block.temp_c;
          middle.rate_kps = (temp_c - begin_c) / 60.0;
          middle.in_placement_s = block.t_s - segment.t_start_s;
          for (const Sensor sensor : kSensors) {
            const std::size_t s = index_of(sensor);
            const double unit = is_gyro(sensor) ? plan.gyro_block : plan.accel_block;
            const double input = is_gyro(sensor) ? 0.0 : 9.81 * 1.001 * moment.up[axis_of(sensor)];
            const double value = input + bias(sensor, block.temp_c) + offset[s] + hidden(sensor, middle) +
                                 unit * (at_visit[s] + at_placement[s] + random.gaussian());
            block.sensor[s] = {60, value, 60.0 * unit * unit, unit};
          }
          segment.blocks.push_back(block);
        }
        segment.t_end_s = t_s;
        run.run.segments.push_back(segment);
      }
    }
    made.runs.push_back(std::move(run));
  }
  return made;
}

/// Standard deviation of a block's noise.
inline double unit_of(const Plan& plan, Sensor sensor) { return is_gyro(sensor) ? plan.gyro_block : plan.accel_block; }

/// A rod with play: follows the temperature 15 K behind on both sides.
inline Hidden hysteresis(const Plan& plan) {
  auto rods = std::make_shared<std::array<double, kSensorCount>>();
  auto runs = std::make_shared<std::array<int, kSensorCount>>();
  runs->fill(-1);
  return [=](Sensor sensor, const Moment& moment) {
    double& rod = rods->at(index_of(sensor));
    int& run = runs->at(index_of(sensor));
    if (run != moment.run) rod = moment.temp_c + 15.0;
    run = moment.run;
    rod = std::clamp(rod, moment.temp_c - 15.0, moment.temp_c + 15.0);
    return unit_of(plan, sensor) * (moment.temp_c - rod) / 15.0;
  };
}

/// Elements that follow the thermometer with a time constant, each run with its own.
inline Hidden lag(const std::vector<double>& tau_s) {
  struct Element {
    int run = -1;
    std::vector<double> t_s;
    std::vector<double> temp_c;
  };
  auto element = std::make_shared<Element>();
  return [=](Sensor sensor, const Moment& moment) {
    Element& e = *element;
    if (e.run != moment.run) e = {moment.run, {moment.t_s}, {moment.temp_c}};
    if (moment.t_s > e.t_s.back()) {
      const double stays = std::exp(-(moment.t_s - e.t_s.back()) / tau_s.at(static_cast<std::size_t>(moment.run)));
      e.temp_c.push_back(moment.temp_c + (e.temp_c.back() - moment.temp_c) * stays);
      e.t_s.push_back(moment.t_s);
    }
    // Blocks are asked for once they are over.
    const auto upper = std::lower_bound(e.t_s.begin() + (e.t_s.size() > 1 ? 1 : 0), e.t_s.end(), moment.t_s);
    const auto k = static_cast<std::size_t>(upper - e.t_s.begin());
    const double behind_c = k == 0 ? e.temp_c[0]
                                   : std::lerp(e.temp_c[k - 1], e.temp_c[k],
                                               std::min(1.0, (moment.t_s - e.t_s[k - 1]) / (e.t_s[k] - e.t_s[k - 1])));
    return bias(sensor, behind_c) - bias(sensor, moment.temp_c);
  };
}

inline Hidden nothing() {
  return [](Sensor, const Moment&) { return 0.0; };
}

/// A bias of each sensor that wanders: Gauss-Markov processes of equal variance, `blocks` of a block's noise together.
inline Hidden wander(const Plan& plan, double blocks, const std::vector<double>& tau_s, std::uint64_t seed) {
  struct State {
    int run = -1;
    double t_s = 0.0;
    std::vector<double> value = {};
  };
  auto states = std::make_shared<std::array<State, kSensorCount>>();
  auto random = std::make_shared<base::Random>(seed);
  return [=](Sensor sensor, const Moment& moment) {
    State& state = (*states)[index_of(sensor)];
    if (state.run != moment.run) {
      state = {moment.run, moment.t_s, {}};
      for (std::size_t k = 0; k < tau_s.size(); ++k) state.value.push_back(random->gaussian());
    }
    double sum = 0.0;
    // Blocks are asked for once they are over.
    const double goes_on_s = std::max(0.0, moment.t_s - state.t_s);
    for (std::size_t k = 0; k < tau_s.size(); ++k) {
      const double stays = std::exp(-goes_on_s / tau_s[k]);
      state.value[k] = stays * state.value[k] + std::sqrt(1.0 - stays * stays) * random->gaussian();
      sum += state.value[k];
    }
    state.t_s += goes_on_s;
    return blocks * unit_of(plan, sensor) * sum / std::sqrt(static_cast<double>(tau_s.size()));
  };
}

/// What a thermometer in whole degrees would have shown.
inline LoggedCampaign in_whole_degrees(LoggedCampaign campaign) {
  campaign.thermometer.count = 1000;
  campaign.thermometer.step = 1.0;
  for (LoggedRun& run : campaign.runs) {
    for (double& c : run.log.temp_c) c = std::round(c);
    for (Segment& segment : run.run.segments) {
      for (Block& block : segment.blocks) {
        block.temp_c = std::round(block.temp_c);
        block.sensor_temp_c.fill(block.temp_c);
      }
    }
  }
  return campaign;
}

}  // namespace soak::calib::gap::made_up
