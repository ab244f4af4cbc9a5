// SPDX-License-Identifier: Apache-2.0
#include "calib/forward/take_off.h"

#include "calib/forward/mechanisms.h"

namespace soak::calib::forward {
namespace {

void take_off(const Mechanisms& mechanisms, Segment& segment) {
  // Kept apart: the blocks' mechanisms look at the segment as it was recorded.
  const Segment recorded = segment;
  const double middle_s = 0.5 * (recorded.t_start_s + recorded.t_end_s);
  for (const Sensor sensor : kSensors) {
    const std::size_t s = index_of(sensor);
    double samples = 0.0;
    double added = 0.0;
    double temp_c = 0.0;
    for (Block& block : segment.blocks) {
      const Moment moment{&recorded, block.t_s, 0.5 * block.duration_s, block.sensor_temp_c[s]};
      const double here = mechanisms.contribution(sensor, moment);
      const double behind_c = mechanisms.element_temp_c(sensor, moment) - moment.temp_c;
      block.sensor[s].mean -= here;
      block.sensor_temp_c[s] += behind_c;
      const auto count = static_cast<double>(block.sensor[s].count);
      samples += count;
      added += count * here;
      temp_c += count * behind_c;
    }
    const Moment whole{&recorded, middle_s, 0.5 * (recorded.t_end_s - recorded.t_start_s), recorded.sensor_temp_c[s]};
    segment.sensor[s].mean -= samples > 0.0 ? added / samples : mechanisms.contribution(sensor, whole);
    segment.sensor_temp_c[s] +=
        samples > 0.0 ? temp_c / samples : mechanisms.element_temp_c(sensor, whole) - whole.temp_c;
  }
}

}  // namespace

std::vector<std::string> take_off(const std::vector<ModelTerm>& terms, gap::LoggedCampaign& campaign) {
  std::vector<std::string> left_out;
  if (terms.empty()) return left_out;
  campaign.carried = terms;
  for (gap::LoggedRun& run : campaign.runs) {
    const Mechanisms mechanisms(terms, run, campaign.type.sign_at_rest);
    left_out.insert(left_out.end(), mechanisms.left_out().begin(), mechanisms.left_out().end());
    for (Segment& segment : run.run.segments) take_off(mechanisms, segment);
  }
  return left_out;
}

}  // namespace soak::calib::forward
