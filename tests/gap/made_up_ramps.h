// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "base/random.h"
#include "calib/gap/campaign/campaign.h"

/// Cycles of one unit in one attitude, made up sample by sample from physics written down here anew.
namespace soak::calib::gap::made_up {

constexpr double kStep_s = 10.0;

/// Time and temperature of a run, every kStep_s.
struct Ramp {
  std::vector<double> t_s;
  std::vector<double> temp_c;
};

struct RampPlan {
  std::uint64_t seed = 1;
  int branches = 3;
  bool cools_first = true;
  double gyro = 2e-4;   ///< rad/s: block's white noise
  double accel = 1e-3;  ///< m/s²
  double wander = 0.9;  ///< of a slow noise of 100 s, in the same unit
};

/// What an effect adds over the run, in units of the plan's noise.
using RampEffect = std::function<std::vector<double>(const Ramp&, Sensor)>;

/// Ramps of 2 to 4 K/min between about −18 and 72 °C, from 25 °C on; the rate follows a change in three minutes.
inline Ramp ramp(const RampPlan& plan, base::Random& random) {
  Ramp made;
  double temp_c = 25.0;
  double rate_kps = 0.0;
  bool cooling = plan.cools_first;
  for (int branch = 0; branch < plan.branches; ++branch, cooling = !cooling) {
    const double end_c = cooling ? -18.0 + 2.0 * random.gaussian() : 72.0 + 2.0 * random.gaussian();
    const double asked_kps = (cooling ? -1.0 : 1.0) * (2.0 + 2.0 * random.uniform()) / 60.0;
    while (cooling ? temp_c > end_c : temp_c < end_c) {
      rate_kps += (asked_kps - rate_kps) * kStep_s / 180.0;
      temp_c += rate_kps * kStep_s;
      made.t_s.push_back(kStep_s * static_cast<double>(made.t_s.size()));
      made.temp_c.push_back(temp_c);
    }
  }
  return made;
}

inline double curve(Sensor sensor, double temp_c) {
  const double k = static_cast<double>(index_of(sensor)) + 1.0;
  return 120.0 * (std::atan((temp_c - 8.0 * k) / (18.0 + 4.0 * k)) + 0.25 * std::sin(temp_c / 18.0 + k));
}

/// `read_c`: temperature that the elements are at, where it is not the thermometer's.
inline LoggedCampaign ramps(const RampPlan& plan, const RampEffect& hidden,
                            const std::function<std::vector<double>(const Ramp&)>& read_c = {}) {
  base::Random random(plan.seed);
  const Ramp temperatures = ramp(plan, random);
  const std::vector<double> elements_c = read_c ? read_c(temperatures) : temperatures.temp_c;
  Segment segment;
  segment.key = {"R1", "U", 0, "", 0};
  const std::size_t count = temperatures.t_s.size() / 3;
  for (std::size_t b = 0; b < count; ++b) {
    Block block;
    block.t_s = temperatures.t_s[3 * b + 1];
    block.duration_s = 3.0 * kStep_s;
    for (std::size_t i = 3 * b; i < 3 * b + 3; ++i) block.temp_c += temperatures.temp_c[i] / 3.0;
    block.sensor_temp_c.fill(block.temp_c);
    segment.blocks.push_back(block);
  }
  for (const Sensor sensor : kSensors) {
    const double unit = is_gyro(sensor) ? plan.gyro : plan.accel;
    const std::vector<double> added = hidden(temperatures, sensor);
    double slow = 0.0;
    for (std::size_t b = 0; b < count; ++b) {
      double value = unit * random.gaussian();
      for (std::size_t i = 3 * b; i < 3 * b + 3; ++i) {
        slow += -slow * kStep_s / 100.0 + plan.wander * std::sqrt(2.0 * kStep_s / 100.0) * random.gaussian();
        value += unit * (curve(sensor, elements_c[i]) + added[i] + slow) / 3.0;
      }
      segment.blocks[b].sensor[index_of(sensor)] = {60, value, 60.0 * unit * unit, unit};
    }
  }
  LoggedRun run;
  run.run.run_id = run.run.label = "R1";
  run.log.t_s = temperatures.t_s;
  run.log.temp_c = temperatures.temp_c;
  for (double& c : run.log.temp_c) c += 0.01 * random.gaussian();
  run.log.t_since_power_s = temperatures.t_s;
  segment.t_end_s = temperatures.t_s.back();
  segment.temp_c = 25.0;
  run.run.segments.push_back(std::move(segment));
  LoggedCampaign made;
  made.unit = "U";
  made.runs.push_back(std::move(run));
  return made;
}

/// A rod with play of `play_c` to either side, pushed by the temperature.
inline RampEffect play(double size, double play_c) {
  return [=](const Ramp& ramp, Sensor) {
    std::vector<double> result;
    double rod_c = ramp.temp_c.front();
    for (const double c : ramp.temp_c) {
      rod_c = std::clamp(rod_c, c - play_c, c + play_c);
      result.push_back(size * (c - rod_c) / play_c);
    }
    return result;
  };
}

inline RampEffect of_time(const std::function<double(double)>& value) {
  return [=](const Ramp& ramp, Sensor) {
    std::vector<double> result;
    for (const double t_s : ramp.t_s) result.push_back(value(t_s));
    return result;
  };
}

}  // namespace soak::calib::gap::made_up
