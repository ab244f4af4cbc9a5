// SPDX-License-Identifier: Apache-2.0
#include "hal/maps/detail/map_check.h"

#include <fmt/format.h>

#include <string>

namespace soak::hal {

base::Status require_kind(const RegisterMap& map, std::string_view kind) {
  if (map.kind == kind) return {};
  return base::bad_input(fmt::format("the register map is of kind \"{}\", not \"{}\"", map.kind, kind), map.file);
}

base::Status require_quantity(const RegisterMap& map, std::string_view name) {
  if (map.quantities.contains(std::string(name))) return {};
  return base::bad_input(fmt::format("a register map of kind \"{}\" needs [quantity.{}]", map.kind, name), map.file);
}

base::Status require_writable(const RegisterMap& map, std::string_view name) {
  if (auto there = require_quantity(map, name); !there) return there;
  if (map.quantities.at(std::string(name)).write_function) return {};
  return base::bad_input(fmt::format("[quantity.{}] needs a 'write_function'", name), map.file);
}

base::Status require_code(const RegisterMap& map, std::string_view name, std::string_view code) {
  if (auto there = require_quantity(map, name); !there) return there;
  if (map.quantities.at(std::string(name)).codes.contains(std::string(code))) return {};
  return base::bad_input(fmt::format("[quantity.{}] needs the code '{}'", name, code), map.file);
}

}  // namespace soak::hal
