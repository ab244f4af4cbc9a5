// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/design/detail/design_csv.h"

#include <fmt/format.h>

#include <iterator>

namespace soak::hal::sim {

std::string design_csv(const CampaignConfig& config, const CampaignCourse& course, const DesignedUnit& designed) {
  const bool logs = config.design->kind != DesignKind::missing_logs;
  std::string csv = fmt::format(
      "t_s,run,phase,sweep,plateau_c,position,{}temp_c,gx_dps,gy_dps,gz_dps,ax_mps2,ay_mps2,az_mps2,{}"
      "t_since_power_s,utc_s\n",
      logs ? "chamber_c," : "", logs ? "compressor,supply_v," : "");
  auto out = std::back_inserter(csv);
  for (const DesignedRow& row : designed.rows) {
    const Moment& moment = course.moments[row.moment];
    const Conditions& now = moment.conditions;
    fmt::format_to(out, "{:.10g},{},{},{},{:.10g},{},", now.since_power_on_s,
                   course.runs[static_cast<std::size_t>(now.run)].label,
                   moment.phase == calib::Phase::ramp ? "ramp" : "soak", calib::name_of(moment.sweep),
                   config.design->set_point_c(moment.set_point), position_label(course, moment));
    if (logs) fmt::format_to(out, "{:.2f},", row.chamber_c);
    fmt::format_to(out, "{:.3f}", row.temp_c);
    for (const calib::Sensor sensor : calib::kSensors) {
      fmt::format_to(out, ",{:.5f}", row.sensor[calib::index_of(sensor)] * calib::printed_per_si(sensor));
    }
    if (logs) fmt::format_to(out, ",{},{:.4f}", now.compressor, now.supply_v);
    fmt::format_to(out, ",{:.10g},{:.0f}\n", now.since_power_on_s, now.utc_s);
  }
  return csv;
}

}  // namespace soak::hal::sim
