// SPDX-License-Identifier: Apache-2.0
#include "station/commands/waiver_note.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <string>

#include "station/fit/reference_rule.h"
#include "station/io/text.h"
#include "station/records/signing.h"

namespace soak::station {

void note_waivers(const std::vector<calib::ReferenceUse>& references, Output& output) {
  std::vector<std::string> texts;
  for (const auto& [reference, waiver] : references) {
    if (!waiver) continue;
    texts.push_back(fmt::format("{}, due {}, by the waiver of {}: {}", describe(reference),
                                iso_date(reference.due_utc_s), waiver->signer, waiver->reason));
  }
  if (!texts.empty()) output.note(fmt::format("warning: measured with {}", fmt::join(texts, "; ")));
  for (const calib::Warning& warning : waiver_warnings(references)) output.note("warning: " + warning.text);
}

}  // namespace soak::station
