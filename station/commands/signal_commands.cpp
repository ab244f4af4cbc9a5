// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "base/text.h"
#include "station/commands/command.h"
#include "station/commands/shared.h"
#include "station/commands/signal_text.h"
#include "station/io/data_folder.h"
#include "station/io/text_file.h"
#include "station/runs/signal_source.h"

namespace soak::station {
namespace {

constexpr double kLargestListed = 1e12;

/// What to analyse: a column of a CSV file or a channel of a stored run.
struct SignalCommand : Command {
  std::string file;  ///< empty: a stored run
  std::string column;
  std::optional<double> rate_hz;  ///< of a CSV file
  RunPart part;

  void declare(OptionList& options) override;

  /// The samples; remarks on them are told to the user.
  base::Result<calib::SignalRecord> read_signal(Output& output) const;

  /// Prints the document that `analyse` makes of the samples, as JSON or as the text that `describe` makes of it.
  template <class Request>
  base::Status print_analysis(const Request& request,
                              base::Result<nlohmann::json> (*analyse)(const calib::SignalRecord&, const Request&),
                              std::string (*describe)(const nlohmann::json&), Output& output) const;
};

void SignalCommand::declare(OptionList& options) {
  options.add("file FILE.csv", &file, "CSV file with a header line");
  options.add("--run RUN", &part.run.run, "Instead of a file: a stored run (id, unique beginning of one, or label)")
      .excludes("file");
  options.require_one_of({"file", "--run"}, "a FILE.csv or --run RUN");
  options.add("--column C", &column, "Column of the file, or channel of the run such as gyro_x").required();
  options
      .add("--rate-hz R", &rate_hz, "Samples per second; needed only if the file has no time column (t_s, t_ms, t_us)")
      .range(1e-9, 1e9)
      .excludes("--run");
  options.add("--unit SN", &part.run.unit, "Unit of the run, if several have this label").needs("--run");
  options.add("--campaign NAME", &part.run.campaign, "Campaign of the run").needs("--run");
  options.add("--visit N", &part.visit, "Only this visit of the run (number of the plateau, from 0)").needs("--run");
  options.add("--position P", &part.position, "Only this position of the run").needs("--run");
}

base::Result<calib::SignalRecord> SignalCommand::read_signal(Output& output) const {
  const auto read = [this]() -> base::Result<calib::SignalRecord> {
    if (!file.empty()) return read_csv_signal(file, column, rate_hz);
    const auto catalog = open_existing_catalog(data);
    if (!catalog) return base::forward_error(catalog);
    return read_run_signal(*catalog, part, column);
  };
  auto record = read();
  if (!record) return record;
  for (const std::string& remark : record->remarks) output.note(record->column + ": " + remark);
  return record;
}

base::Status not_interrupted() {
  if (interrupted()) return base::fail(base::ErrorKind::internal, "interrupted: nothing was printed or written");
  return {};
}

template <class Request>
base::Status SignalCommand::print_analysis(const Request& request,
                                           base::Result<nlohmann::json> (*analyse)(const calib::SignalRecord&,
                                                                                   const Request&),
                                           std::string (*describe)(const nlohmann::json&), Output& output) const {
  const auto record = read_signal(output);
  if (!record) return base::forward_error(record);
  const auto document = analyse(*record, request);
  if (!document) return base::forward_error(document);
  if (auto status = not_interrupted(); !status) return status;
  if (output.json()) return output.print_json(*document);
  output.print(describe(*document));
  return {};
}

/// soak signal allan
struct SignalAllan final : SignalCommand {
  calib::AllanRequest request;

  void declare(OptionList& options) override {
    SignalCommand::declare(options);
    options.add(
        "--taus A[,B...]",
        number_list(request.taus_s, 0.0, kLargestListed, "averaging times in s separated by commas, such as 1,10,100"),
        "Averaging times in s (default: log-spaced)");
    options.add("--phase", &request.phase, "The column is an angle or velocity, not a rate");
  }
  base::Status run(Output& output) override { return print_analysis(request, calib::allan_json, allan_text, output); }
};

/// A second analysis, of the signal after denoising by wavelets: wanted where a level is given.
struct AfterDenoising {
  calib::WmraRequest request;
  std::optional<std::size_t> level;

