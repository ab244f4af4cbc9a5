// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/programs/programs.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <utility>
#include <vector>

#include "base/result.h"
#include "base/text.h"
#include "hal/sim/campaign/truth_writer.h"
#include "hal/sim/programs/station_file.h"
#include "hal/sim/wires/lab_server.h"
#include "settings/reader.h"

namespace soak::hal::sim {
namespace {

constexpr std::string_view kLabUsage =
    R"(usage: soaksim --out DIR [--seed N] [--units N] [--rate R|max] [--config FILE]
               [--base-port P] [--pty SLOT...] [--chamber KIND] [--fixture KIND] [--decoder KIND...] [--maps DIR]
Runs a simulated laboratory on 127.0.0.1: a chamber, a fixture and a relay card over Modbus TCP, and units that speak the
Xbus protocol of the Xsens MTi or another unit protocol. Writes DIR/station.toml once everything is listening, then prints
one line of JSON with the ports. Ends with status 0 on SIGTERM or SIGINT.

  --out DIR        folder for station.toml; created if missing
  --seed N         seed of all random numbers (default: from the configuration)
  --units N        number of units, 1 to 64, in slots 1, 2, ...
  --rate R         simulated seconds per real second, 0.01 to 20000 (default 1); max = 20000. The simulated clock slows
                   down if a client cannot keep up.
  --config FILE    what is simulated and how strong it is, in the format of lab.toml
  --base-port P    ports P (chamber), P+1 (fixture), P+2 (relay), P+3 (espec-p300), P+10+n (unit n); default: any free ports
  --pty SLOT...    these slots get a pseudo-terminal instead of a TCP port; the JSON line and station.toml give its name
  --chamber KIND   controller for station.toml: f4t (Modbus TCP, the default), f4t-rtu, eurotherm-2400 (Modbus RTU on
                   a pseudo-terminal), espec-p300 (lines of text over TCP)
  --fixture KIND   fixture for station.toml: six-positions (the default), two-axis (angles, and a rate of the inner axis)
  --decoder KIND...
                   protocols of the units in slots 1, 2, ...; the last one given applies to all further slots: xsens (the
                   default), ahrs400, vectornav
  --maps DIR       folder of register maps and unit types for station.toml
)";
constexpr std::string_view kTruthUsage =
    R"(usage: soaksim-truth [--seed N] [--units N] [--config FILE]
Prints as JSON the truth about the units that soaksim simulates with the same options: thermal curves, axes, and the
offsets of each unit's first 64 power-ons. hal/sim/README.md describes the format.
)";

constexpr double kMinRate = 0.01;
constexpr double kMaxRate = 20000.0;
constexpr int kMaxBasePort = 65535 - 10 - kRelayOutputs;
constexpr int kListedPowerOns = 64;

base::Result<double> rate_option(const ProgramOptions& options) {
  const std::string text = options.text("--rate").value_or("1");
  if (text == "max") return kMaxRate;
  const auto rate = base::parse_double(text);
  if (!rate || *rate < kMinRate || *rate > kMaxRate) {
    return base::bad_input(
        fmt::format("option --rate must be a number from {} to {} or 'max', not '{}'", kMinRate, kMaxRate, text));
  }
  return *rate;
}

template <class Value>
using Choices = std::vector<std::pair<std::string_view, Value>>;

const Choices<ChamberKind> kChambers = {{"f4t", ChamberKind::f4t},
                                        {"f4t-rtu", ChamberKind::f4t_rtu},
                                        {"eurotherm-2400", ChamberKind::eurotherm_2400},
                                        {"espec-p300", ChamberKind::espec_p300}};
const Choices<FixtureKind> kFixtures = {{"six-positions", FixtureKind::six_positions},
                                        {"two-axis", FixtureKind::two_axis}};
const Choices<UnitKind> kDecoders = {
    {"xsens", UnitKind::xsens}, {"ahrs400", UnitKind::ahrs400}, {"vectornav", UnitKind::vectornav}};

/// Puts what each of `texts`, values of an option, stands for into `take`.
template <class Value, class Take>
base::Status choose(std::string_view option, const Choices<Value>& choices, const std::vector<std::string>& texts,
                    Take take) {
  for (const std::string& text : texts) {
    std::string known;
    bool found = false;
    for (const auto& [name, value] : choices) {
      if (name == text) take(value);
      found = found || name == text;
      known += known.empty() ? "" : name == choices.back().first ? " or " : ", ";
      known += name;
    }
    if (!found) return base::bad_input(fmt::format("option {} must be {}, not '{}'", option, known, text));
  }
  return {};
}

