// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "hal/devices/detail/mapped_chamber.h"
#include "hal/devices/detail/text_controller.h"
#include "hal/maps/detail/text_needs.h"

namespace soak::hal {

base::Result<std::unique_ptr<Chamber>> make_text_chamber(const TextMap& map) {
  if (map.kind != "chamber") {
    return base::bad_input(fmt::format("the text map is of kind \"{}\", not \"chamber\"", map.kind), map.file);
  }
  if (const auto needs = text_needs(map); !needs.empty()) {
    return base::bad_input(fmt::format("{}", fmt::join(needs, "; ")), map.file);
  }
  return make_mapped_chamber(std::make_unique<TextController>(map));
}

}  // namespace soak::hal
