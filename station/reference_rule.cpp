// SPDX-License-Identifier: Apache-2.0
#include "station/reference_rule.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "station/iso_date.h"
#include "station/waiver.h"

namespace soak::station {
namespace {

using Name = std::pair<calib::ReferenceKind, std::string>;

Name name_of(const db::ReferenceRow& row) { return {row.reference.kind, row.reference.name}; }

/// Of each reference the entry that was issued last, up to `utc_s`.
std::map<Name, const db::ReferenceRow*> newest_entries(const std::vector<db::ReferenceRow>& entries,
                                                       std::optional<double> utc_s) {
  std::map<Name, const db::ReferenceRow*> newest;
  for (const db::ReferenceRow& row : entries) {
    if (utc_s && row.reference.issued_utc_s > *utc_s) continue;
    const db::ReferenceRow*& known = newest[name_of(row)];
    if (known == nullptr || row.reference.issued_utc_s >= known->reference.issued_utc_s) known = &row;
  }
  return newest;
}

/// References that were not calibrated yet.
std::vector<std::string> notes_of_younger(const std::vector<db::ReferenceRow>& entries, double utc_s) {
  std::vector<std::string> notes;
  const auto by_then = newest_entries(entries, utc_s);
  for (const auto& [name, row] : newest_entries(entries, std::nullopt)) {
    if (row->retired || by_then.contains(name)) continue;
    notes.push_back(
        fmt::format("{} had no certificate on {}: it is left out", describe(row->reference), iso_date(utc_s)));
  }
  return notes;
}

/// An entry with the waiver that it needs because it is due before the end, if there is one.
base::Result<calib::ReferenceUse> use_of(const calib::Reference& reference, const std::vector<calib::Waiver>& waivers,
                                         const MeasurementTime& time) {
  if (reference.due_utc_s > time.end_utc_s) return calib::ReferenceUse{reference, std::nullopt};
  auto waiver = waiver_for(waivers, reference);
  if (!waiver) return base::forward_error(waiver);
  return calib::ReferenceUse{reference, *std::move(waiver)};
}

/// What there is to say of a use; nothing where all is well.
std::string note_of(const calib::ReferenceUse& use, const MeasurementTime& time) {
  if (use.reference.due_utc_s > time.end_utc_s) return {};
  const std::string due = iso_date(use.reference.due_utc_s);
  if (!use.waiver) return fmt::format("{} expires on {}, before the end", describe(use.reference), due);
  return fmt::format("{} is due on {}: used by the waiver of {}: {}", describe(use.reference), due, use.waiver->signer,
                     use.waiver->reason);
}

base::Error blocked(const std::vector<calib::Reference>& expired, double utc_s) {
  std::vector<std::string> texts;
  for (const calib::Reference& reference : expired) {
    texts.push_back(fmt::format("{} expired on {}", describe(reference), iso_date(reference.due_utc_s)));
  }
  const calib::Reference& first = expired.front();
  return {
      base::ErrorKind::bad_input,
      fmt::format("{}: nothing may be measured with it on {}. Enter its new certificate ('soak reference add --kind "
                  "{} --name \"{}\" ...'), or sign for its use ('soak reference waive --kind {} --name \"{}\" "
                  "--reason TEXT --key FILE'); one that is not used any more is taken out by 'soak reference retire'",
                  fmt::join(texts, "; "), iso_date(utc_s), calib::name_of(first.kind), first.name,
                  calib::name_of(first.kind), first.name),
      "references"};
}

}  // namespace

std::string describe(const calib::Reference& reference) {
  return fmt::format("{} '{}' (certificate {})", calib::name_of(reference.kind), reference.name, reference.certificate);
}

std::vector<db::ReferenceRow> active_references(const std::vector<db::ReferenceRow>& entries, double utc_s) {
  const auto newest = newest_entries(entries, std::nullopt);
  std::vector<db::ReferenceRow> active;
  for (const auto& [name, row] : newest_entries(entries, utc_s)) {
    if (!newest.at(name)->retired) active.push_back(*row);
  }
  return active;
}

base::Result<std::optional<calib::Waiver>> waiver_for(const std::vector<calib::Waiver>& waivers,
                                                      const calib::Reference& reference) {
  const auto newest = std::find_if(waivers.rbegin(), waivers.rend(), [&](const calib::Waiver& waiver) {
    return waiver.record_id == reference.record_id;
  });
  if (newest == waivers.rend()) return std::nullopt;
  if (auto good = check_waiver(*newest, reference); !good) return base::forward_error(good);
  return *newest;
}

base::Result<JudgedReferences> judge_references(const db::Catalog& catalog, const MeasurementTime& time) {
  const auto entries = catalog.references();
  if (!entries) return base::forward_error(entries);
  const auto waivers = catalog.waivers();
  if (!waivers) return base::forward_error(waivers);
  JudgedReferences judged;
  if (entries->empty()) judged.notes.emplace_back("the register of references is empty ('soak reference add')");
  std::vector<calib::Reference> expired;
  for (const db::ReferenceRow& row : active_references(*entries, time.begin_utc_s)) {
    auto use = use_of(row.reference, *waivers, time);
    if (!use) return base::forward_error(use);
    if (row.reference.due_utc_s <= time.begin_utc_s && !use->waiver) expired.push_back(row.reference);
    if (auto note = note_of(*use, time); !note.empty()) judged.notes.push_back(std::move(note));
    judged.uses.push_back(*std::move(use));
  }
  if (!expired.empty()) return tl::unexpected<base::Error>(blocked(expired, time.begin_utc_s));
  for (std::string& note : notes_of_younger(*entries, time.begin_utc_s)) judged.notes.push_back(std::move(note));
  return judged;
}

base::Result<std::vector<calib::ReferenceUse>> references_of_campaigns(const db::Catalog& catalog,
                                                                       const std::vector<std::string>& campaigns) {
  std::vector<calib::ReferenceUse> uses;
  for (const std::string& campaign : std::set<std::string>(campaigns.begin(), campaigns.end())) {
    auto of_campaign = catalog.campaign_references(campaign);
    if (!of_campaign) return base::forward_error(of_campaign);
    for (calib::ReferenceUse& use : *of_campaign) {
      if (use.waiver) {
        if (auto good = check_waiver(*use.waiver, use.reference); !good) return base::forward_error(good);
      }
      const auto same = std::find_if(uses.begin(), uses.end(), [&](const calib::ReferenceUse& other) {
        return other.reference.record_id == use.reference.record_id;
      });
      if (same == uses.end()) {
        uses.push_back(std::move(use));
      } else if (use.waiver && (!same->waiver || same->waiver->utc_s < use.waiver->utc_s)) {
        same->waiver = std::move(use.waiver);
      }
    }
  }
  return uses;
}

}  // namespace soak::station
