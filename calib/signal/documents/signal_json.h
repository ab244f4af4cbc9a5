// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "calib/signal/wavelet/denoising.h"

namespace soak::calib {

/// One channel on an even grid of samples, as it is analysed and shown: in the unit that results are printed in.
struct SignalRecord {
  std::string column;  ///< what it is called where it comes from
  std::string unit;    ///< "deg/s", "m/s2"...; empty where nobody said
  double rate_hz = 0.0;
  std::vector<double> t_s;           ///< one per value
  std::vector<double> values;        ///< NaN = missing
  std::vector<std::string> remarks;  ///< what a reader must know of how the samples were found
};

/// What to ask of the Allan family.
struct AllanRequest {
  std::vector<double> taus_s;  ///< averaging times, made multiples of the sample interval; empty = log-spaced
  bool phase = false;          ///< values are the integral of the rate (angle, velocity) instead of the rate
};

/// How to denoise by wavelets before a second analysis.
struct WmraRequest {
  std::string wavelet = "db8";
  signal::DenoisingOptions options;
};

/// What to ask of the power spectral density. `section` samples per section; absent = 4096 or what the longest stretch
/// without a gap has room for.
struct PsdRequest {
  std::optional<std::size_t> section;
  std::optional<WmraRequest> after;  ///< also of the signal denoised like this [AH05 fig. 2.5]
};

/// What to ask of the autocorrelation. `longest_lag_s` absent = a tenth of the longest stretch without a gap.
struct AcfRequest {
  std::optional<double> longest_lag_s;
  std::optional<WmraRequest> after;
};

/// The document of `soak signal allan --json` (docs/schema/signal-allan.schema.json): plain, overlapping and modified
/// Allan and overlapping Hadamard deviations, the interval of the overlapping one, and the noise coefficients fitted to
/// it with theirs. Refuses too short a record, and averaging times that are not positive or longer than it carries.
[[nodiscard]] base::Result<nlohmann::json> allan_json(const SignalRecord& record, const AllanRequest& request);

/// The document of `soak signal psd --json` (docs/schema/signal-psd.schema.json). Gaps of up to 5 samples are filled by
/// a straight line; sections with a longer one are left out.
[[nodiscard]] base::Result<nlohmann::json> psd_json(const SignalRecord& record, const PsdRequest& request);

/// The document of `soak signal acf --json` (docs/schema/signal-acf.schema.json): autocorrelation of the record less
/// the mean of each stretch, its fall to 1/e, and first- and second-order Gauss-Markov fits; null where there is none.
[[nodiscard]] base::Result<nlohmann::json> acf_json(const SignalRecord& record, const AcfRequest& request);

/// A record split by wavelets, stretch by stretch, with the samples that are missing left out.
struct WmraResult {
  std::vector<double> t_s;
  std::vector<double> raw;
  std::vector<double> denoised;
  std::vector<double> trend;
  std::vector<double> sigma;       ///< noise level of each level's details in the longest stretch, finest first
  std::vector<double> thresholds;  ///< those of the longest stretch
  std::size_t stretches = 0;
  std::size_t useful_levels = 0;  ///< that the longest stretch carries
};

/// Denoises each stretch without a gap on its own (gaps of up to 5 samples are bridged by a straight line first, and
/// left out again). Refuses what denoise() refuses, and a wavelet that it does not know.
[[nodiscard]] base::Result<WmraResult> wmra(const SignalRecord& record, const WmraRequest& request);

}  // namespace soak::calib
