// SPDX-License-Identifier: Apache-2.0
#include "station/plan/campaign_design.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <set>
#include <utility>

#include "calib/curve/one_way.h"
#include "calib/judge/reference_plateau.h"
#include "station/config/plan.h"
#include "station/config/procedure.h"

namespace soak::station {
namespace {

constexpr double kSecondsPerHour = 3600.0;
constexpr std::array kSteps_c = {4.0, 5.0, 7.5, 10.0};

/// Plateaus at most `step_c` apart, four or more.
int plateaus_for(double range_c, double step_c) {
  return 1 + std::max(3, static_cast<int>(std::ceil(range_c / step_c - 1e-9)));
}

/// A basic string of TOML.
std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    const auto code = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') out += '\\';
    if (code < 0x20 || code == 0x7f) {
      out += fmt::format("\\u{:04X}", code);
    } else {
      out += c;
    }
  }
  return out + '"';
}

double plateau_c(const PassDesign& design, const PlannedRange& range, int i) {
  // Tenths of a degree: what controllers take.
  const double exact_c = range.low_c + (range.high_c - range.low_c) * i / (design.plateaus - 1);
  return std::round(10.0 * exact_c) / 10.0;
}

/// Over all plateaus, and back over those that are wanted to the first one. That one is the end of the range farther
/// from where runs end, so that the temperature turns at it: the branches of a loop meet there.
std::vector<double> set_points_c(const PassDesign& design, const PlannedRange& range) {
  std::vector<double> points;
  for (int i = 0; i < design.plateaus; ++i) points.push_back(plateau_c(design, range, i));
  if (design.return_every == 0) return points;
  for (int i = design.plateaus - 1 - design.return_every; i > 0; i -= design.return_every) {
    points.push_back(plateau_c(design, range, i));
  }
  points.push_back(points.front());
  if (range.low_c <= end_of_runs_c(range.type)) return points;
  for (double& point : points) point = std::round(10.0 * (range.low_c + range.high_c - point)) / 10.0;
  return points;
}

/// The visits of a compiled plan, each with the way by which the unit got there, from the end of the run before where
/// it begins one; of no way at the coldest and the hottest place of all, where the temperature turns. Runs that record
/// the same visits count as power-ons of one kind.
calib::CampaignDesign recorded_by(const Plan& plan) {
  const auto drives = [](const Step& step) {
    return step.kind == StepKind::set_temperature || step.kind == StepKind::warm_end;
  };
  double coldest_c = plan.procedure.end_c;
  double hottest_c = plan.procedure.end_c;
  for (const Step& step : plan.steps) {
    if (!drives(step)) continue;
    coldest_c = std::min(coldest_c, step.temp_c);
    hottest_c = std::max(hottest_c, step.temp_c);
  }
  calib::CampaignDesign design;
  design.dwell_s = plan.procedure.dwell_s;
  std::optional<double> before_c;
  calib::Sweep way = calib::Sweep::unknown;
  for (const PlannedRun& run : plan.runs) {
    if (run.preflight) continue;
    calib::PlannedPowerOn power_on;
    for (std::size_t i = run.first_step; i <= run.last_step; ++i) {
      const Step& step = plan.steps[i];
      if (!drives(step)) continue;
      if (before_c && step.temp_c != *before_c) way = step.temp_c > *before_c ? calib::Sweep::up : calib::Sweep::down;
      if (!before_c) way = step.sweep;
      before_c = step.temp_c;
      if (step.kind != StepKind::set_temperature) continue;
      const bool turns = step.temp_c == coldest_c || step.temp_c == hottest_c;
      power_on.visits.push_back({step.temp_c, turns ? calib::Sweep::unknown : way});
    }
    const auto same = std::ranges::find(design.power_ons, power_on.visits, &calib::PlannedPowerOn::visits);
    if (same == design.power_ons.end()) {
      design.power_ons.push_back(std::move(power_on));
    } else {
      ++same->count;
    }
  }
  return design;
}

std::string power_table(const PassDesign& design, const calib::UnitType& type) {
  std::string text = "\n[power]\noff_s = 60.0\n";
  if (type.warm_up_s) text += fmt::format("warm_up_s = {:.1f}\n", *type.warm_up_s);
  if (design.power_cycles > 0) text += fmt::format("cycle_at_visit = 0\ncycles = {}\n", design.power_cycles);
  return text;
}

}  // namespace

double end_of_runs_c(const calib::UnitType& type) {
  const Procedure standard;
  return std::max(standard.end_c, type.temp_min_c ? *type.temp_min_c + standard.overshoot_c : standard.end_c);
}

PassDesign full_campaign(double low_c, double high_c) {
  constexpr int kPlateaus = 21;
  return {
      .passes = 20, .plateaus = std::min(kPlateaus, plateaus_for(high_c - low_c, kSteps_c.front())), .return_every = 0};
}

std::vector<PassDesign> designs_for(double low_c, double high_c) {
  constexpr double kBothWaysWithin_c = 2.0 * calib::kOtherWayWithin_c;
  std::set<int> plateaus;
  for (const double step_c : kSteps_c) plateaus.insert(plateaus_for(high_c - low_c, step_c));
  // Its reference plateau gives the full campaign one more.
  if (const int full = full_campaign(low_c, high_c).plateaus; full == *plateaus.rbegin()) plateaus.insert(full + 1);
  std::vector<PassDesign> designs;
  for (const int count : plateaus) {
    const double step_c = (high_c - low_c) / (count - 1);
    for (const int return_every : {1, 2}) {
      if (return_every * step_c > kBothWaysWithin_c + 1e-9) continue;
      for (const int passes : {3, 4, 6, 10, 20}) {
        for (const int cycles : {0, 1, 2, 4, 9}) {
          for (const double dwell_s : {120.0, 600.0}) {
            designs.push_back({passes, count, return_every, cycles, dwell_s});
          }
        }
      }
    }
  }
  return designs;
}

std::string procedure_text(const PassDesign& design, const PlannedRange& range, const std::string& name,
                           const std::string& description) {
  std::string text = fmt::format(
      "# docs/procedures.md explains every key, docs/chamber-hours.md how this was planned.\n"
      "name = {}\ndescription = {}\npurpose = \"calibration\"\nkind = \"soak\"\nruns = {}\n\n"
      "[temperatures]\nlist_c = [{:.1f}]\n",
      quoted(name), quoted(description), design.passes, fmt::join(set_points_c(design, range), ", "));
  if (design.return_every == 0 && range.low_c < calib::kReferencePlateau_c &&
      range.high_c > calib::kReferencePlateau_c) {
    text += fmt::format("\n[reference]\ntemp_c = {:.1f}\n", calib::kReferencePlateau_c);
  }
  text += fmt::format("\n[positions]\norder = [\"+X\", \"-X\", \"+Y\", \"-Y\", \"+Z\", \"-Z\"]\ndwell_s = {:.1f}\n",
                      design.dwell_s);
  text += power_table(design, range.type);
  if (const double temp_c = end_of_runs_c(range.type); temp_c != Procedure().end_c) {
    text += fmt::format("\n[end]\ntemp_c = {:.1f}\n", temp_c);
  }
  return text;
}

base::Result<DesignedCampaign> designed_campaign(const PassDesign& design, const PlannedRange& range) {
  const auto procedure = parse_procedure(procedure_text(design, range, "design", ""), "plan", {range.type});
  if (!procedure) return base::forward_error(procedure);
  const Plan plan = compile_plan(*procedure);
  return DesignedCampaign{plan.estimate_s() / kSecondsPerHour, recorded_by(plan)};
}

}  // namespace soak::station
