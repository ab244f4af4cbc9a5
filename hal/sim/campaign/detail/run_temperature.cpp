// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/campaign/detail/run_temperature.h"

#include <algorithm>
#include <cmath>

#include "base/random.h"
#include "hal/sim/unit/draws.h"

namespace soak::hal::sim {

RunTemperature::RunTemperature(const CampaignConfig& config, const std::vector<Visit>& visits, std::uint64_t run_seed)
    : thermometer_(config.thermometer), chamber_(config.chamber) {
  base::Random random(run_seed, stream_of(Purpose::visit));
  for (std::size_t i = 0; i < visits.size(); ++i) {
    Course course;
    course.visit = visits[i];
    course.settled_c = visits[i].set_point.temp_c + drawn_within(random, thermometer_.visit_offset_half_width_c);
    course.drift_c = drawn_within(random, thermometer_.plateau_drift_half_width_c);
    course.from_c = i == 0 ? course.settled_c : unit_c(i - 1, visits[i].t_change_s);
    course.chamber_from_c = visits[i == 0 ? 0 : i - 1].set_point.temp_c;
    courses_.push_back(course);
  }
}

double RunTemperature::unit_c(std::size_t visit, double t_s) const {
  const Course& course = courses_[visit];
  const double to_go = std::exp(-(t_s - course.visit.t_change_s) / thermometer_.settling_time_s);
  const double plateau_s = std::max(course.visit.t_end_s - course.visit.t_soak_s, 1e-9);
  const double passed = std::clamp((t_s - course.visit.t_soak_s) / plateau_s, 0.0, 1.0);
  return course.settled_c + (course.from_c - course.settled_c) * to_go + course.drift_c * passed;
}

double RunTemperature::chamber_c(std::size_t visit, double t_s) const {
  const Course& course = courses_[visit];
  const double to_go = std::exp(-(t_s - course.visit.t_change_s) / chamber_.settling_time_s);
  const double set_point_c = course.visit.set_point.temp_c;
  return set_point_c + (course.chamber_from_c - set_point_c) * to_go;
}

}  // namespace soak::hal::sim
