// SPDX-License-Identifier: Apache-2.0
#include "station/fit/reference_rule.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstddef>
#include <limits>
#include <map>
#include <set>
#include <utility>

#include "station/io/host.h"
#include "station/io/text.h"
#include "station/records/signing.h"

namespace soak::station {
namespace {

using ReferenceName = std::pair<calib::ReferenceKind, std::string>;

ReferenceName reference_name(const db::ReferenceRow& row) { return {row.reference.kind, row.reference.name}; }

/// From when on each entry stands for nothing: a reference is retired with all its entries that were made before.
std::vector<double> closing_times(const std::vector<db::ReferenceRow>& entries) {
  std::vector<double> closed(entries.size(), std::numeric_limits<double>::infinity());
  for (std::size_t r = 0; r < entries.size(); ++r) {
    if (!entries[r].retired) continue;
    const double end_s = entries[r].retired->utc_s;
    for (std::size_t i = 0; i < entries.size(); ++i) {
      const bool is_before = i <= r || entries[i].entered_utc_s < end_s;
      if (is_before && reference_name(entries[i]) == reference_name(entries[r])) closed[i] = std::min(closed[i], end_s);
    }
  }
  return closed;
}

/// Of each reference the entry that was issued last, up to `issued_by_s`, of those that stand for something at `utc_s`.
std::map<ReferenceName, const db::ReferenceRow*> newest_entries(const std::vector<db::ReferenceRow>& entries,
                                                                double utc_s, double issued_by_s) {
  const std::vector<double> closed = closing_times(entries);
  std::map<ReferenceName, const db::ReferenceRow*> newest;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const db::ReferenceRow& row = entries[i];
    if (row.withdrawn || closed[i] <= utc_s || row.reference.issued_utc_s > issued_by_s) continue;
    const db::ReferenceRow*& known = newest[reference_name(row)];
    if (known == nullptr || row.reference.issued_utc_s >= known->reference.issued_utc_s) known = &row;
  }
  return newest;
}

/// References that were not calibrated yet.
std::vector<std::string> notes_of_younger(const std::vector<db::ReferenceRow>& entries, double utc_s) {
  std::vector<std::string> notes;
  const auto by_then = newest_entries(entries, utc_s, utc_s);
  for (const auto& [name, row] : newest_entries(entries, utc_s, std::numeric_limits<double>::infinity())) {
    if (by_then.contains(name)) continue;
    notes.push_back(
        fmt::format("{} had no certificate on {}: it is left out", describe(row->reference), iso_date(utc_s)));
  }
  return notes;
}

std::string ending_text(const db::EndRecord& end) {
  return fmt::format("on {} by {}: {}", iso_date(end.utc_s), end.user, end.reason);
}

/// An entry with the waiver that it needs because it is due before the end, if there is one.
base::Result<calib::ReferenceUse> use_with_waiver(const calib::Reference& reference,
                                                  const std::vector<calib::Waiver>& waivers,
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
  return fmt::format("{} is due on {}: used under the waiver by {}: {}", describe(use.reference), due,
                     use.waiver->signer, use.waiver->reason);
}

std::string record_id_of(const db::ReferenceRow& row) { return row.reference.record_id; }

/// The entry that was made in the place of a withdrawn one; nothing where there is none.
const db::ReferenceRow* correction_of(const db::ReferenceRow& withdrawn, const std::vector<db::ReferenceRow>& entries) {
  const db::ReferenceRow* found = nullptr;
  for (const db::ReferenceRow& row : entries) {
    const bool is_same = reference_name(row) == reference_name(withdrawn) &&
                         row.reference.certificate == withdrawn.reference.certificate && !row.withdrawn;
    if (is_same) found = &row;
  }
  return found;
}

calib::Warning withdrawn_warning(const db::ReferenceRow& row, const std::vector<db::ReferenceRow>& entries) {
  return {"reference_withdrawn",
          fmt::format("the entry of {} was withdrawn {}; {}", describe(row.reference), ending_text(*row.withdrawn),
                      correction_of(row, entries) != nullptr
                          ? "its values still apply here; the corrected entry applies from the next fit on"
                          : "no entry corrects it, and its values still apply here")};
}

/// Whether the reference has a certificate that is good at a time.
bool is_good(const calib::Reference& reference, const std::vector<db::ReferenceRow>& entries, double utc_s) {
  return std::ranges::any_of(active_references(entries, utc_s), [&](const db::ReferenceRow& row) {
    return row.reference.kind == reference.kind && row.reference.name == reference.name &&
           row.reference.due_utc_s > utc_s;
  });
}

/// A waiver that was noted for a campaign, or the newest good one for the same entry in the place of one that is
/// damaged or gone.
base::Result<calib::Waiver> good_waiver(const calib::ReferenceUse& use, const std::vector<calib::Waiver>& waivers) {
  const auto checked = check_waiver(*use.waiver, use.reference);
  if (checked) return *use.waiver;
  const auto good = std::find_if(waivers.rbegin(), waivers.rend(), [&](const calib::Waiver& waiver) {
    return check_waiver(waiver, use.reference).has_value();
  });
  if (good != waivers.rend()) return *good;
  return base::forward_error(checked);
}

/// What was noted for a campaign, as the register has it today.
base::Result<calib::ReferenceUse> use_today(calib::ReferenceUse noted, const std::vector<db::ReferenceRow>& entries,
                                            const std::vector<calib::Waiver>& waivers) {
  const auto row = std::ranges::find(entries, noted.reference.record_id, &record_id_of);
  if (row != entries.end() && row->withdrawn) {
    if (const db::ReferenceRow* correction = correction_of(*row, entries)) {
      // A waiver is for one entry.
      return calib::ReferenceUse{correction->reference, std::nullopt};
    }
  }
  if (!noted.waiver) return noted;
  auto waiver = good_waiver(noted, waivers);
  if (!waiver) return base::forward_error(waiver);
  noted.waiver = *std::move(waiver);
  return noted;
}

/// Each entry once, with its campaigns and the waiver that was signed last.
void add_use(std::vector<calib::ReferenceUse>& uses, calib::ReferenceUse use) {
  const auto same = std::ranges::find_if(
      uses, [&](const calib::ReferenceUse& other) { return other.reference.record_id == use.reference.record_id; });
  if (same == uses.end()) {
    uses.push_back(std::move(use));
    return;
  }
  same->campaigns.insert(same->campaigns.end(), use.campaigns.begin(), use.campaigns.end());
  if (use.waiver && (!same->waiver || same->waiver->utc_s < use.waiver->utc_s)) same->waiver = std::move(use.waiver);
}

base::Error blocked(const std::vector<calib::Reference>& expired, double utc_s) {
  std::vector<std::string> texts;
  for (const calib::Reference& reference : expired) {
    texts.push_back(fmt::format("{} expired on {}", describe(reference), iso_date(reference.due_utc_s)));
  }
  const calib::Reference& first = expired.front();
  return {base::ErrorKind::bad_input,
          fmt::format("{}: it must not be used on {}. Enter its new certificate ('soak reference add --kind {} --name "
                      "\"{}\" ...'), or sign a waiver ('soak reference waive --kind {} --name \"{}\" --reason TEXT "
                      "--key FILE'); if it is no longer in use, 'soak reference retire' says so",
                      fmt::join(texts, "; "), iso_date(utc_s), calib::name_of(first.kind), first.name,
                      calib::name_of(first.kind), first.name),
          "references"};
}

}  // namespace

