// SPDX-License-Identifier: Apache-2.0
#include "calib/deploy/detail/reference_lines.h"

#include <fmt/format.h>

#include "base/text.h"

namespace soak::calib::exporting {

std::vector<std::string> reference_lines(const std::vector<ReferenceUse>& uses,
                                         const std::function<std::string(std::string)>& clean) {
  std::vector<std::string> lines;
  for (const auto& [reference, waiver] : uses) {
    lines.push_back(fmt::format("reference: {} {}, certificate {}, issued {}, due {}, standard uncertainty {} {}",
                                name_of(reference.kind), clean(reference.name), clean(reference.certificate),
                                base::utc_text(reference.issued_utc_s), base::utc_text(reference.due_utc_s),
                                base::shortest(printed_per_si(reference.kind) * reference.standard_uncertainty),
                                printed_unit(reference.kind)));
    if (!waiver) continue;
    lines.push_back(fmt::format("  WAIVER, signed {} by {}: {}", base::utc_text(waiver->utc_s), clean(waiver->signer),
                                clean(waiver->reason)));
  }
  return lines;
}

}  // namespace soak::calib::exporting