  void declare(OptionList& options) {
    options.add("--wavelet W", &request.wavelet, "db1 to db10 or sym2 to sym10").with_default().needs("--level");
    options.add("--level L", &level, "Also analyse the signal denoised by wavelets down to this level (soft threshold)")
        .range(1, 40);
  }
  [[nodiscard]] std::optional<calib::WmraRequest> wanted() const {
    if (!level) return std::nullopt;
    calib::WmraRequest denoise = request;
    denoise.options.levels = *level;
    return denoise;
  }
};

/// soak signal psd
struct SignalPsd final : SignalCommand {
  calib::PsdRequest request;
  AfterDenoising after;

  void declare(OptionList& options) override {
    SignalCommand::declare(options);
    options.add("--section N", &request.section, "Samples per section (default: 4096, or as many as fit)")
        .range(8, 1 << 28);
    after.declare(options);
  }
  base::Status run(Output& output) override {
    request.after = after.wanted();
    return print_analysis(request, calib::psd_json, psd_text, output);
  }
};

/// soak signal acf
struct SignalAcf final : SignalCommand {
  calib::AcfRequest request;
  AfterDenoising after;

  void declare(OptionList& options) override {
    SignalCommand::declare(options);
    options
        .add("--max-lag-s S", &request.longest_lag_s,
             "Longest lag (default: a tenth of the longest part without a gap)")
        .range(1e-9, 1e9);
    after.declare(options);
  }
  base::Status run(Output& output) override {
    request.after = after.wanted();
    return print_analysis(request, calib::acf_json, acf_text, output);
  }
};

/// soak signal wmra
struct SignalWmra final : SignalCommand {
  calib::WmraRequest request;
  std::string mode = "symmetric";
  std::string threshold = "soft";
  std::string noise = "finest";
  std::string output_file;  ///< CSV to write

  void declare(OptionList& options) override;
  base::Status run(Output& output) override;
};

void SignalWmra::declare(OptionList& options) {
  SignalCommand::declare(options);
  options.add("--wavelet W", &request.wavelet, "db1 to db10 or sym2 to sym10").with_default();
  options.add("--level L", &request.options.levels, "Number of levels; the trend is what is slower than 2^L samples")
      .range(1, 40)
      .with_default();
  options.add("--mode MODE", &mode, "How the signal is extended beyond its ends")
      .one_of({"symmetric", "periodization"})
      .with_default();
  options.add("--threshold RULE", &threshold, "How small wavelet coefficients are shrunk")
      .one_of({"soft", "hard", "garrote", "none"})
      .with_default();
  options.add("--threshold-value T", &request.options.threshold, "Threshold (default: the universal one)")
      .range(0.0, 1e300);
  options
      .add("--noise FROM", &noise,
           "Estimate the noise from the finest level (for white noise) or from each level (for coloured noise)")
      .one_of({"finest", "level"})
      .with_default();
  options.add("--relaxation A[,B...]",
              number_list(request.options.relaxation, 0.0, kLargestListed,
                          "factors of 0 or more separated by commas, the finest level first"),
              "Factor of each level's threshold, the finest first");
  options.add("-o,--output OUT.csv", &output_file, "CSV file to write").required();
}

std::string wmra_csv(const calib::WmraResult& result) {
  std::string csv = "t_s,raw,denoised,trend\n";
  for (std::size_t i = 0; i < result.t_s.size(); ++i) {
    csv += base::shortest(result.t_s[i]) + ',' + base::shortest(result.raw[i]) + ',' +
           base::shortest(result.denoised[i]) + ',' + base::shortest(result.trend[i]) + '\n';
  }
  return csv;
}

/// Fails if the output would overwrite the input: its other columns would be lost.
base::Status check_output_file(const SignalWmra& command) {
  std::error_code ignored;
  if (command.file.empty() || !std::filesystem::equivalent(command.file, command.output_file, ignored)) return {};
  return base::bad_input("must not be the input file", command.output_file);
}

double rms_difference(const std::vector<double>& a, const std::vector<double>& b) {
  double squares = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) squares += (a[i] - b[i]) * (a[i] - b[i]);
  return std::sqrt(squares / static_cast<double>(a.size()));
}

nlohmann::json wmra_document(const calib::SignalRecord& record, const SignalWmra& command,
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
          {"file", command.output_file}};
}

