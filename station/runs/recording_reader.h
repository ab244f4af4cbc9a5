// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "calib/vocabulary/recording.h"
#include "db/run/run_file.h"

namespace soak::station {

/// The samples of one unit in a run file, converted to SI. Thermometers, set points and auxiliary channels hold their
/// values as hold_slow_channel() says; sensors never do. `t_since_power_s` runs on with the time where its cells are
/// empty. Positions come by label, the six named ones and those that the file defines; an empty label is "moving".
/// Where a channel gives the rate of the fixture, split_by_rate() (fixture_rates.h) makes positions of the rates too.
/// Auxiliary channels of text are left out: a recording holds numbers. Refuses a label that the file does not define.
[[nodiscard]] base::Result<calib::Recording> read_recording(const db::RunFileReader& file, std::string_view unit);

/// The same in parts, for who looks at one sensor at a time: all but the samples of the sensors (their vectors are
/// empty), and those of one sensor, converted to SI, into `values`, whose memory is used again; empty where the sensor
/// was not recorded.
[[nodiscard]] base::Result<calib::Recording> read_axes(const db::RunFileReader& file, std::string_view unit);
[[nodiscard]] base::Status read_sensor(const db::RunFileReader& file, std::string_view unit, calib::Sensor sensor,
                                       std::vector<double>& values);

}  // namespace soak::station
