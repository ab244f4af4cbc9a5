// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "hal/devices/detail/mapped_power.h"
#include "hal/devices/detail/text_controller.h"
#include "hal/maps/detail/text_needs.h"
#include "hal/maps/detail/vocabulary.h"

namespace soak::hal {

base::Result<std::unique_ptr<UnitPower>> make_text_power(const TextMap& map) {
  if (map.kind != "power") {
    return base::bad_input(fmt::format("the text map is of kind \"{}\", not \"power\"", map.kind), map.file);
  }
  if (const auto needs = text_needs(map); !needs.empty()) {
    return base::bad_input(fmt::format("{}", fmt::join(needs, "; ")), map.file);
  }
  return make_mapped_power(std::make_shared<TextController>(map), kOutput);
}

}  // namespace soak::hal
