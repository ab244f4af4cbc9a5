// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/campaign_program.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <map>
#include <string_view>

#include "base/number_text.h"
#include "base/result.h"
#include "hal/sim/campaign_config.h"
#include "hal/sim/campaign_files.h"

namespace soak::hal::sim {
namespace {

constexpr std::string_view kUsage =
    "usage: soaksim-campaign --out DIR [--seed N] [--units N] [--runs N] [--rows-per-position N] [--config FILE]\n"
    "Writes the recordings of a made-up soak campaign as CSV, and the truth about its units as JSON, into DIR.\n";

constexpr std::array<std::string_view, 6> kOptions = {"--out",   "--seed", "--units", "--runs", "--rows-per-position",
                                                      "--config"};

using OptionValues = std::map<std::string, std::string, std::less<>>;

base::Result<OptionValues> parse_options(const std::vector<std::string>& arguments) {
  OptionValues values;
  for (std::size_t i = 0; i < arguments.size(); i += 2) {
    const std::string& name = arguments[i];
    if (std::find(kOptions.begin(), kOptions.end(), name) == kOptions.end()) {
      return base::bad_input(fmt::format("unknown option '{}'", name));
    }
    if (i + 1 == arguments.size()) return base::bad_input(fmt::format("option {} needs a value", name));
    if (!values.emplace(name, arguments[i + 1]).second) {
      return base::bad_input(fmt::format("option {} is given twice", name));
    }
  }
  const auto out = values.find("--out");
  if (out == values.end() || out->second.empty())
    return base::bad_input("option --out is required: the folder to write");
  return values;
}

/// Replaces `target` by the value of an option, where that is given.
template <class Whole>
base::Status override_whole(const OptionValues& values, std::string_view name, std::int64_t low, std::int64_t high,
                            Whole& target) {
  const auto given = values.find(name);
  if (given == values.end()) return {};
  const auto value = base::parse_int(given->second);
  if (!value || *value < low || *value > high) {
    return base::bad_input(
        fmt::format("option {} must be a whole number from {} to {}, not '{}'", name, low, high, given->second));
  }
  target = static_cast<Whole>(*value);
  return {};
}

base::Result<CampaignConfig> configured(const OptionValues& values) {
  const auto file = values.find("--config");
  auto config = read_campaign_config(file == values.end() ? SOAK_SIM_CAMPAIGN_TOML : file->second);
  if (!config) return config;
  const std::array statuses = {
      override_whole(values, "--seed", 0, std::numeric_limits<std::int64_t>::max(), config->seed),
      override_whole(values, "--units", 1, kMaxUnits, config->units),
      override_whole(values, "--runs", 1, kMaxRuns, config->runs),
      override_whole(values, "--rows-per-position", 1, kMaxRowsPerPosition, config->rows_per_position),
  };
  for (const base::Status& status : statuses) {
    if (!status) return base::forward_error(status);
  }
  return config;
}

ProgramOutcome failed(const base::Error& error) {
  const std::string where = error.where.empty() ? "" : error.where + ": ";
  return {static_cast<int>(error.kind), "", fmt::format("soaksim-campaign: {}{}\n", where, error.message)};
}

}  // namespace

ProgramOutcome run_campaign_program(const std::vector<std::string>& arguments) {
  if (arguments.size() == 1 && arguments[0] == "--help") return {0, std::string(kUsage), ""};
  const auto values = parse_options(arguments);
  if (!values) {
    ProgramOutcome outcome = failed(values.error());
    outcome.errors += kUsage;
    return outcome;
  }
  const auto config = configured(*values);
  if (!config) return failed(config.error());
  const std::string& folder = values->find("--out")->second;
  if (const base::Status written = write_campaign(*config, folder); !written) return failed(written.error());
  return {0,
          fmt::format("{}: {} units, {} runs and a verification run each, seed {}\n", folder, config->units,
                      config->runs, config->seed),
          ""};
}

}  // namespace soak::hal::sim
