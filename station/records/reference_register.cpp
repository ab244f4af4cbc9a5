// SPDX-License-Identifier: Apache-2.0
#include "station/records/reference_register.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <set>
#include <tuple>
#include <utility>

#include "station/fit/reference_rule.h"
#include "station/io/output.h"
#include "station/io/text.h"
#include "station/records/signing.h"

namespace soak::station {
namespace {

using nlohmann::json;

constexpr double kSecondsPerDay = 86400.0;

ReferenceStanding standing_of(const db::ReferenceRow& row, bool is_active, double utc_s) {
  if (row.withdrawn) return ReferenceStanding::withdrawn;
  if (!is_active) return row.retired ? ReferenceStanding::retired : ReferenceStanding::superseded;
  if (row.reference.due_utc_s <= utc_s) return ReferenceStanding::expired;
  return row.reference.due_utc_s - utc_s <= kDueSoon_s ? ReferenceStanding::due_soon : ReferenceStanding::valid;
}

/// Place among the entries of one reference.
int rank_of(ReferenceStanding standing) {
  if (standing == ReferenceStanding::withdrawn) return 3;
  if (standing == ReferenceStanding::superseded) return 2;
  return standing == ReferenceStanding::retired ? 1 : 0;
}

std::vector<ShownWaiver> shown_waivers(const std::vector<calib::Waiver>& waivers, const calib::Reference& reference) {
  std::vector<ShownWaiver> shown;
  for (const calib::Waiver& waiver : waivers) {
    if (waiver.record_id != reference.record_id) continue;
    shown.push_back({waiver, check_waiver(waiver, reference).has_value()});
  }
  return shown;
}

std::string number_text(double value, calib::ReferenceKind kind) {
  return fmt::format("{:.6g} {}", value * calib::printed_per_si(kind), calib::printed_unit(kind));
}

std::string correction_text(const calib::Reference& reference) {
  return reference.correction ? number_text(*reference.correction, reference.kind) : "-";
}

std::string days_text(int days) { return days == 1 ? "1 day" : fmt::format("{} days", days); }

std::string expired_text(const ShownReference& shown) {
  std::string text =
      shown.days_left == 0 ? std::string("EXPIRED today") : fmt::format("EXPIRED {} ago", days_text(-shown.days_left));
  if (shown.waivers.empty()) return text;
  const ShownWaiver& newest = shown.waivers.back();
  return text + (newest.good ? ", waived by " + newest.waiver.signer : ", its waiver is DAMAGED");
}

/// "valid for 120 days", "EXPIRED 3 days ago, waived by Ann".
std::string state_text(const ShownReference& shown) {
  switch (shown.standing) {
    case ReferenceStanding::valid:
      return "valid for " + days_text(shown.days_left);
    case ReferenceStanding::due_soon:
      return "DUE in " + days_text(shown.days_left);
    case ReferenceStanding::expired:
      return expired_text(shown);
    default:
      return std::string(name_of(shown.standing));
  }
}

json waiver_document(const ShownWaiver& shown) {
  return {{"waiver_id", shown.waiver.waiver_id},
          {"reason", shown.waiver.reason},
          {"signer", shown.waiver.signer},
          {"utc_s", shown.waiver.utc_s},
          {"public_key", shown.waiver.public_key_hex},
          {"signature", shown.waiver.signature_hex},
          {"good", shown.good}};
}

json ending_document(const std::optional<db::EndRecord>& end) {
  if (!end) return {};
  return {{"reason", end->reason}, {"user", end->user}, {"utc_s", end->utc_s}};
}

json reference_document(const ShownReference& shown) {
  const calib::Reference& reference = shown.row.reference;
  const double factor = calib::printed_per_si(reference.kind);
  json waivers = json::array();
  for (const ShownWaiver& waiver : shown.waivers) waivers.push_back(waiver_document(waiver));
  return {{"record_id", reference.record_id},
          {"kind", calib::name_of(reference.kind)},
          {"name", reference.name},
          {"certificate", reference.certificate},
          {"issued", iso_date(reference.issued_utc_s)},
          {"due", iso_date(reference.due_utc_s)},
          {"unit", calib::printed_unit(reference.kind)},
          {"correction", reference.correction ? json(factor * *reference.correction) : json()},
          {"standard_uncertainty", factor * reference.standard_uncertainty},
          {"standing", name_of(shown.standing)},
          {"days_left", shown.days_left},
          {"user", shown.row.user},
          {"entered_utc_s", shown.row.entered_utc_s},
          {"retired", ending_document(shown.row.retired)},
          {"withdrawn", ending_document(shown.row.withdrawn)},
          {"waivers", std::move(waivers)},
          {"campaigns", shown.campaigns}};
}

}  // namespace

std::string_view name_of(ReferenceStanding standing) {
  constexpr std::array<std::string_view, 6> kNames = {"valid",      "due_soon", "expired",
                                                      "superseded", "retired",  "withdrawn"};
  return kNames[static_cast<std::size_t>(standing)];
}

int days_until(double due_utc_s, double utc_s) {
  return static_cast<int>(std::floor(due_utc_s / kSecondsPerDay) - std::floor(utc_s / kSecondsPerDay));
}

base::Result<std::vector<ShownReference>> shown_register(const db::Catalog& catalog, double utc_s) {
  const auto entries = catalog.references();
  if (!entries) return base::forward_error(entries);
  const auto waivers = catalog.waivers();
  if (!waivers) return base::forward_error(waivers);
  std::set<std::string> active;
  for (const db::ReferenceRow& row : active_references(*entries, utc_s)) active.insert(row.reference.record_id);
  std::vector<ShownReference> shown;
  for (auto row = entries->rbegin(); row != entries->rend(); ++row) {
    const calib::Reference& reference = row->reference;
    auto campaigns = catalog.campaigns_of_reference(reference.record_id);
    if (!campaigns) return base::forward_error(campaigns);
    shown.push_back({*row, standing_of(*row, active.contains(reference.record_id), utc_s),
                     days_until(reference.due_utc_s, utc_s), shown_waivers(*waivers, reference),
                     *std::move(campaigns)});
  }
  // What was entered last comes first already: of one day it stays so.
  std::ranges::stable_sort(shown, {}, [](const ShownReference& one) {
    const calib::Reference& reference = one.row.reference;
    return std::tuple(reference.kind, reference.name, rank_of(one.standing), -reference.issued_utc_s);
  });
  return shown;
}

json references_document(const std::vector<ShownReference>& shown) {
  json list = json::array();
  for (const ShownReference& one : shown) list.push_back(reference_document(one));
  return {{"references", std::move(list)}};
}

std::string references_table(const std::vector<ShownReference>& shown) {
  std::vector<std::vector<std::string>> table = {{"kind", "name", "certificate", "correction", "u (k=1)", "due", ""}};
  for (const ShownReference& one : shown) {
    const calib::Reference& reference = one.row.reference;
    table.push_back({std::string(calib::name_of(reference.kind)), reference.name, reference.certificate,
                     correction_text(reference), number_text(reference.standard_uncertainty, reference.kind),
                     iso_date(reference.due_utc_s), state_text(one)});
  }
  return text_table(table);
}

std::string reference_text(const ShownReference& shown) {
  const calib::Reference& reference = shown.row.reference;
  std::string text = fmt::format(
      "{} '{}'\n  certificate {}, issued {}, due {}: {}\n  correction {}, standard uncertainty {}\n  affects {}\n  "
      "entered on {} by {} as {}\n",
      calib::name_of(reference.kind), reference.name, reference.certificate, iso_date(reference.issued_utc_s),
      iso_date(reference.due_utc_s), state_text(shown), correction_text(reference),
      number_text(reference.standard_uncertainty, reference.kind), calib::bears_on(reference.kind),
      iso_date(shown.row.entered_utc_s), shown.row.user, reference.record_id);
  if (const auto& end = shown.row.retired) {
    text += fmt::format("  retired on {} by {}: {}\n", iso_date(end->utc_s), end->user, end->reason);
  }
  if (const auto& end = shown.row.withdrawn) {
    text += fmt::format("  withdrawn on {} by {}: {}\n", iso_date(end->utc_s), end->user, end->reason);
  }
  for (const ShownWaiver& waiver : shown.waivers) {
    text += fmt::format("  waived on {} by {}, key {}: {}{}\n", iso_date(waiver.waiver.utc_s), waiver.waiver.signer,
                        waiver.waiver.public_key_hex, waiver.waiver.reason,
                        waiver.good ? "" : " (DAMAGED: the signature does not match)");
  }
  if (!shown.campaigns.empty()) text += fmt::format("  used by {}\n", fmt::join(shown.campaigns, ", "));
  return text;
}

}  // namespace soak::station
