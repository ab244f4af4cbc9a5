// SPDX-License-Identifier: Apache-2.0
#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <memory>
#include <utility>

#include "station/commands/frame.h"
#include "station/commands/number_list.h"
#include "station/commands/signal_commands.h"

namespace soak::station::cli {
namespace {

constexpr double kMost = 1e12;

/// Where the samples come from: options that all analyses have.
void add_input(CLI::App& command, SignalInput& input) {
  CLI::Option* file = command.add_option("file", input.file, "CSV file with a header line")->type_name("FILE.csv");
  CLI::Option* run = command
                         .add_option("--run", input.part.run.run,
                                     "Instead of a file: a stored run (id, unique beginning of one, or label)")
                         ->type_name("RUN");
  file->excludes(run);
  command.add_option("--column", input.column, "Column of the file, or channel of the run such as gyro_x")
      ->required()
      ->type_name("C");
  command
      .add_option("--rate-hz", input.rate_hz,
                  "Samples per second; needed only where the file has no time column (t_s, t_ms, t_us)")
      ->check(CLI::Range(1e-9, 1e9))
      ->type_name("R")
      ->excludes(run);
  command.add_option("--unit", input.part.run.unit, "Unit of the run, where several share its label")
      ->type_name("SN")
      ->needs(run);
  command.add_option("--campaign", input.part.run.campaign, "Campaign of the run")->type_name("NAME")->needs(run);
  command.add_option("--visit", input.part.visit, "Only this visit of the run (ordinal of the plateau)")
      ->type_name("N")
      ->needs(run);
  command.add_option("--position", input.part.position, "Only this position of the run")->type_name("P")->needs(run);
}

/// Makes `perform(options, output)` what the command does, once a file or a run is given and `complete(options)` has
/// turned the texts of the command line into what they mean.
template <class Options, class Complete>
void set_action(CLI::App& command, Request& request, std::shared_ptr<Options> options, const Complete& complete,
                base::Status (*perform)(const Options&, Output&)) {
  command.callback([options = std::move(options), complete, perform, &request] {
    if (options->input.file.empty() && !options->input.part.run.run) {
      throw CLI::RequiredError("a FILE.csv or --run RUN");
    }
    complete(*options);
    options->input.data = request.data;
    request.action = [options, perform](Output& output) { return perform(*options, output); };
  });
}

/// Options of how to split by wavelets. They act on `request` after parsing.
struct WmraOptions {
  std::string mode = "symmetric";
  std::string threshold = "soft";
  std::string noise = "finest";
  std::string relaxation;

