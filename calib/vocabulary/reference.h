// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/units.h"

namespace soak::calib {

/// What a reference of the laboratory is good for.
enum class ReferenceKind : std::uint8_t { chamber_probe, fixture_squareness, level, gravity, supply, rate };
inline constexpr std::array<std::string_view, 6> kReferenceKindNames = {
    "chamber_probe", "fixture_squareness", "level", "gravity", "supply", "rate"};
constexpr std::string_view name_of(ReferenceKind kind) { return kReferenceKindNames[static_cast<std::size_t>(kind)]; }

/// The kind of that name; nothing for a name that is none.
constexpr std::optional<ReferenceKind> reference_kind_named(std::string_view name) {
  for (std::size_t i = 0; i < kReferenceKindNames.size(); ++i) {
    if (kReferenceKindNames[i] == name) return static_cast<ReferenceKind>(i);
  }
  return std::nullopt;
}

/// Unit in which people give the numbers of a kind, and how many of it make one of the units below.
constexpr std::string_view printed_unit(ReferenceKind kind) {
  constexpr std::array<std::string_view, kReferenceKindNames.size()> kUnits = {"K", "deg", "deg", "m/s2", "V", "ppm"};
  return kUnits[static_cast<std::size_t>(kind)];
}
constexpr double printed_per_si(ReferenceKind kind) { return printed_unit(kind) == "deg" ? base::kDegPerRad : 1.0; }

/// What the numbers of a kind do to a calibration, for people; where nothing, why not.
constexpr std::string_view bears_on(ReferenceKind kind) {
  constexpr std::array<std::string_view, kReferenceKindNames.size()> kTexts = {
      "no number: curves are over the unit's own thermometer",
      "uncertainty of bias, scale and misalignment; known angles of faces stand in the positions",
      "uncertainty of misalignment where the level error was not estimated; a correction has no heading and counts as "
      "uncertainty",
      "scale of the accelerometers: local gravity and its uncertainty",
      "voltages that were recorded are corrected; uncertainty of biases that follow the supply",
      "rates that were recorded are corrected; uncertainty of the gyros' scale"};
  return kTexts[static_cast<std::size_t>(kind)];
}

/// One calibrated reference of the laboratory, as its certificate has it. Units by kind: chamber_probe K,
/// fixture_squareness rad (angle of a face to the nominal one), level rad, gravity m/s², supply V, rate ppm of the
/// rate.
struct Reference {
  std::string record_id;  ///< UUIDv7 of this entry of the register; a new certificate is a new entry
  ReferenceKind kind = ReferenceKind::chamber_probe;
  std::string name;  ///< what the laboratory calls it, unique within the kind: "probe 3", serial number
  std::string certificate;
  /// Added to what the reference says (chamber_probe, level, supply, rate); local gravity itself for kind gravity.
  /// certificates.h says what is done with it.
  std::optional<double> correction;
  double standard_uncertainty = 0.0;  ///< k = 1
  double issued_utc_s = 0.0;
  double due_utc_s = 0.0;  ///< expired from then on
};

/// A person's signed word that an expired reference may be used nevertheless. docs/records.md says what is signed.
struct Waiver {
  std::string waiver_id;  ///< UUIDv7
  std::string record_id;  ///< of the reference
  std::string reason;
  std::string signer;          ///< name
  std::string public_key_hex;  ///< Ed25519
  double utc_s = 0.0;          ///< whole seconds
  std::string signature_hex;   ///< Ed25519 by `public_key_hex`
};

/// A reference that campaigns were measured with.
struct ReferenceUse {
  Reference reference;
  std::optional<Waiver> waiver = std::nullopt;  ///< where it was expired
  std::vector<std::string> campaigns = {};      ///< those campaigns; empty: all that are looked at
};

}  // namespace soak::calib