std::string describe(const calib::Reference& reference) {
  return fmt::format("{} '{}' (certificate {})", calib::name_of(reference.kind), reference.name, reference.certificate);
}

std::vector<db::ReferenceRow> active_references(const std::vector<db::ReferenceRow>& entries, double utc_s) {
  std::vector<db::ReferenceRow> active;
  for (const auto& [name, row] : newest_entries(entries, utc_s, utc_s)) active.push_back(*row);
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
  if (entries->empty())
    judged.notes.emplace_back(
        "the register of references is empty: enter certificates in Records on the page, or with 'soak reference add'");
  std::vector<calib::Reference> expired;
  for (const db::ReferenceRow& row : active_references(*entries, time.begin_utc_s)) {
    auto use = use_with_waiver(row.reference, *waivers, time);
    if (!use) return base::forward_error(use);
    if (row.reference.due_utc_s <= time.begin_utc_s && !use->waiver) expired.push_back(row.reference);
    if (auto note = note_of(*use, time); !note.empty()) judged.notes.push_back(std::move(note));
    if (row.retired) {
      judged.notes.push_back(
          fmt::format("{} was retired since, {}", describe(row.reference), ending_text(*row.retired)));
    }
    judged.uses.push_back(*std::move(use));
  }
  if (!expired.empty()) return tl::unexpected<base::Error>(blocked(expired, time.begin_utc_s));
  for (std::string& note : notes_of_younger(*entries, time.begin_utc_s)) judged.notes.push_back(std::move(note));
  return judged;
}

base::Result<std::vector<calib::ReferenceUse>> references_of_campaigns(const db::Catalog& catalog,
                                                                       const std::vector<std::string>& campaigns) {
  const auto entries = catalog.references();
  if (!entries) return base::forward_error(entries);
  const auto waivers = catalog.waivers();
  if (!waivers) return base::forward_error(waivers);
  std::vector<calib::ReferenceUse> uses;
  for (const std::string& campaign : std::set<std::string>(campaigns.begin(), campaigns.end())) {
    auto of_campaign = catalog.campaign_references(campaign);
    if (!of_campaign) return base::forward_error(of_campaign);
    for (calib::ReferenceUse& noted : *of_campaign) {
      auto use = use_today(std::move(noted), *entries, *waivers);
      if (!use) return base::forward_error(use);
      use->campaigns = {campaign};
      add_use(uses, *std::move(use));
    }
  }
  return uses;
}

base::Result<std::vector<calib::Warning>> reference_warnings(const db::Catalog& catalog,
                                                             const std::vector<calib::ReferenceUse>& uses) {
  const auto entries = catalog.references();
  if (!entries) return base::forward_error(entries);
  std::vector<calib::Warning> warnings;
  const double now_s = now_utc_s();
  for (const calib::ReferenceUse& use : uses) {
    const auto row = std::ranges::find(*entries, use.reference.record_id, &record_id_of);
    if (row == entries->end()) continue;
    if (row->withdrawn) {
      warnings.push_back(withdrawn_warning(*row, *entries));
    } else if (row->retired) {
      warnings.push_back({"reference_retired", fmt::format("{}, which was used for this measurement, was retired {}",
                                                           describe(row->reference), ending_text(*row->retired))});
    } else if (!use.waiver && row->reference.due_utc_s <= now_s && !is_good(row->reference, *entries, now_s)) {
      warnings.push_back(
          {"reference_expired", fmt::format("{}, which was used for this measurement, expired on {} and has no newer "
                                            "certificate: nothing confirms that it was still correct",
                                            describe(row->reference), iso_date(row->reference.due_utc_s))});
    }
  }
  return warnings;
}

}  // namespace soak::station
