// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/bytes.h"
#include "base/result.h"
#include "calib/vocabulary/sensor.h"
#include "nav/drive/drive.h"
#include "nav/learned/error_model.h"
#include "nav/outages/outage_runner.h"
#include "nav/outages/pipeline.h"

namespace soak::station {

/// An outage of a drive.
struct OutageTask {
  std::size_t drive = 0;  ///< index
  nav::Outage outage;
};

/// Runs all outages on up to `jobs` threads (0: as many as processors). The results are in the order of the tasks and
/// do not depend on the number of threads. `progress` is told the share done, from the calling thread. Fails with the
/// first error in that order, and (internal) when the user interrupts.
[[nodiscard]] base::Result<std::vector<nav::OutageResult>> run_outages(std::span<const nav::Drive> drives,
                                                                       std::span<const OutageTask> tasks,
                                                                       std::span<const nav::Pipeline> pipelines,
                                                                       int jobs,
                                                                       const std::function<bool(double)>& progress);

/// The pipelines that every comparison has: `raw`; `calibrated` where there is a calibration; `physics`, with it too.
[[nodiscard]] std::vector<nav::Pipeline> standard_pipelines(const std::optional<nav::Correction>& calibration);

/// The filter of `raw`.
[[nodiscard]] nav::FilterPipeline raw_filter();

/// An ANFIS that expects the errors of raw_filter(), learnt from outages of 30 s that follow each other on all drives.
/// At least one drive. Fails as nav::align() does, and (bad_input) where the drives hold too few outages.
[[nodiscard]] base::Result<nav::ErrorModel> learnt_errors(std::span<const nav::Drive> drives);

/// Further pipelines by name, all with raw_filter() and readings as they are: those of the thesis.
inline constexpr const char* kFurtherPipelines[] = {"wmra", "wmra_batch", "anfis_position", "anfis_updates"};
/// Whether one of the names needs learnt_errors().
[[nodiscard]] bool needs_learning(std::span<const std::string> names);
/// The pipelines of these names, in the order of kFurtherPipelines; `model` where needs_learning().
[[nodiscard]] std::vector<nav::Pipeline> further_pipelines(std::span<const std::string> names,
                                                           const std::optional<nav::ErrorModel>& model);

/// What a calibration file does to samples.
struct DeviceCorrection {
  nav::Correction correct;
  /// Whether the temperature lies outside the calibration of a sensor that is corrected: as at the end of its range.
  std::function<bool(double temp_c)> is_outside;
  std::vector<calib::Sensor> raw;  ///< sensors that pass through as they are: not in the file, or with thermometers of
                                   ///< their own
};

/// Corrects samples with a calibration file as firmware does (soak_apply); a sample without temperature, or one that
/// the runtime refuses, stays as it is. Fails (corrupt) where the runtime cannot load the file, and (bad_input) where
/// it corrects no sensor.
[[nodiscard]] base::Result<DeviceCorrection> device_correction(const base::Bytes& file);

}  // namespace soak::station
