// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "base/result.h"
#include "calib/signal/documents/signal_json.h"
#include "station/io/output.h"
#include "station/runs/signal_source.h"

namespace soak::station {

/// What to analyse: a column of a CSV file or a channel of a stored run.
struct SignalInput {
  std::string data;
  std::string file;  ///< empty: a stored run
  std::string column;
  std::optional<double> rate_hz;  ///< of a CSV file
  RunPart part;
};

/// soak signal allan
struct AllanCommand {
  SignalInput input;
  calib::AllanRequest request;
};

/// soak signal psd
struct PsdCommand {
  SignalInput input;
  calib::PsdRequest request;
};

/// soak signal acf
struct AcfCommand {
  SignalInput input;
  calib::AcfRequest request;
};

/// soak signal wmra
struct WmraCommand {
  SignalInput input;
  calib::WmraRequest request;
  std::string file;  ///< CSV to write
};

[[nodiscard]] base::Status run_signal_allan(const AllanCommand& command, Output& output);
[[nodiscard]] base::Status run_signal_psd(const PsdCommand& command, Output& output);
[[nodiscard]] base::Status run_signal_acf(const AcfCommand& command, Output& output);
[[nodiscard]] base::Status run_signal_wmra(const WmraCommand& command, Output& output);

/// Tables of the documents for people.
[[nodiscard]] std::string allan_text(const nlohmann::json& document);
[[nodiscard]] std::string psd_text(const nlohmann::json& document);
[[nodiscard]] std::string acf_text(const nlohmann::json& document);

}  // namespace soak::station
