// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "base/result.h"
#include "calib/curve/calibration.h"
#include "nav/drive/drive.h"
#include "nav/outages/pipeline.h"
#include "station/nav/free_inertial.h"

/// Simulated drives on which a unit's own curves act.
namespace soak::station {

/// How many drives there are, and what happens on them, unless somebody asks for something else.
inline constexpr std::size_t kUnitDrives = 4;
inline constexpr std::size_t kOutagesOfUnitDrive = 6;
inline constexpr double kUnitOutage_s = 30.0;
inline constexpr double kFirstUnitOutage_s = 120.0;
inline constexpr std::size_t kUnitDriveSeed = 1;

/// Simulated drives of ten minutes through a town while the unit goes through the course of temperature (time constant
/// 200 s), 10 readings a second. On the readings act the calibration's curves, what it leaves of them (CurveResidual,
/// of each drive another one), and the other errors of an AHRS400CA [AH05 table 6.1]: the model knows the unit's
/// curves, not its noise. `number` ≥ 1. Drive d has the seed 1000·seed + d.
[[nodiscard]] std::vector<nav::Drive> unit_drives(const calib::Calibration& calibration,
                                                  const TemperatureCourse& course, std::size_t number,
                                                  std::size_t seed);

/// Takes the calibration's curves off readings, as long as `calibration` lives.
[[nodiscard]] nav::Correction correction_by(const calib::Calibration& calibration);

/// What the navigation filter of `raw` loses on unit_drives() in outages of satellite navigation, with the calibration
/// and without it: the pipelines `raw` and `calibrated` of `soak nav impact` with its defaults. Member `drives` of
/// docs/schema/report.schema.json: null where a sensor's uncertainty is not stated, as nobody knows then what the
/// calibration leaves. Some 0.2 s of processor time. Refuses (bad_input) curves beyond what an inertial unit reads;
/// fails (internal) where the filter finds no finite solution.
[[nodiscard]] base::Result<nlohmann::json> unit_drives_json(const calib::Calibration& calibration,
                                                            const TemperatureCourse& course);

}  // namespace soak::station
