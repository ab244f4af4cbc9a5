// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/campaign_program.h"

#include <fmt/format.h>

#include <string_view>

#include "base/result.h"
#include "hal/sim/campaign_config.h"
#include "hal/sim/campaign_files.h"

namespace soak::hal::sim {
namespace {

constexpr std::string_view kName = "soaksim-campaign";
constexpr std::string_view kUsage =
    "usage: soaksim-campaign --out DIR [--seed N] [--units N] [--runs N] [--rows-per-position N] [--config FILE]\n"
    "Writes the recordings of a made-up soak campaign as CSV, and the truth about its units as JSON, into DIR.\n";

struct Order {
  std::string folder;
  ProgramOptions options;
};

base::Result<Order> parse_order(const std::vector<std::string>& arguments) {
  auto options =
      ProgramOptions::parse(arguments, {"--out", "--seed", "--units", "--runs", "--rows-per-position", "--config"});
  if (!options) return base::forward_error(options);
  const auto folder = options->required("--out", "the folder to write");
  if (!folder) return base::forward_error(folder);
  return Order{*folder, *std::move(options)};
}

base::Result<CampaignConfig> configured_campaign(const ProgramOptions& options) {
  auto config = configured(options, kMaxUnits);
  if (!config) return config;
  if (const auto status = options.override_whole("--runs", 1, kMaxRuns, config->runs); !status) {
    return base::forward_error(status);
  }
  const auto status = options.override_whole("--rows-per-position", 1, kMaxRowsPerPosition, config->rows_per_position);
  if (!status) return base::forward_error(status);
  return config;
}

}  // namespace

ProgramOutcome run_campaign_program(const std::vector<std::string>& arguments) {
  if (arguments.size() == 1 && arguments[0] == "--help") return {0, std::string(kUsage), ""};
  const auto order = parse_order(arguments);
  if (!order) {
    ProgramOutcome outcome = failed_program(kName, order.error());
    outcome.errors += kUsage;
    return outcome;
  }
  const auto config = configured_campaign(order->options);
  if (!config) return failed_program(kName, config.error());
  if (const base::Status written = write_campaign(*config, order->folder); !written) {
    return failed_program(kName, written.error());
  }
  return {0,
          fmt::format("{}: {} units, {} runs and a verification run each, seed {}\n", order->folder, config->units,
                      config->runs, config->seed),
          ""};
}

}  // namespace soak::hal::sim
