// SPDX-License-Identifier: Apache-2.0
#include "station/lab/suspenders.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

namespace soak::station {
namespace {

constexpr std::array<SuspensionCause, 6> kAllCauses = {SuspensionCause::chamber, SuspensionCause::air,
                                                       SuspensionCause::disk,    SuspensionCause::storage,
                                                       SuspensionCause::supply,  SuspensionCause::catalog};
constexpr double kChamberSilent_s = 60.0;
constexpr double kAirAway_k = 3.0;
constexpr double kAirBack_k = 1.0;
constexpr double kAirAway_s = 600.0;
constexpr double kSupplyOff = 0.10;  ///< share of the set voltage
constexpr double kSupplyBack = 0.05;
constexpr double kSupplyOff_s = 10.0;

/// What a link says, without the time of its next try: the text is kept for longer than that.
std::string without_next_try(const std::string& trouble) { return trouble.substr(0, trouble.find("; next try in ")); }

}  // namespace

std::string_view name_of(SuspensionCause cause) {
  constexpr std::array<std::string_view, 6> kNames = {"chamber", "air", "disk", "storage", "supply", "catalog"};
  return kNames.at(static_cast<std::size_t>(cause));
}

Suspenders::Advice Suspenders::look(double now_s, const StationConditions& conditions) {
  for (const SuspensionCause cause : kAllCauses) watches_[index(cause)].follow(now_s, judge(cause, conditions));
  if (std::ranges::none_of(watches_, &Watch::suspends)) {
    waited_before_s_ = waited_s(now_s);
    since_s_.reset();
    return Advice::carry_on;
  }
  if (!since_s_) {
    since_s_ = now_s;
    ++suspensions_;
  }
  const bool too_much = waited_s(now_s) > give_up_s_ || suspensions_ > kMostSuspensions;
  return too_much ? Advice::give_up : Advice::suspend;
}

double Suspenders::waited_s(double now_s) const { return waited_before_s_ + (since_s_ ? now_s - *since_s_ : 0.0); }

void Suspenders::note_progress() {
  waited_before_s_ = 0.0;
  suspensions_ = 0;
}

void Suspenders::Watch::follow(double now_s, const Finding& finding) {
  if (finding.level != Level::bad) bad_since_s.reset();
  if (finding.level != Level::good) good_since_s.reset();
  if (finding.level == Level::bad) {
    if (!bad_since_s) bad_since_s = now_s;
    if (now_s - *bad_since_s >= finding.delay_s) suspends = true;
    text = finding.text;
  }
  if (finding.level == Level::good) {
    if (!good_since_s) good_since_s = now_s;
    if (now_s - *good_since_s >= kSettle_s) suspends = false;
  }
}

Suspenders::Finding Suspenders::judge(SuspensionCause cause, const StationConditions& conditions) {
  const auto level = [](bool bad, bool good) { return bad ? Level::bad : good ? Level::good : Level::between; };
  const auto unknown = [] { return Finding{Level::between, 0.0, ""}; };
  switch (cause) {
    case SuspensionCause::chamber:
      return {
          level(conditions.chamber_silent_s >= kChamberSilent_s, conditions.chamber_silent_s <= 0.0), 0.0,
          "the chamber does not answer, it is left at its set point: " + without_next_try(conditions.chamber_trouble)};
    case SuspensionCause::air: {
      if (!conditions.air_off_k) return unknown();
      const double off_k = *conditions.air_off_k;
      return {level(off_k > kAirAway_k, off_k <= kAirBack_k), kAirAway_s,
              fmt::format("the air is {:.1f} K from the set point: is the door open?", off_k)};
    }
    case SuspensionCause::disk: {
      if (!conditions.disk_free_bytes) return unknown();
      const double free_bytes = *conditions.disk_free_bytes;
      return {level(free_bytes < kDiskLow_bytes, free_bytes >= kDiskEnough_bytes), 0.0,
              fmt::format("the disk has {:.0f} MB left, {:.0f} are needed to go on", 1e-6 * free_bytes,
                          1e-6 * kDiskEnough_bytes)};
    }
    case SuspensionCause::storage:
      return {level(!conditions.storage_error.empty(), true), 0.0, "cannot record: " + conditions.storage_error};
    case SuspensionCause::supply:
      return judge_supplies(conditions.supplies);
    case SuspensionCause::catalog:
      return {level(!conditions.catalog_error.empty(), true), 0.0,
              "the end of the last step cannot be entered into the catalog: " + conditions.catalog_error};
  }
  return {};
}

Suspenders::Finding Suspenders::judge_supplies(const std::vector<StationConditions::Supply>& supplies) {
  Finding finding{Level::good, kSupplyOff_s, ""};
  for (const StationConditions::Supply& supply : supplies) {
    const auto off =
        supply.read_v ? std::optional(std::abs(*supply.read_v - supply.set_v) / supply.set_v) : std::nullopt;
    if (off && *off <= kSupplyBack) continue;
    if (!off || *off <= kSupplyOff) {
      finding.level = std::max(finding.level, Level::between);
      continue;
    }
    finding.level = Level::bad;
    finding.text += fmt::format("{}the supply of unit {} is {:.2f} V, set are {:.2f} V",
                                finding.text.empty() ? "" : "; ", supply.unit, *supply.read_v, supply.set_v);
  }
  return finding;
}

std::vector<SuspensionCause> Suspenders::causes() const {
  std::vector<SuspensionCause> causes;
  std::ranges::copy_if(kAllCauses, std::back_inserter(causes), [this](SuspensionCause cause) { return has(cause); });
  return causes;
}

bool Suspenders::spoil_visit() const {
  return std::ranges::any_of(kAllCauses,
                             [this](SuspensionCause cause) { return cause != SuspensionCause::catalog && has(cause); });
}

std::string Suspenders::text() const {
  std::string text;
  for (const Watch& watch : watches_) {
    if (!watch.suspends) continue;
    text += (text.empty() ? "" : "; ") + watch.text;
    if (watch.good_since_s) text += " (over, settling)";
  }
  return text;
}

}  // namespace soak::station