std::string wmra_text(const nlohmann::json& document) {
  const std::string unit = document["unit"];
  std::vector<std::vector<std::string>> table = {{"level", "noise " + unit, "threshold " + unit}};
  for (std::size_t level = 0; level < document["sigma"].size(); ++level) {
    table.push_back({std::to_string(level + 1), fmt::format("{:.4g}", document["sigma"][level].get<double>()),
                     fmt::format("{:.4g}", document["thresholds"][level].get<double>())});
  }
  return fmt::format(
      "{}: {} samples at {:.6g} Hz, {} part(s) without a gap, {} to level {}; removed {:.4g} {} RMS\n{}written "
      "to {}\n",
      document["column"].get<std::string>(), document["samples"].get<std::size_t>(), document["rate_hz"].get<double>(),
      document["stretches"].get<std::size_t>(), document["wavelet"].get<std::string>(),
      document["level"].get<std::size_t>(), document["removed_rms"].get<double>(), unit, text_table(table),
      document["file"].get<std::string>());
}

base::Status SignalWmra::run(Output& output) {
  using namespace calib::signal;
  calib::signal::DenoisingOptions& options = request.options;
  options.boundary = mode == "symmetric" ? Boundary::symmetric : Boundary::periodization;
  options.noise = noise == "finest" ? NoiseFrom::finest : NoiseFrom::per_level;
  options.shrinkage = threshold == "soft"      ? Shrinkage::soft
                      : threshold == "hard"    ? Shrinkage::hard
                      : threshold == "garrote" ? Shrinkage::garrote
                                               : Shrinkage::none;
  if (auto status = check_output_file(*this); !status) return status;
  const auto record = read_signal(output);
  if (!record) return base::forward_error(record);
  const auto result = calib::wmra(*record, request);
  if (!result) return base::forward_error(result);
  if (result->useful_levels < options.levels) {
    output.note(
        fmt::format("level {}: the longest part without a gap is long enough for only {} levels of {}; deeper levels "
                    "mainly show how the signal was extended at its ends",
                    options.levels, result->useful_levels, request.wavelet));
  }
  if (auto status = not_interrupted(); !status) return status;
  if (auto status = write_text_file(output_file, wmra_csv(*result)); !status) return status;
  const nlohmann::json document = wmra_document(*record, *this, *result);
  if (output.json()) return output.print_json(document);
  output.print(wmra_text(document));
  return {};
}

}  // namespace

CommandGroup signal_commands() {
  return {"signal",
          "Noise and trend of a signal: Allan deviations, spectrum, wavelets",
          {{"allan", "Allan deviations and noise coefficients with their 95 % intervals",
            "soak signal allan still.csv --column gx_dps --rate-hz 200 --json", std::make_shared<SignalAllan>()},
           {"psd", "One-sided power spectral density (Welch, Hann window)",
            "soak signal psd still.csv --column ax_mps2 --rate-hz 200", std::make_shared<SignalPsd>()},
           {"acf", "Autocorrelation, correlation time, Gauss-Markov fits",
            "soak signal acf --run soak_run_1 --column gyro_x --level 6", std::make_shared<SignalAcf>()},
           {"wmra", "Denoise by wavelets; writes t_s,raw,denoised,trend",
            "soak signal wmra still.csv --column gx_dps --rate-hz 200 --level 6 -o out.csv",
            std::make_shared<SignalWmra>()}}};
}

}  // namespace soak::station
