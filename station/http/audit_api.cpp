// SPDX-License-Identifier: Apache-2.0
#include "station/http/audit_api.h"

#include <fmt/format.h>

#include <array>
#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/text.h"
#include "station/records/event_json.h"

namespace soak::station {
namespace {

using base::Result;
using nlohmann::json;

constexpr std::int64_t kMostEvents = 500;
constexpr std::int64_t kEventsOfAPage = 100;
/// What a campaign enters by the hundred while all is well.
constexpr std::array<std::string_view, 4> kRoutine = {"position", "power", "segment", "step"};

Result<std::optional<double>> moment(const Parameters& parameters, const std::string& name) {
  const auto text = single(parameters, name);
  if (!text) return base::forward_error(text);
  if (!*text) return std::nullopt;
  const auto value = base::parse_double(**text);
  if (!value) return base::bad_input(fmt::format("'{}' is not a Unix time in seconds", **text), name);
  return value;
}

/// A whole number from 1 to `most`; nothing where it is absent.
Result<std::optional<std::int64_t>> count(const Parameters& parameters, const std::string& name, std::int64_t most) {
  const auto text = single(parameters, name);
  if (!text) return base::forward_error(text);
  if (!*text) return std::nullopt;
  const auto value = base::parse_int(**text);
  if (value && *value >= 1 && *value <= most) return value;
  return base::bad_input(fmt::format("'{}' is not a whole number from 1 to {}", **text, most), name);
}

Result<db::EventFilter> filter_of(const Parameters& parameters) {
  db::EventFilter filter;
  for (auto [name, text] :
       {std::pair("kind", &filter.kind), std::pair("subject", &filter.subject), std::pair("user", &filter.user)}) {
    auto value = single(parameters, name);
    if (!value) return base::forward_error(value);
    *text = *std::move(value);
  }
  const auto from_utc_s = moment(parameters, "from_utc_s");
  if (!from_utc_s) return base::forward_error(from_utc_s);
  const auto to_utc_s = moment(parameters, "to_utc_s");
  if (!to_utc_s) return base::forward_error(to_utc_s);
  const auto before = count(parameters, "before", std::numeric_limits<std::int64_t>::max());
  if (!before) return base::forward_error(before);
  const auto most = count(parameters, "most", kMostEvents);
  if (!most) return base::forward_error(most);
  filter.from_utc_s = *from_utc_s;
  filter.to_utc_s = *to_utc_s;
  filter.before = *before;
  filter.most = static_cast<std::size_t>(most->value_or(kEventsOfAPage));
  return filter;
}

/// What people call the things that events are about: a run by its label alone or with its campaign ("R06 of nov-cal"),
/// a certificate by its number or the name of its reference; anything else by itself.
Result<std::vector<std::string>> subjects_called(const db::Catalog& catalog, const std::string& about) {
  std::vector<std::string> subjects = {about};
  const auto runs = catalog.runs({.unit = {}, .campaign = {}, .run = {}});
  if (!runs) return base::forward_error(runs);
  for (const db::RunRow& run : *runs) {
    const bool is_meant = run.label == about || run.label + " of " + run.campaign == about;
    if (is_meant && subjects.back() != run.run_id) subjects.push_back(run.run_id);
  }
  const auto references = catalog.references();
  if (!references) return base::forward_error(references);
  for (const db::ReferenceRow& row : *references) {
    const bool is_meant = row.reference.name == about || row.reference.certificate == about;
    if (is_meant) subjects.push_back(row.reference.record_id);
  }
  return subjects;
}

/// "true" or "false"; `otherwise` where it is absent.
Result<bool> flag(const Parameters& parameters, const std::string& name, bool otherwise) {
  const auto text = single(parameters, name);
  if (!text) return base::forward_error(text);
  if (!*text) return otherwise;
  if (**text == "true" || **text == "false") return **text == "true";
  return base::bad_input("neither true nor false", name);
}

Result<json> answer_audit(RunArchive& runs, const Parameters& parameters) {
  const auto known = only_parameters(
      parameters, {"kind", "subject", "about", "user", "from_utc_s", "to_utc_s", "before", "most", "routine"});
  if (!known) return base::forward_error(known);
  auto filter = filter_of(parameters);
  if (!filter) return base::forward_error(filter);
  const auto about = single(parameters, "about");
  if (!about) return base::forward_error(about);
  const auto with_routine = flag(parameters, "routine", true);
  if (!with_routine) return base::forward_error(with_routine);
  if (!*with_routine) filter->without_kinds.assign(kRoutine.begin(), kRoutine.end());
  return runs.in_turn([&](const db::Catalog& catalog) -> Result<json> {
    if (*about) {
      auto subjects = subjects_called(catalog, **about);
      if (!subjects) return base::forward_error(subjects);
      filter->subjects = *std::move(subjects);
    }
    const std::size_t shown = filter->most++;  // one more tells whether there are older ones
    auto events = catalog.find_events(*filter);
    if (!events) return base::forward_error(events);
    auto kinds = catalog.event_kinds();
    if (!kinds) return base::forward_error(kinds);
    auto users = catalog.event_users();
    if (!users) return base::forward_error(users);
    const bool has_older = events->size() > shown;
    if (has_older) events->resize(shown);
    json list = json::array();
    for (const db::EventRow& event : *events) list.push_back(event_json(event));
    return json{{"events", std::move(list)},
                {"has_older", has_older},
                {"kinds", *std::move(kinds)},
                {"users", *std::move(users)}};
  });
}

/// A chain that is broken is an answer too.
Result<json> answer_check(RunArchive& runs, const Parameters& parameters) {
  if (auto known = only_parameters(parameters, {}); !known) return base::forward_error(known);
  return runs.in_turn([&](const db::Catalog& catalog) -> Result<json> {
    const auto chain = catalog.check_events();
    if (!chain && chain.error().kind != base::ErrorKind::corrupt) return base::forward_error(chain);
    return chain_json(chain, chain ? base::Status() : base::Status(base::forward_error(chain)));
  });
}

}  // namespace

const std::vector<RunQuestion>& audit_questions() {
  static const std::vector<RunQuestion> questions = {{"audit", answer_audit}, {"audit/check", answer_check}};
  return questions;
}

}  // namespace soak::station
