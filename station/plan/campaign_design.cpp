// SPDX-License-Identifier: Apache-2.0
#include "station/plan/campaign_design.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <set>
#include <utility>

#include "calib/curve/one_way.h"
#include "calib/judge/reference_plateau.h"
#include "station/config/plan.h"
#include "station/config/procedure.h"

namespace soak::station {
namespace {

constexpr double kSecondsPerHour = 3600.0;

double plateau_c(const PassDesign& design, const PlannedRange& range, int i) {
  // Tenths of a degree: what controllers take.
  const double exact_c = range.low_c + (range.high_c - range.low_c) * i / (design.plateaus - 1);
  return std::round(10.0 * exact_c) / 10.0;
}

/// Up over all plateaus, and back over those that are wanted, the lowest last.
std::vector<double> set_points_c(const PassDesign& design, const PlannedRange& range) {
  std::vector<double> points;
  for (int i = 0; i < design.plateaus; ++i) points.push_back(plateau_c(design, range, i));
  if (design.return_every == 0) return points;
  for (int i = design.plateaus - 1 - design.return_every; i > 0; i -= design.return_every) {
    points.push_back(plateau_c(design, range, i));
  }
  points.push_back(points.front());
  return points;
}

/// Runs that record the same visits count as power-ons of one kind.
calib::CampaignDesign recorded_by(const Plan& plan) {
  calib::CampaignDesign design;
  design.dwell_s = plan.procedure.dwell_s;
  for (const PlannedRun& run : plan.runs) {
    if (run.preflight) continue;
    calib::PlannedPowerOn power_on;
    for (std::size_t i = run.first_step; i <= run.last_step; ++i) {
      const Step& step = plan.steps[i];
      if (step.kind == StepKind::set_temperature) power_on.visits.push_back({step.temp_c, step.sweep});
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

PassDesign full_campaign() { return {.passes = 20, .plateaus = 21, .return_every = 0}; }

std::vector<PassDesign> designs_for(double low_c, double high_c) {
  constexpr double kBothWaysWithin_c = 2.0 * calib::kOtherWayWithin_c;
  constexpr std::array kSteps_c = {4.0, 5.0, 7.5, 10.0};
  std::set<int> plateaus;
  for (const double step_c : kSteps_c) {
    plateaus.insert(1 + std::max(3, static_cast<int>(std::ceil((high_c - low_c) / step_c - 1e-9))));
  }
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
      "name = \"{}\"\ndescription = \"{}\"\npurpose = \"calibration\"\nkind = \"soak\"\nruns = {}\n\n"
      "[temperatures]\nlist_c = [{:.1f}]\n",
      name, description, design.passes, fmt::join(set_points_c(design, range), ", "));
  if (range.low_c < calib::kReferencePlateau_c && range.high_c > calib::kReferencePlateau_c) {
    text += fmt::format("\n[reference]\ntemp_c = {:.1f}\n", calib::kReferencePlateau_c);
  }
  text += fmt::format("\n[positions]\norder = [\"+X\", \"-X\", \"+Y\", \"-Y\", \"+Z\", \"-Z\"]\ndwell_s = {:.1f}\n",
                      design.dwell_s);
  return text + power_table(design, range.type);
}

base::Result<DesignedCampaign> designed_campaign(const PassDesign& design, const PlannedRange& range) {
  const auto procedure = parse_procedure(procedure_text(design, range, "design", ""), "plan", {range.type});
  if (!procedure) return base::forward_error(procedure);
  const Plan plan = compile_plan(*procedure);
  return DesignedCampaign{plan.estimate_s() / kSecondsPerHour, recorded_by(plan)};
}

}  // namespace soak::station
