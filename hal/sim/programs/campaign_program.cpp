// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/programs/programs.h"

#include <fmt/format.h>

#include <string_view>

#include "base/result.h"
#include "hal/sim/campaign/campaign_files.h"
#include "hal/sim/config/campaign_config.h"
#include "hal/sim/design/design_files.h"

namespace soak::hal::sim {
namespace {

constexpr std::string_view kCampaignProgram = "soaksim-campaign";
constexpr std::string_view kCampaignUsage =
    R"(usage: soaksim-campaign --out DIR [--seed N] [--units N] [--runs N] [--rows-per-position N] [--config FILE]
                        [--design KIND] [--truth FILE]
Writes the recordings of a simulated soak campaign as CSV, and the truth about its units as JSON, into DIR.

  --design KIND  write a campaign of the blind benchmark instead: identical, mixed, three, one or missing_logs. Replaces
                 design.kind of the configuration. A configuration with [design], [[hidden]] or [[candidate]] does the same.
  --truth FILE   write what is hidden in such a campaign to this file and nowhere else
)";

struct CampaignOrder {
  std::string folder;
  ProgramOptions options;
};

base::Result<CampaignOrder> parse_campaign_order(const std::vector<std::string>& arguments) {
  auto options = ProgramOptions::parse(
      arguments, {"--out", "--seed", "--units", "--runs", "--rows-per-position", "--config", "--design", "--truth"});
  if (!options) return base::forward_error(options);
  const auto folder = options->required("--out", "the folder to write");
  if (!folder) return base::forward_error(folder);
  return CampaignOrder{*folder, *std::move(options)};
}

/// The design that the options or the configuration ask for; none where neither does.
base::Status choose_design(const ProgramOptions& options, CampaignConfig& config) {
  const auto name = options.text("--design");
  if (name) {
    const auto kind = design_kind_named(*name);
    if (!kind) {
      return base::bad_input(
          fmt::format("option --design must be identical, mixed, three, one or missing_logs, not '{}'", *name));
    }
    if (!config.design) config.design = default_design(*kind);
    if (config.design->kind != *kind) config.design->runs = usual_runs(*kind);
    config.design->kind = *kind;
  }
  const bool effects = !config.hidden.empty() || !config.candidates.empty();
  if (!config.design && effects) config.design = default_design(DesignKind::identical);
  return {};
}

base::Status refuse_other_kind(const ProgramOptions& options, bool designed) {
  if (designed && options.text("--rows-per-position")) {
    return base::bad_input("option --rows-per-position cannot be combined with a design, whose blocks have six rows");
  }
  if (!designed && options.text("--truth")) {
    return base::bad_input(
        "option --truth needs a design (--design, [design] or [[hidden]]); without one, DIR holds truth.json");
  }
  return {};
}

base::Result<CampaignConfig> configured_campaign(const ProgramOptions& options) {
  auto config = configured(options, kMaxUnits);
  if (!config) return config;
  const auto status =
      choose_design(options, *config)
          .and_then([&] { return refuse_other_kind(options, config->design.has_value()); })
          .and_then([&] {
            return config->design ? options.override_whole("--runs", 1, kMaxDesignRuns, config->design->runs)
                                  : options.override_whole("--runs", 1, kMaxRuns, config->runs);
          })
          .and_then([&] {
            return options.override_whole("--rows-per-position", 1, kMaxRowsPerPosition, config->rows_per_position);
          });
  if (!status) return base::forward_error(status);
  return config;
}

base::Status write_recordings(const CampaignConfig& config, const CampaignOrder& order) {
  if (config.design) return write_designed_campaign(config, order.folder, order.options.text("--truth"));
  return write_campaign(config, order.folder);
}

std::string summary(const CampaignConfig& config, const std::string& folder) {
  if (config.design) {
    return fmt::format("{}: {} units, design {}, {} runs, seed {}\n", folder, config.units,
                       name_of(config.design->kind), config.design->runs, config.seed);
  }
  return fmt::format("{}: {} units, {} runs and a verification run each, seed {}\n", folder, config.units, config.runs,
                     config.seed);
}

}  // namespace

ProgramOutcome run_campaign_program(const std::vector<std::string>& arguments) {
  if (arguments.size() == 1 && arguments[0] == "--help") return {0, std::string(kCampaignUsage), ""};
  const auto order = parse_campaign_order(arguments);
  if (!order) {
    ProgramOutcome outcome = failed_program(kCampaignProgram, order.error());
    outcome.errors += kCampaignUsage;
    return outcome;
  }
  const auto config = configured_campaign(order->options);
  if (!config) return failed_program(kCampaignProgram, config.error());
  if (const base::Status written = write_recordings(*config, *order); !written)
    return failed_program(kCampaignProgram, written.error());
  return {0, summary(*config, order->folder), ""};
}

}  // namespace soak::hal::sim
