// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "calib/estimate/model_term.h"
#include "calib/vocabulary/sensor.h"
#include "db/catalog/catalog.h"

/// Effects in words, the same in all that is printed: of each one quantity in one unit.
namespace soak::station {

/// "gyro_x, gyro_y", or "all sensors".
[[nodiscard]] std::string sensors_text(const std::vector<calib::Sensor>& sensors);

/// The line that says how large an effect is: name, size in the unit of `soak gap find`, shape, sensors.
[[nodiscard]] std::string size_text(std::string_view name, double value, std::string_view unit, std::string_view shape,
                                    std::string_view sensors);

/// size_text() of an accepted term, as the report in which it was found missing has it; a line for each shape. Only its
/// name where the catalog holds no such report. Fails as the catalog does.
[[nodiscard]] base::Result<std::vector<std::string>> size_lines(const db::Catalog& catalog, const std::string& unit,
                                                                const calib::ModelTerm& term);

/// A parameter of a term (docs/gap-terms.md) in the units that sizes are printed in: deg for rad, K/min for K/s, g for
/// m/s² of specific force, 1000 h for s of ageing. Other units stay, and so do names that state no unit.
[[nodiscard]] calib::TermParameter printed_parameter(calib::TermParameter parameter);

/// Table of the parameters of terms: term, sensors, parameter, value, unit.
[[nodiscard]] std::string parameter_table(const std::vector<calib::ModelTerm>& terms);

}  // namespace soak::station
