// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "base/result.h"
#include "calib/vocabulary/reference.h"

namespace soak::station {

/// A certificate as a person enters it: numbers in the unit of the kind (K, deg, m/s2, V, ppm), dates as "2027-03-01".
struct EnteredReference {
  std::string kind;
  std::string name;
  std::string certificate;
  std::string issued;
  std::string due;
  double uncertainty = 0.0;          ///< expanded, as the certificate states it
  double coverage = 2.0;             ///< its factor k
  std::optional<double> correction;  ///< added to what the reference says; of gravity the value itself
};

/// Refuses (bad_input, where == "kind") a name that is no kind, with those that are.
[[nodiscard]] base::Result<calib::ReferenceKind> reference_kind(const std::string& name);

/// The entry in SI, without an id. Refuses (bad_input, where == the member's name, of the coverage factor "k") what is
/// no plain line, no date, issued after `now_s`, due before it was issued, and numbers that no certificate of that kind
/// has.
[[nodiscard]] base::Result<calib::Reference> reference_from(const EnteredReference& entry, double now_s);

}  // namespace soak::station
