// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <chrono>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <system_error>
#include <thread>

#include "db/catalog/catalog.h"
#include "hal/devices/chamber.h"
#include "station/commands/command.h"
#include "station/config/station_config.h"
#include "station/http/client.h"
#include "station/io/data_folder.h"
#include "station/io/host.h"
#include "station/lab/make_safe.h"

namespace soak::station {
namespace {

using nlohmann::json;

/// soak chamber make-safe: the chamber of a station whose soakd is dead or lost, once and without waiting.
struct ChamberMakeSafe final : Command {
  std::string config;

  void declare(OptionList& options) override {
    options.add("--config FILE", &config,
                "Station configuration, as for soakd (default, and while FILE is the template: station.toml in the "
                "data folder); [room] sets the safe "
                "temperature");
  }
  base::Status run(Output& output) override;
};

constexpr int kSoakdAnswers_s = 3;
constexpr std::chrono::seconds kSoakdMoves{10};  ///< a station's status changes ten times a second
constexpr std::chrono::milliseconds kLookAgain{500};

/// Whether the soakd at that address has the chamber in hand: it answers, the chamber answers it, and its engine turns.
bool has_chamber_in_hand(const std::string& address) {
  const auto where = parse_station_address(address);
  if (!where) return false;
  StationEntry entry(*where);
  // The address is from the lock of soakd itself, and nothing secret is sent. The certificate file may have been
  // replaced since soakd read it, which is no reason to take the chamber out of its hands.
  entry.any_certificate = true;
  const Client client(entry, kSoakdAnswers_s);
  const auto first = client.get("alive");
  const auto deadline = std::chrono::steady_clock::now() + kSoakdMoves;
  while (first && std::chrono::steady_clock::now() < deadline) {
    std::this_thread::sleep_for(kLookAgain);
    const auto now = client.get("alive");
    if (!now) return false;
    if (now->at("turn") != first->at("turn")) return now->value("chamber_connected", false);
  }
  return false;
}

std::string_view name_of(SafeAction action) {
  constexpr std::array<std::string_view, 3> kNames = {"driven", "switched_off", "left_off"};
  return kNames.at(static_cast<std::size_t>(action));
}

/// One or two sentences: what was commanded, and what the chamber says of itself.
std::string sentence(const std::string& chamber, const MadeSafe& made, const StationConfig& config) {
  const std::string reads =
      made.reading ? fmt::format("it reads {:+.1f} °C", made.reading->air_c) : std::string("it cannot be read");
  const std::string door =
      fmt::format("Keep the door shut until the units are above the dew point of the room ({:+.0f} °C{}).",
                  config.dew_point_c, config.dew_point_assumed ? ", assumed, as none is stated" : "");
  switch (made.action) {
    case SafeAction::driven:
      return fmt::format(
          "{} is driven to {:+.1f} °C; {} now. Heating and cooling stay on after it arrives. Run this command again "
          "then, or start soakd, which switches them off. {}",
          chamber, made.target_c, reads, door);
    case SafeAction::switched_off:
      return fmt::format("{}: heating and cooling were switched off ({}); {}. {}", chamber, made.why_off, reads, door);
    case SafeAction::left_off:
      return fmt::format("{}: heating and cooling were off and stay off; {}. {}", chamber, reads, door);
  }
  return {};
}

json document(const std::string& chamber, const MadeSafe& made, bool beside_soakd, const std::string& text) {
  const auto& reading = made.reading;
  json alarms = json::array();
  if (reading) {
    for (const hal::ChamberAlarm& alarm : reading->alarms) alarms.push_back(alarm.name);
  }
  return {{"chamber", chamber},
          {"action", name_of(made.action)},
          {"why_off", made.why_off.empty() ? json() : json(made.why_off)},
          {"safe_temp_c", made.target_c},
          {"air_c", reading ? json(reading->air_c) : json()},
          {"set_point_c", reading ? json(reading->set_point_c) : json()},
          {"output_percent", reading ? number_or_null(reading->output_percent) : json()},
          {"running", reading ? json(reading->running) : json()},
          {"alarms", std::move(alarms)},
          {"beside_soakd", beside_soakd},
          {"text", text}};
}

/// To the event log of the data folder, if there is one: after the chamber, which must not wait for a disk.
void log_event(const std::filesystem::path& data, const std::string& text, Output& output) {
  std::error_code failure;
  if (!std::filesystem::exists(data / "station.db", failure)) return;
  auto catalog = db::Catalog::open(data);
  const auto logged =
      catalog ? catalog->log_event({now_utc_s(), "chamber", "make-safe", user_name() + ": " + text, user_name()})
              : base::forward_error(catalog);
  if (!logged) output.note("not written to the event log: " + logged.error().message);
}

base::Status ChamberMakeSafe::run(Output& output) {
  const auto station = find_station_config(config, data);
  if (!station) return base::forward_error(station);
  const auto holder = FolderLock::holder(station->data / "soakd.lock");
  if (holder && has_chamber_in_hand(holder->address)) {
    return base::bad_input(fmt::format("soakd (process {}, {}) is running and controls this chamber: use 'soak "
                                       "campaign abort', or stop soakd; both bring the chamber to the safe state",
                                       holder->process, holder->address),
                           station->data.string());
  }
  if (holder) {
    output.note(fmt::format("soakd (process {}) holds {} but does not control the chamber: going on without it",
                            holder->process, station->data.string()));
  }
  const auto chamber = hal::make_chamber(station->chamber);
  if (!chamber) return base::forward_error(chamber);
  const auto made = make_chamber_safe(**chamber, station->dew_point_c);
  if (!made) {
    log_event(station->data, made.error().message, output);
    return base::forward_error(made);
  }
  const std::string text = sentence((*chamber)->description(), *made, *station);
  auto printed = output.json() ? output.print_json(document((*chamber)->description(), *made, holder.has_value(), text))
                               : base::Status{};
  if (!output.json()) output.print(text + "\n");
  output.flush();
  log_event(station->data, text, output);
  return printed;
}

}  // namespace

CommandGroup make_safe_commands() {
  return {"chamber",
          "",
          {{"make-safe", "Bring the station's chamber into the safe state while soakd is dead",
            "soak chamber make-safe --config /etc/soak/station.toml", std::make_shared<ChamberMakeSafe>(), true,
            "It commands the chamber once, reads back, says what the chamber is doing, and does not wait: at the safe\n"
            "temperature heating and cooling are switched off, elsewhere the chamber is driven to it. A chamber that "
            "has an\n"
            "alarm, cannot be read or does not take its set point is switched off. Units and fixture are left alone.\n"
            "If soakd is controlling the chamber, this command changes nothing (exit status 2); a soakd that hangs is "
            "overruled."}}};
}

}  // namespace soak::station
