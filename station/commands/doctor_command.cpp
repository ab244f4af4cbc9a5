// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <filesystem>
#include <iterator>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "station/commands/command.h"
#include "station/commands/shared.h"
#include "station/config/config_place.h"
#include "station/io/data_folder.h"
#include "station/io/host.h"
#include "station/lab/doctor.h"

namespace soak::station {
namespace {

/// soak doctor [--config FILE]: fails with the most serious kind of failure: stored data before devices before the
/// rest.
struct DoctorCommand final : Command {
  std::string config;  ///< of the station; empty = devices are not checked

  void declare(OptionList& options) override {
    options.add("--config FILE", &config, "The station's configuration; without it devices are not checked");
  }
  base::Status run(Output& output) override;
};

std::string_view name_of_outcome(CheckOutcome outcome) {
  switch (outcome) {
    case CheckOutcome::ok:
      return "ok";
    case CheckOutcome::warning:
      return "warning";
    default:
      return "failed";
  }
}

/// The data folder: the option, else that of the configuration, else the default one.
std::string data_option(const DoctorCommand& command, const std::optional<StationConfig>& config) {
  if (!command.data.empty() || !config) return command.data;
  return config->data.string();
}

/// The configuration; mistakes in it are a failed check like others.
std::optional<StationConfig> read_config(const DoctorCommand& command, std::vector<DoctorCheck>& checks) {
  if (command.config.empty()) return std::nullopt;
  const auto place = place_of_config(command.config, command.data);
  // The template of a station that is not set up yet is looked at as it is: somebody may be about to edit it.
  auto config = read_station_config(place && place->is_there ? place->file : std::filesystem::path(command.config));
  if (config && config->data.empty() && place) config->data = place->data;
  if (config) return *std::move(config);
  const base::Error& error = config.error();
  checks.push_back({"configuration", CheckOutcome::failed,
                    error.where.empty() ? error.message : error.where + ": " + error.message, error.kind});
  return std::nullopt;
}

/// Whether the folder may be that of a station before its first start: the configuration names it, nothing is in it.
bool may_be_new(const DoctorCommand& command, const std::optional<StationConfig>& config,
                const std::filesystem::path& folder) {
  std::error_code failure;
  const bool is_there = std::filesystem::exists(folder, failure);
  return config && command.data.empty() && (!is_there || std::filesystem::is_empty(folder, failure));
}

base::Result<std::vector<DoctorCheck>> all_checks(const DoctorCommand& command) {
  std::vector<DoctorCheck> checks;
  const auto config = read_config(command, checks);
  if (config) {
    auto devices = check_devices(*config);
    std::move(devices.begin(), devices.end(), std::back_inserter(checks));
  }
  const std::string data = data_option(command, config);
  const auto folder = data_folder(data);
  if (!folder) return base::forward_error(folder);
  checks.push_back(check_disk_space(*folder));
  std::error_code ignored;
  if (!std::filesystem::exists(*folder / "station.db", ignored)) {
    checks.push_back(missing_catalog(*folder, may_be_new(command, config, *folder)));
    checks.push_back(check_clock(nullptr, now_utc_s()));
    return checks;
  }
  const auto catalog = open_existing_catalog(data);
  checks.push_back(check_database(catalog));
  checks.push_back(check_clock(catalog ? &*catalog : nullptr, now_utc_s()));
  return checks;
}

int seriousness(base::ErrorKind kind) {
  if (kind == base::ErrorKind::corrupt) return 3;
  if (kind == base::ErrorKind::device) return 2;
  return 1;
}

base::Status doctor_verdict(const std::vector<DoctorCheck>& checks) {
  const DoctorCheck* worst = nullptr;
  std::string subjects;
  for (const DoctorCheck& check : checks) {
    if (check.outcome != CheckOutcome::failed) continue;
    subjects += (subjects.empty() ? "" : ", ") + check.subject;
    if (worst == nullptr || seriousness(check.kind) > seriousness(worst->kind)) worst = &check;
  }
  if (worst == nullptr) return {};
  return base::fail(worst->kind, "failed: " + subjects, "doctor");
}

base::Status DoctorCommand::run(Output& output) {
  const auto checks = all_checks(*this);
  if (!checks) return base::forward_error(checks);
  base::Status status = doctor_verdict(*checks);
  if (output.json()) {
    nlohmann::json list = nlohmann::json::array();
    for (const DoctorCheck& check : *checks) {
      list.push_back({{"subject", check.subject}, {"finding", name_of_outcome(check.outcome)}, {"text", check.text}});
    }
    auto printed = output.print_json({{"ok", status.has_value()}, {"checks", std::move(list)}});
    return printed ? status : printed;
  }
  for (const DoctorCheck& check : *checks) {
    output.print(fmt::format("{:<8} {}: {}\n", name_of_outcome(check.outcome), check.subject, check.text));
  }
  return status;
}

}  // namespace

CommandGroup doctor_commands() {
  return {"",
          "",
          {{"doctor", "Check devices, permissions, disk, database and clock of this computer",
            "soak doctor --config station.toml", std::make_shared<DoctorCommand>()}}};
}

}  // namespace soak::station
