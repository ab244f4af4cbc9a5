// SPDX-License-Identifier: Apache-2.0
#include "station/records/reference_entry.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <cstddef>

#include "station/io/text.h"

namespace soak::station {
namespace {

using calib::ReferenceKind;

constexpr double kLargestCoverage = 4.0;

/// Plausible numbers of a certificate, in the kind's printed unit: what is beyond is a typing mistake.
struct KindLimits {
  double uncertainty;
  double correction_min;
  double correction_max;
};

KindLimits limits_of(ReferenceKind kind) {
  constexpr std::array<KindLimits, calib::kReferenceKindNames.size()> kLimits = {{
      {10.0, -20.0, 20.0},             // chamber_probe, K
      {5.0, 0.0, 0.0},                 // fixture_squareness, deg: the angles of the faces are not corrected for
      {5.0, -5.0, 5.0},                // level, deg
      {0.1, 9.7, 9.9},                 // gravity, m/s2: from the equator to the poles, up to high mountains
      {5.0, -5.0, 5.0},                // supply, V
      {10'000.0, -100'000., 100'000.}  // rate, ppm
  }};
  return kLimits[static_cast<std::size_t>(kind)];
}

base::Result<double> date_of(const std::string& text, const std::string& where) {
  const auto utc_s = parse_iso_date(text);
  if (utc_s) return *utc_s;
  return base::bad_input(fmt::format("'{}' is not a date such as 2027-03-01", text), where);
}

base::Status check_correction(const calib::Reference& reference, const std::optional<double>& correction) {
  const KindLimits limits = limits_of(reference.kind);
  const auto unit = calib::printed_unit(reference.kind);
  const auto kind = calib::name_of(reference.kind);
  if (!correction) {
    if (reference.kind != ReferenceKind::gravity) return {};
    return base::bad_input("required for gravity: the local gravity itself, in m/s2", "correction");
  }
  if (reference.kind == ReferenceKind::fixture_squareness) {
    return base::bad_input("not valid for fixture_squareness, which has only an uncertainty", "correction");
  }
  if (*correction >= limits.correction_min && *correction <= limits.correction_max) return {};
  return base::bad_input(fmt::format("{} {} is not plausible for {}: must be from {} to {} {}", *correction, unit, kind,
                                     limits.correction_min, limits.correction_max, unit),
                         "correction");
}

base::Status check_numbers(const EnteredReference& entry, const calib::Reference& reference) {
  const double largest = limits_of(reference.kind).uncertainty;
  if (!(entry.uncertainty > 0.0) || !(entry.uncertainty <= largest)) {
    return base::bad_input(fmt::format("{} {} is not plausible for {}: must be more than 0 and at most {} {}",
                                       entry.uncertainty, calib::printed_unit(reference.kind),
                                       calib::name_of(reference.kind), largest, calib::printed_unit(reference.kind)),
                           "uncertainty");
  }
  if (!(entry.coverage >= 1.0) || !(entry.coverage <= kLargestCoverage)) {
    return base::bad_input(
        fmt::format("{} is not a coverage factor: must be from 1 to {}, usually 2", entry.coverage, kLargestCoverage),
        "k");
  }
  return check_correction(reference, entry.correction);
}

base::Status check_dates(const calib::Reference& reference, double now_s) {
  if (reference.issued_utc_s > now_s) {
    return base::bad_input("the date of issue is in the future; check it and the computer's clock", "issued");
  }
  if (reference.due_utc_s > reference.issued_utc_s) return {};
  return base::bad_input(
      fmt::format("the due date must be after the date of issue, {}", iso_date(reference.issued_utc_s)), "due");
}

}  // namespace

base::Result<ReferenceKind> reference_kind(const std::string& name) {
  const auto kind = calib::reference_kind_named(name);
  if (kind) return *kind;
  return base::bad_input(
      fmt::format("unknown kind '{}': use one of {}", name, fmt::join(calib::kReferenceKindNames, ", ")), "kind");
}

base::Result<calib::Reference> reference_from(const EnteredReference& entry, double now_s) {
  if (auto plain = check_carried_line(entry.name, "name"); !plain) return base::forward_error(plain);
  if (auto plain = check_carried_line(entry.certificate, "certificate"); !plain) return base::forward_error(plain);
  const auto kind = reference_kind(entry.kind);
  if (!kind) return base::forward_error(kind);
  const auto issued = date_of(entry.issued, "issued");
  if (!issued) return base::forward_error(issued);
  const auto due = date_of(entry.due, "due");
  if (!due) return base::forward_error(due);
  calib::Reference reference{{}, *kind, entry.name, entry.certificate, {}, 0.0, *issued, *due};
  if (auto status = check_dates(reference, now_s); !status) return base::forward_error(status);
  if (auto status = check_numbers(entry, reference); !status) return base::forward_error(status);
  // u = U / k  [JCGM 100:2008, 6.2.1]
  const double factor = calib::printed_per_si(*kind);
  reference.standard_uncertainty = entry.uncertainty / entry.coverage / factor;
  if (entry.correction) reference.correction = *entry.correction / factor;
  return reference;
}

}  // namespace soak::station
