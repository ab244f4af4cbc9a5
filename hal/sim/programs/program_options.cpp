// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/programs/programs.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/text.h"
#include "settings/reader.h"

namespace soak::hal::sim {
namespace {

bool contains(const std::vector<std::string_view>& names, std::string_view name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

base::Result<std::int64_t> whole_value(std::string_view name, const std::string& text, std::int64_t low,
                                       std::int64_t high) {
  const auto value = base::parse_int(text);
  if (!value || *value < low || *value > high) {
    return base::bad_input(
        fmt::format("option {} must be a whole number from {} to {}, not '{}'", name, low, high, text));
  }
  return *value;
}

}  // namespace

ProgramOutcome failed_program(std::string_view name, const base::Error& error) {
  const std::string where = error.where.empty() ? "" : error.where + ": ";
  return {static_cast<int>(error.kind), "", fmt::format("{}: {}{}\n", name, where, error.message)};
}

base::Result<ProgramOptions> ProgramOptions::parse(const std::vector<std::string>& arguments,
                                                   const std::vector<std::string_view>& names,
                                                   const std::vector<std::string_view>& lists) {
  ProgramOptions options;
  std::size_t i = 0;
  while (i < arguments.size()) {
    const std::string& name = arguments[i++];
    const bool is_list = contains(lists, name);
    if (!is_list && !contains(names, name)) return base::bad_input(fmt::format("unknown option '{}'", name));
    if (!is_list && options.values_.contains(name)) {
      return base::bad_input(fmt::format("option {} is given twice", name));
    }
    if (i == arguments.size()) return base::bad_input(fmt::format("option {} needs a value", name));
    std::vector<std::string>& values = options.values_[name];
    values.push_back(arguments[i++]);
    while (is_list && i < arguments.size() && !arguments[i].starts_with("--")) values.push_back(arguments[i++]);
  }
  return options;
}

std::optional<std::string> ProgramOptions::text(std::string_view name) const {
  const auto given = values_.find(name);
  if (given == values_.end()) return std::nullopt;
  return given->second.front();
}

base::Result<std::string> ProgramOptions::required(std::string_view name, std::string_view meaning) const {
  const auto value = text(name);
  if (!value || value->empty()) return base::bad_input(fmt::format("option {} is required: {}", name, meaning));
  return *value;
}

base::Result<std::optional<std::int64_t>> ProgramOptions::whole(std::string_view name, std::int64_t low,
                                                                std::int64_t high) const {
  const auto given = text(name);
  if (!given) return std::optional<std::int64_t>();
  const auto value = whole_value(name, *given, low, high);
  if (!value) return base::forward_error(value);
  return std::optional<std::int64_t>(*value);
}

base::Result<std::vector<std::int64_t>> ProgramOptions::wholes(std::string_view name, std::int64_t low,
                                                               std::int64_t high) const {
  std::vector<std::int64_t> numbers;
  const auto given = values_.find(name);
  if (given == values_.end()) return numbers;
  for (const std::string& text : given->second) {
    const auto value = whole_value(name, text, low, high);
    if (!value) return base::forward_error(value);
    numbers.push_back(*value);
  }
  return numbers;
}

std::vector<std::string> ProgramOptions::texts(std::string_view name) const {
  const auto given = values_.find(name);
  return given == values_.end() ? std::vector<std::string>() : given->second;
}

base::Result<CampaignConfig> configured(const ProgramOptions& options, int max_units) {
  auto config =
      read_campaign_config(options.text("--config").value_or(settings::shipped("lab.toml", SOAK_SIM_LAB_TOML)));
  if (!config) return config;
  if (const auto status = options.override_whole("--seed", 0, kMaxSeed, config->seed); !status) {
    return base::forward_error(status);
  }
  if (const auto status = options.override_whole("--units", 1, max_units, config->units); !status) {
    return base::forward_error(status);
  }
  return config;
}

}  // namespace soak::hal::sim
