// SPDX-License-Identifier: Apache-2.0
#include "hal/maps/chamber_map.h"

#include "hal/devices/devices.h"
#include "settings/reader.h"

namespace soak::hal {
namespace {

/// Whether the file says that its controller speaks text; a file that cannot be read says nothing.
bool speaks_text(const std::string& text, const std::string& file) {
  const auto reader = SettingsReader::parse(text, file);
  return reader && reader->root().has("protocol") && reader->root().text("protocol", "") == "text";
}

base::Result<std::unique_ptr<Chamber>> make(const RegisterMap& map) { return make_modbus_chamber(map); }
base::Result<std::unique_ptr<Chamber>> make(const TextMap& map) { return make_text_chamber(map); }
base::Result<std::unique_ptr<UnitPower>> make_power(const RegisterMap& map) { return make_modbus_power(map); }
base::Result<std::unique_ptr<UnitPower>> make_power(const TextMap& map) { return make_text_power(map); }

}  // namespace

base::Result<ChamberMap> read_chamber_map(const std::string& file, MapUse use) {
  const auto text = read_settings_text(file);
  if (!text) return base::forward_error(text);
  if (speaks_text(*text, file)) {
    auto map = parse_text_map(*text, file, use);
    if (!map) return base::forward_error(map);
    return ChamberMap(*std::move(map));
  }
  auto map = parse_register_map(*text, file, use);
  if (!map) return base::forward_error(map);
  return ChamberMap(*std::move(map));
}

const std::string& name_of(const ChamberMap& map) {
  return std::visit([](const auto& one) -> const std::string& { return one.name; }, map);
}

std::string kind_of(const ChamberMap& map) {
  return std::visit([](const auto& one) { return one.kind; }, map);
}

double poll_s(const ChamberMap& map) {
  return std::visit([](const auto& one) { return one.link.poll_s; }, map);
}

base::Result<std::unique_ptr<Chamber>> make_chamber(const ChamberMap& map) {
  return std::visit([](const auto& one) { return make(one); }, map);
}

base::Result<std::unique_ptr<UnitPower>> make_unit_power(const ChamberMap& map) {
  return std::visit([](const auto& one) { return make_power(one); }, map);
}

}  // namespace soak::hal
