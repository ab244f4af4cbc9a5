// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "calib/vocabulary/reference.h"
#include "calib/vocabulary/segment.h"

/// What certificates do to readings: corrections, and how well the corrected reading is known.
namespace soak::calib {

/// What the references of one kind say of a campaign's readings. Units as in Reference.
struct CertifiedReading {
  double correction = 0.0;                                    ///< to be added to what was read
  std::optional<double> standard_uncertainty = std::nullopt;  ///< with that correction; absent: no reference
  /// The references state different corrections and nobody knows which was read: none is applied, and the largest of
  /// them counts as uncertainty.
  bool undecided = false;
};

/// The references of that kind that `campaign` was measured with. One correction, or the same from all, is applied; a
/// reference without one has the correction 0.
[[nodiscard]] CertifiedReading certified_reading(std::span<const ReferenceUse> references, ReferenceKind kind,
                                                 std::string_view campaign);

/// Turns the rates of positions in which the fixture turns, as they were read, into those of the certificate.
void correct_rates(std::span<Segment> segments, std::span<const ReferenceUse> references, std::string_view campaign);

/// Turns voltages of the units' supply, as they were read, into those of the certificate.
void correct_supply(std::span<double> supply_v, std::span<const ReferenceUse> references, std::string_view campaign);

}  // namespace soak::calib
