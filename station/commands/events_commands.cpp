// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string_view>
#include <utility>

#include "base/text.h"
#include "station/commands/command.h"
#include "station/commands/shared.h"
#include "station/records/event_json.h"

namespace soak::station {
namespace {

/// soak events list [--kind K] [--subject S] [--user U] [--last N]
struct EventsList final : CatalogCommand {
  std::optional<std::string> kind;
  std::optional<std::string> subject;
  std::optional<std::string> user;
  std::optional<std::size_t> last;

  void declare(OptionList& options) override {
    options.add("--kind KIND", &kind, "Only events of this kind: run_added, voided, model_added...");
    options.add("--subject TEXT", &subject, "Only events about this unit, run, campaign...");
    options.add("--user NAME", &user, "Only events by this user");
    options.add("--last N", &last, "Only the newest N of them").range(1, 1e9);
  }
  base::Status run_with(db::Catalog& catalog, Output& output) override;
};

/// soak events verify [--contains SHA256]
struct EventsVerify final : CatalogCommand {
  std::string contains;

  void declare(OptionList& options) override {
    options.add("--contains SHA256", &contains,
                "Chain value noted earlier, which the log must still hold: shows that nothing before it was rewritten");
  }
  base::Status run_with(db::Catalog& catalog, Output& output) override;
};

bool is_asked_for(const db::EventRow& event, const EventsList& command) {
  return event.kind == command.kind.value_or(event.kind) && event.subject == command.subject.value_or(event.subject) &&
         event.user == command.user.value_or(event.user);
}

/// Kinds of all events that programs of this version enter.
constexpr std::array<std::string_view, 61> kKnownKinds = {"account",
                                                          "alarm",
                                                          "alarm_not_sent",
                                                          "alarm_sent",
                                                          "backup_made",
                                                          "calibration_exported",
                                                          "campaign",
                                                          "campaign_aborted",
                                                          "campaign_begun",
                                                          "campaign_failed",
                                                          "campaign_finished",
                                                          "campaign_interrupted",
                                                          "campaign_paused",
                                                          "campaign_running",
                                                          "chamber",
                                                          "check_standard",
                                                          "check_standard_added",
                                                          "check_standard_ended",
                                                          "device",
                                                          "epoch_begun",
                                                          "gap_accepted",
                                                          "gap_withdrawn",
                                                          "job_ended",
                                                          "job_started",
                                                          "journal",
                                                          "key_made",
                                                          "logged_in",
                                                          "logged_out",
                                                          "login_limited",
                                                          "login_refused",
                                                          "model_added",
                                                          "model_fitted",
                                                          "model_released",
                                                          "model_verified",
                                                          "model_withdrawn",
                                                          "noise_exported",
                                                          "nothing_to_void",
                                                          "position",
                                                          "power",
                                                          "procedure_made",
                                                          "prompt",
                                                          "reference",
                                                          "reference_added",
                                                          "reference_retired",
                                                          "reference_waived",
                                                          "reference_withdrawn",
                                                          "run",
                                                          "run_added",
                                                          "run_warning",
                                                          "samples_dropped",
                                                          "segment",
                                                          "shard_merged",
                                                          "station_change_undone",
                                                          "station_changed",
                                                          "station_set_up",
                                                          "step",
                                                          "storage",
                                                          "unit",
                                                          "unit_added",
                                                          "verification",
                                                          "voided"};

/// A kind that no event ever has is a mistyped one. What older or newer versions have entered is in the log itself.
base::Status check_event_kind(const std::optional<std::string>& kind, const std::vector<db::EventRow>& events) {
  if (!kind) return {};
  std::set<std::string_view> kinds(kKnownKinds.begin(), kKnownKinds.end());
  for (const db::EventRow& event : events) kinds.insert(event.kind);
  if (kinds.contains(*kind)) return {};
  return base::bad_input(fmt::format("there are no events of kind '{}'; kinds are {}", *kind, fmt::join(kinds, ", ")),
                         "--kind");
}

base::Status EventsList::run_with(db::Catalog& catalog, Output& output) {
  auto events = catalog.events();
  if (!events) return base::forward_error(events);
  if (auto known = check_event_kind(kind, *events); !known) return known;
  std::erase_if(*events, [&](const db::EventRow& event) { return !is_asked_for(event, *this); });
  const std::size_t shown = std::min(last.value_or(events->size()), events->size());
  events->erase(events->begin(), events->end() - static_cast<std::ptrdiff_t>(shown));
  if (output.json()) {
    nlohmann::json list = nlohmann::json::array();
    for (const db::EventRow& event : *events) list.push_back(event_json(event));
    return output.print_json({{"events", std::move(list)}});
  }
  std::vector<std::vector<std::string>> rows = {{"number", "utc", "kind", "subject", "user", "text"}};
  for (const db::EventRow& event : *events) {
    rows.push_back(
        {std::to_string(event.number), base::utc_text(event.utc_s), event.kind, event.subject, event.user, event.text});
  }
  output.print(text_table(rows));
  return {};
}

/// Refuses a log that does not hold a chain value that was noted earlier.
base::Status check_contains(const db::Catalog& catalog, const std::string& noted) {
  if (noted.empty()) return {};
  const auto events = catalog.events();
  if (!events) return base::forward_error(events);
  if (std::ranges::find(*events, noted, &db::EventRow::chain_sha256) != events->end()) return {};
  return base::corrupt(
      "the event log does not hold this chain value: it is the log of another station, or what was "
      "written before has been rewritten",
      "--contains");
}

base::Status EventsVerify::run_with(db::Catalog& catalog, Output& output) {
  const auto chain = catalog.check_events();
  base::Status status = chain ? check_contains(catalog, contains) : base::Status(base::forward_error(chain));
  if (output.json()) {
    const auto printed = output.print_json(chain_json(chain, status));
    if (!printed) return printed;
  } else if (status) {
    output.print(fmt::format("{} events, none changed or missing; end of the chain: {}\n", chain->events,
                             chain->events > 0 ? chain->end_sha256 : "none"));
  }
  return status;
}

}  // namespace

CommandGroup event_commands() {
  return {"events",
          "The event log: who did what when",
          {{"list", "List the log", "soak events list --user ann --last 20", std::make_shared<EventsList>()},
           {"verify", "Check that no event was changed or taken away", "soak events verify",
            std::make_shared<EventsVerify>()}}};
}

}  // namespace soak::station