  void apply(calib::WmraRequest& request) const {
    using namespace calib::signal;
    request.options.boundary = mode == "symmetric" ? Boundary::symmetric : Boundary::periodization;
    request.options.noise = noise == "finest" ? NoiseFrom::finest : NoiseFrom::per_level;
    request.options.shrinkage = threshold == "soft"      ? Shrinkage::soft
                                : threshold == "hard"    ? Shrinkage::hard
                                : threshold == "garrote" ? Shrinkage::garrote
                                                         : Shrinkage::none;
    if (relaxation.empty()) return;
    request.options.relaxation = parse_number_list("--relaxation", relaxation, 0.0, kMost,
                                                   "factors of 0 or more between commas, the finest level first");
  }
};

CLI::Option* add_wavelet(CLI::App& command, calib::WmraRequest& request) {
  return command.add_option("--wavelet", request.wavelet, "db1 to db10 or sym2 to sym10")
      ->capture_default_str()
      ->type_name("W");
}

void add_wmra_options(CLI::App& command, calib::WmraRequest& request, WmraOptions& options) {
  add_wavelet(command, request);
  command.add_option("--level", request.options.levels, "Levels: the trend is what is slower than 2^L samples")
      ->check(CLI::Range(1, 40))
      ->capture_default_str()
      ->type_name("L");
  command.add_option("--mode", options.mode, "How the signal goes on beyond its ends")
      ->check(CLI::IsMember({"symmetric", "periodization"}))
      ->capture_default_str()
      ->type_name("");
  command.add_option("--threshold", options.threshold, "What becomes of small details")
      ->check(CLI::IsMember({"soft", "hard", "garrote", "none"}))
      ->capture_default_str()
      ->type_name("");
  command.add_option("--threshold-value", request.options.threshold, "Threshold (else the universal one)")
      ->check(CLI::Range(0.0, 1e300))
      ->type_name("T");
  command
      .add_option("--noise", options.noise,
                  "Noise from the finest level, right for white noise, or from each level, for coloured noise")
      ->check(CLI::IsMember({"finest", "level"}))
      ->capture_default_str()
      ->type_name("");
  command.add_option("--relaxation", options.relaxation, "Factor of each level's threshold, the finest first")
      ->type_name("A[,B...]");
}

/// Asks for a second analysis after denoising: its wavelet and level.
struct AfterOptions {
  calib::WmraRequest request;
  bool wanted = false;
};

void add_after(CLI::App& command, AfterOptions& after) {
  CLI::Option* wavelet = add_wavelet(command, after.request);
  CLI::Option* level = command
                           .add_option("--level", after.request.options.levels,
                                       "Also of the signal denoised by wavelets down to this level (soft threshold)")
                           ->check(CLI::Range(1, 40))
                           ->type_name("L")
                           ->each([&after](const std::string&) { after.wanted = true; });
  wavelet->needs(level);
}

void register_allan(CLI::App& group, Request& request) {
  const auto options = std::make_shared<AllanCommand>();
  const auto taus = std::make_shared<std::string>();
  CLI::App* command =
      add_command(group, request, "allan", "Allan deviations and noise coefficients with their 95 % intervals",
                  "soak signal allan still.csv --column gx_dps --rate-hz 200 --json", true);
  add_input(*command, options->input);
  command->add_option("--taus", *taus, "Averaging times in s (else log-spaced)")->type_name("A[,B...]");
  command->add_flag("--phase", options->request.phase, "The column is an angle or velocity, not a rate");
  const auto complete = [taus](AllanCommand& given) {
    if (taus->empty()) return;
    given.request.taus_s =
        parse_number_list("--taus", *taus, 0.0, kMost, "averaging times in s between commas, such as 1,10,100");
  };
  set_action(*command, request, options, complete, run_signal_allan);
}

void register_psd(CLI::App& group, Request& request) {
  const auto options = std::make_shared<PsdCommand>();
  const auto after = std::make_shared<AfterOptions>();
  CLI::App* command = add_command(group, request, "psd", "One-sided power spectral density (Welch, Hann window)",
                                  "soak signal psd still.csv --column ax_mps2 --rate-hz 200", true);
  add_input(*command, options->input);
  command->add_option("--section", options->request.section, "Samples per section (else 4096 or what fits)")
      ->check(CLI::Range(8, 1 << 28))
      ->type_name("N");
  add_after(*command, *after);
  const auto complete = [after](PsdCommand& given) {
    if (after->wanted) given.request.after = after->request;
  };
  set_action(*command, request, options, complete, run_signal_psd);
}

void register_acf(CLI::App& group, Request& request) {
  const auto options = std::make_shared<AcfCommand>();
  const auto after = std::make_shared<AfterOptions>();
  CLI::App* command = add_command(group, request, "acf", "Autocorrelation, correlation time, Gauss-Markov fits",
                                  "soak signal acf --run soak_run_1 --column gyro_x --level 6", true);
  add_input(*command, options->input);
  command
      ->add_option("--max-lag-s", options->request.longest_lag_s, "Longest lag (else a tenth of the longest stretch)")
      ->check(CLI::Range(1e-9, 1e9))
      ->type_name("S");
  add_after(*command, *after);
  const auto complete = [after](AcfCommand& given) {
    if (after->wanted) given.request.after = after->request;
  };
  set_action(*command, request, options, complete, run_signal_acf);
}

void register_wmra(CLI::App& group, Request& request) {
  const auto options = std::make_shared<WmraCommand>();
  const auto how = std::make_shared<WmraOptions>();
  CLI::App* command =
      add_command(group, request, "wmra", "Denoise by wavelets; writes t_s,raw,denoised,trend",
                  "soak signal wmra still.csv --column gx_dps --rate-hz 200 --level 6 -o out.csv", true);
  add_input(*command, options->input);
  add_wmra_options(*command, options->request, *how);
  command->add_option("-o,--output", options->file, "CSV file to write")->required()->type_name("OUT.csv");
  const auto complete = [how](WmraCommand& given) { how->apply(given.request); };
  set_action(*command, request, options, complete, run_signal_wmra);
}

}  // namespace

void register_signal(CLI::App& program, Request& request) {
  CLI::App* group = add_group(program, "signal", "Noise and trend of a signal: Allan deviations, spectrum, wavelets");
  register_allan(*group, request);
  register_psd(*group, request);
  register_acf(*group, request);
  register_wmra(*group, request);
}

}  // namespace soak::station::cli
