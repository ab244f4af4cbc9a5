// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "db/catalog/catalog.h"

namespace soak::station {

/// How an entry of the register stands today.
enum class ReferenceStanding : std::uint8_t { valid, due_soon, expired, superseded, retired, withdrawn };

[[nodiscard]] std::string_view name_of(ReferenceStanding standing);

/// A waiver, and whether its signature is good.
struct ShownWaiver {
  calib::Waiver waiver;
  bool good = false;
};

/// An entry with all that is known of it.
struct ShownReference {
  db::ReferenceRow row;
  ReferenceStanding standing = ReferenceStanding::valid;
  int days_left = 0;  ///< days_until() its due day
  std::vector<ShownWaiver> waivers;
  std::vector<std::string> campaigns;
};

/// Days of the calendar (UTC) from `utc_s` to a due day: 1 on the day before, 0 on the day itself, on which the
/// certificate is not good any more, negative after it.
[[nodiscard]] int days_until(double due_utc_s, double utc_s);

/// The whole register at `utc_s`, in the order of kinds and names: of each first the entry that stands for it, then
/// those of a retired reference, superseded and withdrawn ones, each the newest first.
[[nodiscard]] base::Result<std::vector<ShownReference>> shown_register(const db::Catalog& catalog, double utc_s);

/// docs/schema/reference-list.schema.json
[[nodiscard]] nlohmann::json references_document(const std::vector<ShownReference>& shown);

/// A table with a line per entry.
[[nodiscard]] std::string references_table(const std::vector<ShownReference>& shown);

/// All of one entry, over several lines.
[[nodiscard]] std::string reference_text(const ShownReference& shown);

}  // namespace soak::station
