// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace soak::calib {

/// What a reference of the laboratory is good for.
enum class ReferenceKind : std::uint8_t { chamber_probe, fixture_squareness, level, gravity, supply, rate };
inline constexpr std::array<std::string_view, 6> kReferenceKindNames = {
    "chamber_probe", "fixture_squareness", "level", "gravity", "supply", "rate"};
constexpr std::string_view name_of(ReferenceKind kind) { return kReferenceKindNames[static_cast<std::size_t>(kind)]; }

/// One calibrated reference of the laboratory, as its certificate has it. Units by kind: chamber_probe K,
/// fixture_squareness rad (angle of a face to the nominal one), level rad, gravity m/s², supply V, rate ppm of the
/// rate.
struct Reference {
  std::string record_id;  ///< of this entry of the register; a new certificate is a new entry
  ReferenceKind kind = ReferenceKind::chamber_probe;
  std::string name;  ///< what the laboratory calls it, unique within the kind: "probe 3", serial number
  std::string certificate;
  /// Added to what the reference says (chamber_probe, level, supply, rate); local gravity itself for kind gravity.
  std::optional<double> correction;
  double standard_uncertainty = 0.0;  ///< k = 1
  double issued_utc_s = 0.0;
  double due_utc_s = 0.0;  ///< expired from then on
};

/// A person's signed word that an expired reference may be used nevertheless.
struct Waiver {
  std::string waiver_id;
  std::string record_id;  ///< of the reference
  std::string reason;
  std::string signer;          ///< name
  std::string public_key_hex;  ///< Ed25519
  double utc_s = 0.0;
};

/// A reference that a campaign was measured with.
struct ReferenceUse {
  Reference reference;
  std::optional<Waiver> waiver;  ///< where it was expired
};

}  // namespace soak::calib
