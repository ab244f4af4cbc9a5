// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "base/result.h"
#include "calib/curve/calibration.h"
#include "calib/deploy/detail/section.h"

namespace soak::calib::file {

// The sections that are not curves (docs/blob-format.md §4). The writers refuse what the format cannot carry; the
// readers take payloads that soak_load() has accepted.

[[nodiscard]] base::Result<Section> provenance_section(const Calibration& calibration);
void read_provenance(const std::uint8_t* payload, Calibration& calibration);

[[nodiscard]] base::Result<Section> sensor_section(const SensorCalibration& sensor);
[[nodiscard]] SensorCalibration read_sensor(const std::uint8_t* payload);

[[nodiscard]] base::Result<Section> uncertainty_section(Sensor sensor, Quantity quantity,
                                                        const UncertaintyTable& table);
[[nodiscard]] UncertaintyTable read_uncertainty(const std::uint8_t* payload);

using Matrix3 = std::array<Vector3, 3>;
[[nodiscard]] base::Result<Section> misalignment_section(const Matrix3& misalignment);
[[nodiscard]] base::Result<Section> g_sensitivity_section(const Matrix3& g_sensitivity);
[[nodiscard]] Matrix3 read_matrix(const std::uint8_t* payload);

[[nodiscard]] base::Result<Section> term_section(const AcceptedTerm& term);
/// soak_load() does not look into terms: this reader checks, and refuses as corrupt.
[[nodiscard]] base::Result<AcceptedTerm> read_term(std::span<const std::uint8_t> payload);

}  // namespace soak::calib::file
