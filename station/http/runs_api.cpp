// SPDX-License-Identifier: Apache-2.0
#include "station/http/runs_api.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>

#include "base/text.h"
#include "station/http/members.h"
#include "station/io/text.h"

namespace soak::station {
namespace {

using base::Result;
using nlohmann::json;

/// Whether a text is 8-4-4-4-12 hexadecimal digits in small letters (RFC 9562).
bool is_run_id(std::string_view text) {
  constexpr std::string_view kPattern = "xxxxxxxx-xxxx-xxxx-xxxx-xxxxxxxxxxxx";
  return std::ranges::equal(text, kPattern, [](char c, char pattern) {
    return pattern == 'x' ? (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f') : c == pattern;
  });
}

base::Status check_run_id(const std::string& text) {
  if (is_run_id(text)) return {};
  return base::bad_input("not the id of a run: 8-4-4-4-12 hexadecimal digits, as /api/v1/runs gives it", "run");
}

Result<RunName> run_name(const Parameters& parameters) {
  const auto run_id = required(parameters, "run", "the id of a run, as /api/v1/runs gives it");
  if (!run_id) return base::forward_error(run_id);
  if (auto valid = check_run_id(*run_id); !valid) return base::forward_error(valid);
  const auto unit = required(parameters, "unit", "a serial number");
  if (!unit) return base::forward_error(unit);
  return RunName{*run_id, *unit};
}

Result<std::optional<double>> seconds(const Parameters& parameters, const std::string& name) {
  const auto text = single(parameters, name);
  if (!text) return base::forward_error(text);
  if (!*text) return std::nullopt;
  const auto value = base::parse_double(**text);
  if (!value) return base::bad_input(fmt::format("'{}' is not a number of seconds, such as 120.5", **text), name);
  return value;
}

Result<std::size_t> points_of(const Parameters& parameters) {
  const auto text = single(parameters, "points");
  if (!text) return base::forward_error(text);
  if (!*text) return SeriesRequest{}.points;
  const auto value = base::parse_int(**text);
  if (value && *value >= 1 && *value <= static_cast<std::int64_t>(RunArchive::kMostPoints)) {
    return static_cast<std::size_t>(*value);
  }
  return base::bad_input(fmt::format("'{}' is not a whole number from 1 to {}", **text, RunArchive::kMostPoints),
                         "points");
}

std::vector<std::string> channels_of(const Parameters& parameters) {
  std::vector<std::string> channels;
  const auto [first, last] = parameters.equal_range("channel");
  for (auto one = first; one != last; ++one) channels.push_back(one->second);
  return channels;
}

Result<json> answer_runs(RunArchive& runs, const Parameters& parameters) {
  if (auto known = only_parameters(parameters, {"unit", "campaign"}); !known) return base::forward_error(known);
  const auto unit = single(parameters, "unit");
  if (!unit) return base::forward_error(unit);
  const auto campaign = single(parameters, "campaign");
  if (!campaign) return base::forward_error(campaign);
  return runs.list({.unit = *unit, .campaign = *campaign, .run = {}});
}

Result<json> answer_run(RunArchive& runs, const Parameters& parameters) {
  if (auto known = only_parameters(parameters, {"run", "unit"}); !known) return base::forward_error(known);
  const auto name = run_name(parameters);
  if (!name) return base::forward_error(name);
  return runs.show(*name);
}

Result<json> answer_series(RunArchive& runs, const Parameters& parameters) {
  const auto known = only_parameters(parameters, {"run", "unit", "stream", "channel", "from_s", "to_s", "points"});
  if (!known) return base::forward_error(known);
  SeriesRequest request;
  const auto name = run_name(parameters);
  if (!name) return base::forward_error(name);
  const auto stream = single(parameters, "stream");
  if (!stream) return base::forward_error(stream);
  const auto from_s = seconds(parameters, "from_s");
  if (!from_s) return base::forward_error(from_s);
  const auto to_s = seconds(parameters, "to_s");
  if (!to_s) return base::forward_error(to_s);
  const auto points = points_of(parameters);
  if (!points) return base::forward_error(points);
  return runs.series({*name, stream->value_or(request.stream), channels_of(parameters), *from_s, *to_s, *points});
}

}  // namespace

const std::vector<RunQuestion>& run_questions() {
  static const std::vector<RunQuestion> questions = {
      {"runs", answer_runs}, {"run", answer_run}, {"run/series", answer_series}};
  return questions;
}

Result<json> void_run(RunArchive& runs, const json& body) {
  const auto known = only_members(body, {"run", "unit", "visit", "position", "attempt", "reason", "user"});
  if (!known) return base::forward_error(known);
  const auto run_id = line_member(body, "run", std::nullopt);
  if (!run_id) return base::forward_error(run_id);
  if (auto valid = check_run_id(*run_id); !valid) return base::forward_error(valid);
  const auto unit = text_member(body, "unit", std::nullopt);
  if (!unit) return base::forward_error(unit);
  if (auto plain = check_text_line(*unit, "unit"); !plain) return base::forward_error(plain);
  const auto visit = count_member(body, "visit");
  if (!visit) return base::forward_error(visit);
  const auto attempt = count_member(body, "attempt");
  if (!attempt) return base::forward_error(attempt);
  std::optional<std::string> position;
  if (const auto member = body.find("position"); member != body.end() && !member->is_null()) {
    if (!member->is_string()) return base::bad_input("the member is not text", "position");
    position = member->get<std::string>();
    if (auto plain = check_text_line(*position, "position"); !plain && !position->empty()) {
      return base::forward_error(plain);
    }
  }
  if (position && !*visit) return base::bad_input("a position is withdrawn with its visit", "visit");
  if (*attempt && !position) return base::bad_input("an attempt is withdrawn with its visit and position", "position");
  const auto reason = line_member(body, "reason", std::nullopt);
  if (!reason) return base::forward_error(reason);
  const auto user = line_member(body, "user", std::nullopt);
  if (!user) return base::forward_error(user);
  return runs.withdraw({*run_id, *unit, *visit, position, *attempt, *reason, *user, 0.0});
}

}  // namespace soak::station
