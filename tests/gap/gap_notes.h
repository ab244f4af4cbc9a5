// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <initializer_list>
#include <string_view>

#include "calib/gap/report/gap_report.h"
#include "tests/errors.h"

namespace soak::calib::gap {

/// Whether a report has a note of this code that names these objects.
inline bool has_note(const GapReport& report, std::string_view code,
                     std::initializer_list<std::string_view> objects = {}) {
  return std::ranges::any_of(
      report.notes, [&](const Warning& note) { return note.code == code && base::mentions(note.text, objects); });
}

}  // namespace soak::calib::gap
