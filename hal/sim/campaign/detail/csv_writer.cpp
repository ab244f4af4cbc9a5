// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/campaign/detail/csv_writer.h"

#include <fmt/format.h>

#include <iterator>

namespace soak::hal::sim {

void append_csv_rows(const calib::Recording& recording, std::string& csv) {
  auto out = std::back_inserter(csv);
  const std::vector<double>& chamber_c = recording.auxiliary.front().values;
  for (std::size_t i = 0; i < recording.rows(); ++i) {
    const std::int32_t position = recording.position[i];
    const std::string_view label =
        position < 0 ? std::string_view() : recording.positions[static_cast<std::size_t>(position)].label;
    fmt::format_to(out, "{:.3f},{},{},{},{},{},{:.3f},{:.4f}", recording.t_s[i], recording.run_id,
                   recording.phase[i] == calib::Phase::ramp ? "ramp" : "soak", calib::name_of(recording.sweep[i]),
                   recording.plateau_c[i], label, chamber_c[i], recording.temp_c[i]);
    for (const calib::Sensor sensor : calib::kSensors) {
      const double printed = recording.sensor[calib::index_of(sensor)][i] * calib::printed_per_si(sensor);
      fmt::format_to(out, ",{:.5f}", printed);
    }
    csv += '\n';
  }
}

}  // namespace soak::hal::sim
