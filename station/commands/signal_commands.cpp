// SPDX-License-Identifier: Apache-2.0
#include "station/commands/signal_commands.h"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "base/text.h"
#include "station/io/data_folder.h"
#include "station/io/text_file.h"

namespace soak::station {
namespace {

base::Result<calib::SignalRecord> read_input(const SignalInput& input) {
  if (!input.file.empty()) return read_csv_signal(input.file, input.column, input.rate_hz);
  const auto catalog = open_existing_catalog(input.data);
  if (!catalog) return base::forward_error(catalog);
  return read_run_signal(*catalog, input.part, input.column);
}

/// The input, with remarks on it told to the user.
base::Result<calib::SignalRecord> read(const SignalInput& input, Output& output) {
  auto record = read_input(input);
  if (!record) return record;
  for (const std::string& remark : record->remarks) output.note(record->column + ": " + remark);
  return record;
}

base::Status not_interrupted() {
  if (interrupted()) return base::fail(base::ErrorKind::internal, "interrupted: nothing was printed or written");
  return {};
}

/// Prints the document that `analyse` makes of the input, as JSON or as the text that `describe` makes of it.
template <class Request>
base::Status show(const SignalInput& input, const Request& request,
                  base::Result<nlohmann::json> (*analyse)(const calib::SignalRecord&, const Request&),
                  std::string (*describe)(const nlohmann::json&), Output& output) {
  const auto record = read(input, output);
  if (!record) return base::forward_error(record);
  const auto document = analyse(*record, request);
  if (!document) return base::forward_error(document);
  if (auto status = not_interrupted(); !status) return status;
  if (output.json()) return output.print_json(*document);
  output.print(describe(*document));
  return {};
}

std::string wmra_csv(const calib::WmraResult& result) {
  std::string csv = "t_s,raw,denoised,trend\n";
  for (std::size_t i = 0; i < result.t_s.size(); ++i) {
    csv += base::shortest(result.t_s[i]) + ',' + base::shortest(result.raw[i]) + ',' +
           base::shortest(result.denoised[i]) + ',' + base::shortest(result.trend[i]) + '\n';
  }
  return csv;
}

/// Refuses to write over what is read: the other columns would be lost.
base::Status check_output(const WmraCommand& command) {
  std::error_code ignored;
  if (command.input.file.empty() || !std::filesystem::equivalent(command.input.file, command.file, ignored)) return {};
  return base::bad_input("this is the file that is read: give another name", command.file);
}

double rms_difference(const std::vector<double>& a, const std::vector<double>& b) {
  double squares = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) squares += (a[i] - b[i]) * (a[i] - b[i]);
  return std::sqrt(squares / static_cast<double>(a.size()));
}

nlohmann::json wmra_document(const calib::SignalRecord& record, const WmraCommand& command,
                             const calib::WmraResult& result) {
  return {{"column", record.column},
          {"unit", record.unit},
          {"rate_hz", record.rate_hz},
          {"samples", result.raw.size()},
          {"stretches", result.stretches},
          {"wavelet", command.request.wavelet},
          {"level", command.request.options.levels},
          {"sigma", result.sigma},
          {"thresholds", result.thresholds},
          {"removed_rms", rms_difference(result.raw, result.denoised)},
          {"file", command.file}};
}

std::string wmra_text(const nlohmann::json& document) {
  const std::string unit = document["unit"];
  std::vector<std::vector<std::string>> table = {{"level", "noise " + unit, "threshold " + unit}};
  for (std::size_t level = 0; level < document["sigma"].size(); ++level) {
    table.push_back({std::to_string(level + 1), fmt::format("{:.4g}", document["sigma"][level].get<double>()),
                     fmt::format("{:.4g}", document["thresholds"][level].get<double>())});
  }
  return fmt::format(
      "{}: {} samples at {:.6g} Hz, {} stretch(es) without a gap, {} to level {}; took away {:.4g} {} RMS\n{}written "
      "to {}\n",
      document["column"].get<std::string>(), document["samples"].get<std::size_t>(), document["rate_hz"].get<double>(),
      document["stretches"].get<std::size_t>(), document["wavelet"].get<std::string>(),
      document["level"].get<std::size_t>(), document["removed_rms"].get<double>(), unit, text_table(table),
      document["file"].get<std::string>());
}

}  // namespace

base::Status run_signal_allan(const AllanCommand& command, Output& output) {
  return show(command.input, command.request, calib::allan_json, allan_text, output);
}

base::Status run_signal_psd(const PsdCommand& command, Output& output) {
  return show(command.input, command.request, calib::psd_json, psd_text, output);
}

base::Status run_signal_acf(const AcfCommand& command, Output& output) {
  return show(command.input, command.request, calib::acf_json, acf_text, output);
}

base::Status run_signal_wmra(const WmraCommand& command, Output& output) {
  if (auto status = check_output(command); !status) return status;
  const auto record = read(command.input, output);
  if (!record) return base::forward_error(record);
  const auto result = calib::wmra(*record, command.request);
  if (!result) return base::forward_error(result);
  if (result->useful_levels < command.request.options.levels) {
    output.note(
        fmt::format("level {}: the longest stretch carries {} levels of {}; beyond, what is seen is the ends of the "
                    "signal mirrored",
                    command.request.options.levels, result->useful_levels, command.request.wavelet));
  }
  if (auto status = not_interrupted(); !status) return status;
  if (auto status = write_text_file(command.file, wmra_csv(*result)); !status) return status;
  const nlohmann::json document = wmra_document(*record, command, *result);
  if (output.json()) return output.print_json(document);
  output.print(wmra_text(document));
  return {};
}

}  // namespace soak::station