base::Result<LabServerOptions> server_options(const ProgramOptions& options, int units) {
  LabServerOptions server;
  std::vector<UnitKind> kinds;
  const auto set = [](auto& target) { return [&target](const auto& value) { target = value; }; };
  const auto chosen =
      choose("--chamber", kChambers, options.texts("--chamber"), set(server.chamber))
          .and_then(
              [&] { return choose("--fixture", kFixtures, options.texts("--fixture"), set(server.kinds.fixture)); })
          .and_then([&] {
            return choose("--decoder", kDecoders, options.texts("--decoder"),
                          [&](UnitKind kind) { kinds.push_back(kind); });
          });
  if (!chosen) return base::forward_error(chosen);
  if (!kinds.empty()) server.kinds.units = std::move(kinds);
  const auto rate = rate_option(options);
  if (!rate) return base::forward_error(rate);
  server.rate = *rate;
  const auto base_port = options.whole("--base-port", 1, kMaxBasePort);
  if (!base_port) return base::forward_error(base_port);
  if (*base_port) server.base_port = static_cast<int>(**base_port);
  const auto slots = options.wholes("--pty", 1, units);
  if (!slots) return base::forward_error(slots);
  for (const std::int64_t slot : *slots) server.pty_slots.insert(static_cast<int>(slot));
  return server;
}

/// Here is no planned campaign by which a magnitude could be counted, or a candidate's blocks be listed.
base::Status refuse_what_needs_a_plan(const CampaignConfig& config) {
  if (!config.candidates.empty()) {
    return base::bad_input("[[candidate]] needs a planned campaign: soaksim-campaign reads it; [[hidden]] acts here");
  }
  for (const HiddenSpec& spec : config.hidden) {
    if (spec.amplitude) continue;
    return base::bad_input(
        fmt::format("hidden effect '{}' has a magnitude, but there is no planned campaign here to scale it by; give "
                    "its 'amplitude'",
                    spec.effect));
  }
  return {};
}

/// What a command line asks soaksim to do.
struct LabOrder {
  std::string folder;
  std::string maps;
  CampaignConfig config;
  LabServerOptions server;
};

base::Result<LabOrder> parse_lab_order(const std::vector<std::string>& arguments) {
  const auto options = ProgramOptions::parse(
      arguments,
      {"--out", "--seed", "--units", "--rate", "--config", "--base-port", "--chamber", "--fixture", "--maps"},
      {"--pty", "--decoder"});
  if (!options) return base::forward_error(options);
  const auto folder = options->required("--out", "the folder for station.toml");
  if (!folder) return base::forward_error(folder);
  auto config = configured(*options, kRelayOutputs);
  if (!config) return base::forward_error(config);
  if (config->units > kRelayOutputs) {
    return base::bad_input(
        fmt::format("the laboratory has room for 1 to {} units, not {}", kRelayOutputs, config->units));
  }
  if (const base::Status stated = refuse_what_needs_a_plan(*config); !stated) return base::forward_error(stated);
  auto server = server_options(*options, config->units);
  if (!server) return base::forward_error(server);
  return LabOrder{*folder, options->text("--maps").value_or(settings::shipped("procedures", SOAK_SIM_MAPS)),
                  *std::move(config), *std::move(server)};
}

base::Status serve_lab(const LabOrder& order, int stop_fd, const std::function<void(const std::string&)>& announce) {
  const auto server = LabServer::open(order.config, order.server);
  if (!server) return base::forward_error(server);
  const LabAddresses addresses = (*server)->addresses();
  const auto file = write_station_file(order.folder, station_toml(order.config, order.server, addresses, order.maps));
  if (!file) return base::forward_error(file);
  announce(addresses_json(addresses, *file));
  (*server)->run_until_readable(stop_fd);
  return {};
}

base::Result<std::string> truth_text(const std::vector<std::string>& arguments) {
  const auto options = ProgramOptions::parse(arguments, {"--seed", "--units", "--config"});
  if (!options) return base::forward_error(options);
  const auto config = configured(*options, kRelayOutputs);
  if (!config) return base::forward_error(config);
  if (const base::Status stated = refuse_what_needs_a_plan(*config); !stated) return base::forward_error(stated);
  std::vector<SimulatedUnit> units;
  for (int number = 1; number <= config->units; ++number) units.push_back(draw_lab_unit(*config, number));
  ListedRuns listed;
  for (int ordinal = 0; ordinal < kListedPowerOns; ++ordinal) {
    listed.runs.push_back({fmt::format("{}", ordinal), ordinal});
  }
  return truth_json(*config, units, listed);
}

bool asks_for_help(const std::vector<std::string>& arguments) {
  return std::find(arguments.begin(), arguments.end(), "--help") != arguments.end();
}

}  // namespace

ProgramOutcome run_soaksim(const std::vector<std::string>& arguments, int stop_fd,
                           const std::function<void(const std::string&)>& announce) {
  if (asks_for_help(arguments)) return {0, std::string(kLabUsage), ""};
  const auto order = parse_lab_order(arguments);
  if (!order) return failed_program("soaksim", order.error());
  if (const auto served = serve_lab(*order, stop_fd, announce); !served)
    return failed_program("soaksim", served.error());
  return {};
}

ProgramOutcome run_soaksim_truth(const std::vector<std::string>& arguments) {
  if (asks_for_help(arguments)) return {0, std::string(kTruthUsage), ""};
  const auto text = truth_text(arguments);
  if (!text) return failed_program("soaksim-truth", text.error());
  return {0, *text, ""};
}

}  // namespace soak::hal::sim
