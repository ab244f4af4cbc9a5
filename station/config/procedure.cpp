// SPDX-License-Identifier: Apache-2.0
#include "station/config/procedure.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "calib/judge/reference_plateau.h"
#include "calib/vocabulary/position.h"
#include "settings/reader.h"
#include "station/config/set_point_limits.h"

namespace soak::station {
namespace {

using settings::Table;

/// Any shorter time than this is a mistake where a time is wanted at all.
constexpr double kShortest_s = 0.1;
constexpr double kDay_s = 86400.0;
constexpr double kMaxVisits = 2000.0;
constexpr settings::Limits kReference_c = {calib::kReferencePlateau_c - calib::kReferenceReach_c,
                                           calib::kReferencePlateau_c + calib::kReferenceReach_c};
/// The slope of a temperature is taken from the means of so many blocks (calib::StabilityJudge::kBlocks): each needs a
/// reading.
constexpr double kSlopeBlocks = 12.0;
constexpr std::size_t kMostSteps = 100'000;

void read_head(const settings::Table& root, Procedure& p) {
  p.name = root.text("name");
  if (root.has("name") && p.name.empty()) root.refuse("name", "'name' must not be empty");
  p.description = root.text("description", "");
  p.purpose = root.choice<Purpose>("purpose", {{"calibration", Purpose::calibration},
                                               {"verification", Purpose::verification},
                                               {"diagnosis", Purpose::diagnosis}});
  p.kind = root.choice<ProcedureKind>(
      "kind", {{"soak", ProcedureKind::soak}, {"ramp", ProcedureKind::ramp}, {"rest", ProcedureKind::rest}});
  p.runs = root.whole("runs", {1, 999}, p.runs);
  p.on_break = root.choice<BreakOutcome>(
      "on_break", {{"resume", BreakOutcome::resume}, {"repeat_run", BreakOutcome::repeat_run}}, p.on_break);
  p.on_restart = root.choice<RestartOutcome>(
      "on_restart", {{"wait", RestartOutcome::wait}, {"resume", RestartOutcome::resume}}, p.on_restart);
}

/// start_c, stop_c, step_c and sweep as a list.
std::vector<double> grid(const settings::Table& table) {
  const double start_c = table.number("start_c", kSetPoint_c);
  const double stop_c = table.number("stop_c", kSetPoint_c);
  const double step_c = table.number("step_c", {0.1, 200.0});
  const bool and_down = table.choice<bool>("sweep", {{"up", false}, {"up_down", true}});
  if (!table.has("start_c") || !table.has("stop_c") || step_c <= 0.0) return {};
  const double steps = (stop_c - start_c) / step_c;
  if (stop_c <= start_c) {
    table.refuse("stop_c", "'temperatures.stop_c' must be above start_c; for any other order use list_c");
    return {};
  }
  if (std::abs(steps - std::round(steps)) > 1e-6) {
    table.refuse("step_c", fmt::format("steps of {} °C from {} °C do not end at {} °C", step_c, start_c, stop_c));
    return {};
  }
  std::vector<double> points;
  const auto last = static_cast<int>(std::lround(steps));
  for (int i = 0; i <= last; ++i) points.push_back(start_c + i * step_c);
  for (int i = last - 1; and_down && i >= 0; --i) points.push_back(start_c + i * step_c);
  return points;
}

std::vector<double> list(const settings::Table& table) {
  for (const std::string_view key : {"start_c", "stop_c", "step_c"}) {
    if (!table.optional_number(key, kSetPoint_c)) continue;
    table.refuse(key, fmt::format("'temperatures.{}' cannot be combined with list_c", key));
  }
  if (!table.text("sweep", "").empty()) table.refuse("sweep", "'temperatures.sweep' cannot be combined with list_c");
  auto points = table.numbers("list_c", kSetPoint_c, settings::kRequired);
  if (points.empty()) table.refuse("list_c", "'temperatures.list_c' needs at least one set point");
  return points;
}

void read_temperatures(const settings::Table& root, Procedure& p) {
  const auto table = root.table("temperatures", settings::kRequired);
  if (!table) return;
  p.set_points_c = table->has("list_c") ? list(*table) : grid(*table);
  if (static_cast<double>(p.set_points_c.size()) > kMaxVisits) {
    table->refuse("step_c", fmt::format("{} set points are too many: at most {}", p.set_points_c.size(), kMaxVisits));
  }
  if (p.kind == ProcedureKind::rest && p.set_points_c.size() > 1) {
    table->refuse("list_c", "a procedure of kind 'rest' must have exactly one temperature");
  }
  p.ramp_rate_kpmin = table->optional_number("ramp_rate_kpmin", {0.01, 100.0});
  p.overshoot_c = table->number("overshoot_c", {0.0, 50.0}, p.overshoot_c);
}

/// The reference plateau as the first and the last visit of a run; an end of the course that is there already stays.
void read_reference(const settings::Table& table, Procedure& p) {
  const double reference_c = table.number("temp_c", kReference_c);
  if (p.kind != ProcedureKind::soak) {
    table.refuse("temp_c", "a reference plateau needs kind 'soak'");
    return;
  }
  auto& points = p.set_points_c;
  if (!table.has("temp_c") || points.empty()) return;
  const auto is_there = [reference_c](double temp_c) {
    return std::abs(temp_c - reference_c) <= calib::kSameSetPoint_c;
  };
  if (std::ranges::all_of(points, is_there)) {
    table.refuse(
        "temp_c",
        fmt::format("no set point is farther than {} K from the reference plateau: nothing lies between its two visits",
                    calib::kSameSetPoint_c));
    return;
  }
  p.reference_c = reference_c;
  if (points.front() != reference_c) points.insert(points.begin(), reference_c);
  if (points.back() != reference_c) points.push_back(reference_c);
}

/// What is wrong with a position after those before it; empty = nothing.
std::string order_finding(const std::vector<std::string>& before, const std::string& label) {
  const auto same_axis = [&](const std::string& other) { return other[1] == label[1]; };
  const auto found = std::find_if(before.begin(), before.end(), same_axis);
  if (std::find(before.begin(), before.end(), label) != before.end()) {
    return fmt::format("'{}' is duplicated in positions.order", label);
  }
  if (found == before.end() || found == before.end() - 1) return {};
  return fmt::format("'{}' and '{}' must follow each other in positions.order, so that drift can be told from bias",
                     *found, label);
}

/// Several findings about one key are one mistake.
void refuse_all(const settings::Table& table, std::string_view key, const std::vector<std::string>& findings) {
  if (!findings.empty()) table.refuse(key, fmt::format("{}", fmt::join(findings, "; ")));
}

/// The positions as the six labels, each once, + and − of an axis side by side.
std::vector<std::string> read_order(const settings::Table& table) {
  std::vector<std::string> labels;
  std::vector<std::string> findings;
  for (const std::string& text : table.texts("order", settings::kRequired)) {
    const auto position = calib::position_named(text);
    if (!position) {
      findings.push_back(fmt::format("'{}' is not a position: +X, -X, +Y, -Y, +Z or -Z", text));
      continue;
    }
    if (auto finding = order_finding(labels, position->label); !finding.empty()) findings.push_back(std::move(finding));
    labels.push_back(position->label);
  }
  refuse_all(table, "order", findings);
  return labels;
}

void read_positions(const settings::Table& root, Procedure& p) {
  const auto table = root.table("positions", settings::kRequired);
  if (!table) return;
  p.positions = read_order(*table);
  if (table->has("order") && p.positions.empty())
    table->refuse("order", "'positions.order' needs at least one position");
  if (p.kind != ProcedureKind::soak && p.positions.size() > 1) {
    table->refuse("order", fmt::format("a procedure of kind '{}' must have exactly one position", name_of(p.kind)));
  }
  p.position_change = table->choice<PositionChange>("between_runs",
                                                    {{"same", PositionChange::same},
                                                     {"reverse", PositionChange::reverse},
                                                     {"rotate", PositionChange::rotate},
                                                     {"rotate_and_reverse", PositionChange::rotate_and_reverse}},
                                                    p.position_change);
  p.dwell_s = table->number("dwell_s", {1.0, 30 * kDay_s}, p.dwell_s);
  p.turned_deg = table->number("turned_deg", {-180.0, 180.0}, p.turned_deg);
}

/// Each of them once, of those in which the fixture also rests: there the bias comes from.
std::vector<std::string> read_rate_positions(const settings::Table& table, const Procedure& p) {
  std::vector<std::string> labels;
  std::vector<std::string> findings;
  for (const std::string& text : table.texts("positions", settings::kRequired)) {
    const auto position = calib::position_named(text);
    const std::string label = position ? position->label : text;
    if (std::ranges::find(p.positions, label) == p.positions.end()) {
      findings.push_back(fmt::format("'{}' is not in positions.order", text));
    } else if (std::ranges::find(labels, label) != labels.end()) {
      findings.push_back(fmt::format("'{}' is duplicated in rates.positions", text));
    }
    labels.push_back(label);
  }
  if (table.has("positions") && labels.empty()) findings.emplace_back("'rates.positions' needs at least one position");
  refuse_all(table, "positions", findings);
  return labels;
}

void read_rates(const settings::Table& table, Procedure& p) {
  constexpr double kSlowest_dps = 5.0;
  constexpr double kFastest_dps = 2000.0;
  if (p.kind != ProcedureKind::soak) table.refuse("", "[rates] needs kind 'soak'");
  p.rate_positions = read_rate_positions(table, p);
  p.rates_dps = table.numbers("list_dps", {-kFastest_dps, kFastest_dps}, settings::kRequired);
  p.rate_dwell_s = table.number("dwell_s", {1.0, kDay_s}, p.rate_dwell_s);
  std::vector<std::string> findings;
  for (auto rate = p.rates_dps.begin(); rate != p.rates_dps.end(); ++rate) {
    if (std::abs(*rate) < kSlowest_dps) {
      findings.push_back(fmt::format("{:g} deg/s is too slow: at least {:g} in either direction", *rate, kSlowest_dps));
    } else if (std::find(p.rates_dps.begin(), rate, *rate) != rate) {
      findings.push_back(fmt::format("{:g} deg/s is duplicated in rates.list_dps", *rate));
    }
  }
  if (table.has("list_dps") && p.rates_dps.empty()) findings.emplace_back("'rates.list_dps' needs at least one rate");
  refuse_all(table, "list_dps", findings);
}

void read_stability(const settings::Table& table, StabilitySettings& s) {
  s.slope_kpmin = table.number("slope_kpmin", {0.0001, 10.0}, s.slope_kpmin);
  s.confidence = table.number("confidence", {0.5, 0.999}, s.confidence);
  s.window_s = table.number("window_s", {kShortest_s, kDay_s}, s.window_s);
  s.min_window_s = table.number("min_window_s", {kShortest_s, kDay_s}, s.min_window_s);
  s.minimum_soak_s = table.number("minimum_soak_s", {0.0, kDay_s}, s.minimum_soak_s);
  s.after_turn_s = table.number("after_turn_s", {kShortest_s, kDay_s}, s.after_turn_s);
  s.timeout_s = table.number("timeout_s", {1.0, 7 * kDay_s}, s.timeout_s);
  s.on_timeout = table.choice<TimeoutOutcome>("on_timeout",
                                              {{"skip_plateau", TimeoutOutcome::skip_plateau},
                                               {"record", TimeoutOutcome::record},
                                               {"abort", TimeoutOutcome::abort}},
                                              s.on_timeout);
  if (s.min_window_s > s.window_s) table.refuse("min_window_s", "'stability.min_window_s' must not exceed window_s");
  if (s.after_turn_s > s.window_s) table.refuse("after_turn_s", "'stability.after_turn_s' must not exceed window_s");
  if (s.timeout_s <= std::max(s.minimum_soak_s, s.min_window_s)) {
    table.refuse("timeout_s",
                 "'stability.timeout_s' must exceed minimum_soak_s and min_window_s, otherwise no plateau can pass");
  }
}

void read_units(const settings::Table& table, Procedure& p) {
  p.rate_hz = table.number("rate_hz", {0.1, 10000.0}, p.rate_hz);
  p.temp_rate_hz = table.number("temp_rate_hz", {0.01, 10000.0}, p.temp_rate_hz);
  if (p.temp_rate_hz > p.rate_hz) table.refuse("temp_rate_hz", "'units.temp_rate_hz' must not exceed rate_hz");
}

void refuse_too_few_readings(const settings::Table& root, const Procedure& p) {
  const double shortest_s = std::min(p.stability.min_window_s, p.stability.after_turn_s);
  if (p.kind == ProcedureKind::ramp || shortest_s * p.temp_rate_hz >= kSlopeBlocks) return;
  root.refuse("stability", fmt::format("{} s at {} Hz give too few temperature readings for a slope: the shorter of "
                                       "stability.min_window_s and after_turn_s needs {} of them",
                                       shortest_s, p.temp_rate_hz, kSlopeBlocks));
}

void refuse_too_many_steps(const settings::Table& root, const Procedure& p) {
  const std::size_t spins = p.rate_positions.size() * (3 + 2 * p.rates_dps.size());
  const std::size_t visits = p.set_points_c.size() + (p.cycle_at_visit ? static_cast<std::size_t>(p.cycles) : 0);
  const std::size_t steps = static_cast<std::size_t>(p.runs) * visits * (3 * p.positions.size() + spins + 2);
  if (steps <= kMostSteps || !root.has("runs")) return;
  root.refuse(
      "runs",
      fmt::format("the procedure has about {} steps, more than the {} allowed: use fewer runs, or several campaigns",
                  steps, kMostSteps));
}

void read_power(const settings::Table& table, Procedure& p) {
  constexpr std::string_view kCycle = "cycle_at_visit";
  constexpr std::string_view kCycles = "cycles";
  constexpr int kMostCycles = 99;
  p.power_off_s = table.number("off_s", {0.0, kDay_s}, p.power_off_s);
  p.warm_up_s = table.number("warm_up_s", {0.0, kDay_s}, p.warm_up_s);
  p.cycles = table.whole(kCycles, {1, kMostCycles}, p.cycles);
  if (!table.has(kCycle)) {
    if (table.has(kCycles))
      table.refuse(kCycles, "'power.cycles' needs cycle_at_visit: the visit after which it is done");
    return;
  }
  p.cycle_at_visit = table.whole(kCycle, {0, static_cast<int>(kMaxVisits)}, 0);
  const auto last = static_cast<int>(p.set_points_c.size()) - 1;
  if (p.kind != ProcedureKind::soak) {
    table.refuse(kCycle, "'power.cycle_at_visit' needs kind 'soak'");
  } else if (last >= 0 && *p.cycle_at_visit >= last) {
    table.refuse(
        kCycle, fmt::format("no visit comes after visit {}: the run has the visits 0 to {}, reference plateau included",
                            *p.cycle_at_visit, last));
  }
}

void read_sections(const Table& root, Procedure& p) {
  read_temperatures(root, p);
  if (const auto reference = root.table("reference")) read_reference(*reference, p);
  read_positions(root, p);
  if (const auto rates = root.table("rates")) read_rates(*rates, p);
  read_stability(root.section("stability"), p.stability);
  const Table segment = root.section("segment");
  p.segment_change_c = segment.number("change_max_c", {0.001, 100.0}, p.segment_change_c);
  p.segment_attempts = segment.whole("attempts", {1, 20}, p.segment_attempts);
  read_units(root.section("units"), p);
  read_power(root.section("power"), p);
  p.preflight_position_s = root.section("preflight").number("position_s", {0.0, kDay_s}, p.preflight_position_s);
  p.give_up_h = root.section("suspend").number("give_up_h", {0.1, 1000.0}, p.give_up_h);
  if (const auto end = root.table("end")) p.end_c = end->number("temp_c", {25.0, 60.0}, p.end_c);
  const Table estimate = root.section("estimate");
  p.estimate_rate_kpmin = estimate.number("rate_kpmin", {0.01, 100.0}, p.estimate_rate_kpmin);
  p.estimate_settle_s = estimate.number("settle_s", {0.0, kDay_s}, p.estimate_settle_s);
  refuse_too_few_readings(root, p);
  refuse_too_many_steps(root, p);
}

/// Set points that leave a rating, at the line of the list or, of a grid, at that of its table.
void refuse_ratings(const settings::Table& root, const Procedure& p, const std::vector<calib::UnitType>& types) {
  const auto table = root.table("temperatures");
  if (!table) return;
  refuse_all(*table, "list_c", rating_findings(p, types));
}

/// The first set point of a run, its end included, from which the air, passing it by `overshoot_c`, leaves the range.
std::optional<double> first_outside(const Procedure& procedure, double overshoot_c, std::optional<double> min_c,
                                    std::optional<double> max_c) {
  const auto outside = [&](double temp_c) {
    return (min_c && temp_c - overshoot_c < *min_c) || (max_c && temp_c + overshoot_c > *max_c);
  };
  const auto& points = procedure.set_points_c;
  const auto found = std::find_if(points.begin(), points.end(), outside);
  if (found != points.end()) return *found;
  return outside(procedure.end_c) ? std::optional(procedure.end_c) : std::nullopt;
}

std::string type_finding(const Procedure& procedure, const calib::UnitType& type) {
  if (!type.temp_min_c || !type.temp_max_c) {
    return fmt::format("unit type '{}' states no temperature rating, so the temperatures it can withstand are unknown",
                       type.name);
  }
  const auto point = first_outside(procedure, procedure.overshoot_c, type.temp_min_c, type.temp_max_c);
  if (!point) return {};
  return fmt::format("unit type '{}' is rated {} to {} °C: the set point {} °C with an overshoot of {} °C is outside",
                     type.name, *type.temp_min_c, *type.temp_max_c, *point, procedure.overshoot_c);
}

std::string chamber_finding(const Procedure& procedure, std::optional<double> min_c, std::optional<double> max_c) {
  constexpr double overshoot_c = 0.0;
  const auto point = first_outside(procedure, overshoot_c, min_c, max_c);
  if (!point) return {};
  const auto limit = [](std::optional<double> value_c) { return value_c ? fmt::format("{}", *value_c) : "any"; };
  return fmt::format("the chamber takes set points from {} to {} °C: {} °C is outside", limit(min_c), limit(max_c),
                     *point);
}

}  // namespace

base::Result<Procedure> parse_procedure(std::string_view text, const std::string& file,
                                        const std::vector<calib::UnitType>& types) {
  return settings::read(text, file, [&](const Table& root) {
    Procedure procedure;
    procedure.file = file;
    read_head(root, procedure);
    read_sections(root, procedure);
    refuse_ratings(root, procedure, types);
    return procedure;
  });
}

base::Result<Procedure> read_procedure(const std::filesystem::path& file, const std::vector<calib::UnitType>& types) {
  const auto text = settings::read_text(file.string());
  if (!text) return base::forward_error(text);
  return parse_procedure(*text, file.string(), types);
}

std::vector<std::string> rating_findings(const Procedure& procedure, const std::vector<calib::UnitType>& types) {
  std::vector<std::string> findings;
  for (const calib::UnitType& type : types) findings.push_back(type_finding(procedure, type));
  std::erase(findings, "");
  return findings;
}

base::Status check_ratings(const Procedure& procedure, const std::vector<calib::UnitType>& types,
                           std::optional<double> chamber_min_c, std::optional<double> chamber_max_c) {
  auto findings = rating_findings(procedure, types);
  findings.push_back(chamber_finding(procedure, chamber_min_c, chamber_max_c));
  std::erase(findings, "");
  if (findings.empty()) return {};
  return base::bad_input(fmt::format("{}", fmt::join(findings, "\n")), procedure.file);
}

std::string_view name_of(Purpose purpose) {
  constexpr std::array<std::string_view, 3> kNames = {"calibration", "verification", "diagnosis"};
  return kNames.at(static_cast<std::size_t>(purpose));
}

std::string_view name_of(ProcedureKind kind) {
  constexpr std::array<std::string_view, 3> kNames = {"soak", "ramp", "rest"};
  return kNames.at(static_cast<std::size_t>(kind));
}

}  // namespace soak::station
