// SPDX-License-Identifier: Apache-2.0
#include "calib/judge/waiver_text.h"

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

#include "base/text.h"

namespace soak::calib {

base::Result<std::string> waiver_text(const Waiver& waiver, const Reference& reference) {
  const std::string due = base::utc_text(reference.due_utc_s);
  const std::string signed_at = base::utc_text(waiver.utc_s);
  const std::array<std::pair<std::string_view, std::string_view>, 9> lines = {{
      {"waiver", waiver.waiver_id},
      {"reference", reference.record_id},
      {"kind", name_of(reference.kind)},
      {"name", reference.name},
      {"certificate", reference.certificate},
      {"due", due},
      {"reason", waiver.reason},
      {"signer", waiver.signer},
      {"signed", signed_at},
  }};
  std::string text = "soak-waiver-1\n";
  for (const auto& [key, value] : lines) {
    const auto is_control = [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7F; };
    if (std::any_of(value.begin(), value.end(), is_control)) {
      return base::bad_input("the text must be one line", std::string(key));
    }
    text.append(key).append(" ").append(value).append("\n");
  }
  return text;
}

}  // namespace soak::calib
