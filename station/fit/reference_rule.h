// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "calib/vocabulary/reference.h"
#include "calib/vocabulary/warning.h"
#include "db/catalog/catalog.h"

namespace soak::station {

/// A reference is about to be due this long before its date.
inline constexpr double kDueSoon_s = 30.0 * 86400.0;

/// When a measurement is made, or is expected to be, Unix time.
struct MeasurementTime {
  double begin_utc_s = 0.0;
  double end_utc_s = 0.0;  ///< not before the beginning
};

/// What a measurement is made with.
struct JudgedReferences {
  std::vector<calib::ReferenceUse> uses;
  std::vector<std::string> notes;  ///< what the user should know: one sentence each
};

/// The entries that stand for their references at a time: of each kind and name the one that was issued last by then
/// (of the same day: entered last). A withdrawn entry stands for nothing. From its retirement on a reference is out,
/// with all entries that were made before it; a later entry brings it back.
[[nodiscard]] std::vector<db::ReferenceRow> active_references(const std::vector<db::ReferenceRow>& entries,
                                                              double utc_s);

/// The newest waiver for an entry, its signature checked; nothing where there is none. Fails (corrupt) for a damaged
/// one.
[[nodiscard]] base::Result<std::optional<calib::Waiver>> waiver_for(const std::vector<calib::Waiver>& waivers,
                                                                    const calib::Reference& reference);

/// The references of the station for a measurement. Refuses (bad_input) where one has expired when it begins and nobody
/// has signed for it, naming each and the two remedies; fails (corrupt) for a damaged waiver. Notes an empty register,
/// a reference that expires before the end, one whose first certificate is younger, one that was retired since, and
/// each waiver that is used.
[[nodiscard]] base::Result<JudgedReferences> judge_references(const db::Catalog& catalog, const MeasurementTime& time);

/// What the campaigns were measured with, each entry of the register once, with its newest waiver. In the place of a
/// withdrawn entry stands the one that corrects it, if there is one: of the same kind, name and certificate. In the
/// place of a waiver that is damaged or gone stands the newest good one for the same entry; where there is none, fails
/// (corrupt).
[[nodiscard]] base::Result<std::vector<calib::ReferenceUse>> references_of_campaigns(
    const db::Catalog& catalog, const std::vector<std::string>& campaigns);

/// What has become of these references since: `reference_retired`, `reference_withdrawn`, `reference_expired` (used
/// without a waiver, and no newer certificate is good now). Nothing of references that the register does not have.
[[nodiscard]] base::Result<std::vector<calib::Warning>> reference_warnings(
    const db::Catalog& catalog, const std::vector<calib::ReferenceUse>& uses);

/// "chamber_probe 'probe 3' (certificate D-K-15048)".
[[nodiscard]] std::string describe(const calib::Reference& reference);

}  // namespace soak::station
