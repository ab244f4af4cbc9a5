// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "calib/vocabulary/reference.h"

namespace soak::db {

/// Who put an end to something, when and why.
struct EndRecord {
  std::string reason;
  std::string user;
  double utc_s = 0.0;
};

/// An entry of the register of references: one certificate. Entries are only ever added.
struct ReferenceRow {
  calib::Reference reference;
  std::string user;  ///< who entered it
  double entered_utc_s = 0.0;
  std::optional<EndRecord> retired = std::nullopt;    ///< the reference is not used any more
  std::optional<EndRecord> withdrawn = std::nullopt;  ///< the entry is wrong: it counts as never made
};

/// A unit that is measured in every campaign, so that the station itself can be judged by it.
struct CheckStandardRow {
  std::string check_standard_id = {};  ///< UUIDv7 of the record
  std::string unit;                    ///< serial number
  double since_utc_s = 0.0;
  std::string reason;
  std::string user;
  std::optional<EndRecord> ended = std::nullopt;
};

}  // namespace soak::db
