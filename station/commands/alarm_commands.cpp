// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "station/alarms/alarm_message.h"
#include "station/alarms/delivery.h"
#include "station/commands/command.h"
#include "station/config/station_config.h"
#include "station/io/text.h"

namespace soak::station {
namespace {

/// soak alarm send TEXT --config FILE: without soakd, so that it can tell of soakd's own end. Fails (device) where no
/// way takes the message.
struct AlarmSend final : Command {
  std::string text;
  std::string config;  ///< empty = station.toml in the data folder

  void declare(OptionList& options) override {
    options.add("text TEXT", &text, "What happened, in one line").required();
    options.add("--config FILE", &config,
                "The station's configuration, which names mail and webhook (default, and while FILE is the template: "
                "station.toml in the data folder)");
  }
  base::Status run(Output& output) override;
};

struct Outcome {
  std::string way;
  std::string to;
  std::string trouble;  ///< empty = sent
};

std::vector<Outcome> send_all(const std::vector<std::unique_ptr<Delivery>>& deliveries, const AlarmMessage& message) {
  const std::atomic<bool> stop = false;
  std::vector<Outcome> outcomes;
  for (const auto& delivery : deliveries) {
    const base::Status sent = delivery->send(message, stop);
    outcomes.push_back({delivery->way(), delivery->destination(), sent ? "" : one_line(sent.error().message)});
  }
  return outcomes;
}

nlohmann::json outcomes_document(const std::vector<Outcome>& outcomes) {
  nlohmann::json ways = nlohmann::json::array();
  for (const auto& [way, to, trouble] : outcomes) {
    ways.push_back(
        {{"way", way}, {"to", to}, {"trouble", trouble.empty() ? nlohmann::json() : nlohmann::json(trouble)}});
  }
  return {{"ways", std::move(ways)}};
}

base::Status AlarmSend::run(Output& output) {
  if (auto line = check_text_line(text, "TEXT"); !line) return line;
  const auto station = find_station_config(config, data);
  if (!station) return base::forward_error(station);
  const auto deliveries = deliveries_of(station->alarms);
  if (!deliveries) return base::forward_error(deliveries);
  if (deliveries->empty()) {
    return base::bad_input("it has neither [alarms.mail] nor [alarms.webhook]: nobody is told of alarms",
                           station->file);
  }
  const auto outcomes = send_all(*deliveries, message_of("note", text, place_now("")));
  if (output.json()) {
    if (auto printed = output.print_json(outcomes_document(outcomes)); !printed) return printed;
  }
  std::string troubles;
  for (const auto& [way, to, trouble] : outcomes) {
    if (!trouble.empty()) troubles += fmt::format("{}{} to {}: {}", troubles.empty() ? "" : "; ", way, to, trouble);
    if (trouble.empty() && !output.json()) output.print(fmt::format("{} to {}: sent\n", way, to));
  }
  if (std::ranges::all_of(outcomes, [](const Outcome& outcome) { return !outcome.trouble.empty(); })) {
    return base::fail(base::ErrorKind::device, "nobody was told: " + troubles, "alarm");
  }
  if (!troubles.empty()) output.note("warning: not sent: " + troubles);
  return {};
}

}  // namespace

CommandGroup alarm_commands() {
  return {"alarm",
          "Tell people what happened",
          {{"send", "Send a text by the mail and the webhook of the station's configuration",
            "soak alarm send 'soakd has ended' --config /etc/soak/station.toml", std::make_shared<AlarmSend>(), true,
            "It needs no soakd. It has done its work where one of them took the text."}}};
}

}  // namespace soak::station
