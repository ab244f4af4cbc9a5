// SPDX-License-Identifier: Apache-2.0
#include "hal/maps/detail/text_needs.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "hal/maps/detail/vocabulary.h"

namespace soak::hal {
namespace {

/// Sentences, each once.
class Needs {
 public:
  explicit Needs(const TextMap& map) : map_(map) {}

  void quantity(const std::string& name) {
    if (!find(name)) add(fmt::format("a text map of a {} needs [quantity.{}]", map_.kind, name));
  }
  void writable(const std::string& name) {
    quantity(name);
    const TextQuantity* held = find(name);
    if (held && held->write.empty()) add(fmt::format("[quantity.{}] needs a 'write'", name));
  }
  void word(const std::string& name, const char* code) {
    quantity(name);
    const TextQuantity* held = find(name);
    if (held && !held->code(code)) add(fmt::format("[quantity.{}] needs the code '{}' among its 'words'", name, code));
  }

  std::vector<std::string> sentences;

 private:
  const TextQuantity* find(const std::string& name) const {
    const auto found = map_.quantities.find(name);
    return found == map_.quantities.end() ? nullptr : &found->second;
  }
  void add(std::string text) {
    if (std::find(sentences.begin(), sentences.end(), text) == sentences.end()) sentences.push_back(std::move(text));
  }

  const TextMap& map_;
};

void chamber_needs(const TextMap& map, Needs& needs) {
  needs.quantity("air_c");
  needs.writable("set_point_c");
  needs.word(map.quantities.contains("actual_mode") ? "actual_mode" : "control_mode", "auto");
  for (const auto& [action, code] : {std::pair{"start", "auto"}, std::pair{"stop", "off"}}) {
    if (map.actions.contains(action)) continue;
    needs.writable("control_mode");
    needs.word("control_mode", code);
  }
  for (const auto& [name, quantity] : map.quantities) {
    if (name == "ramp_rate" || is_numbered(name, {kChamberOutput})) needs.writable(name);
    if (quantity.words.empty() || !is_numbered(name, {kChamberOutput})) continue;
    for (const char* code : {"on", "off"}) needs.word(name, code);
  }
}

void power_needs(const TextMap& map, Needs& needs) {
  needs.writable(std::string(kOutput) + "1");
  for (const auto& [name, quantity] : map.quantities) {
    if (is_numbered(name, {kOutput, kSetVoltage, kCurrentLimit})) needs.writable(name);
    if (quantity.words.empty() || !is_numbered(name, {kOutput, kState})) continue;
    for (const char* code : {"on", "off"}) needs.word(name, code);
  }
}

}  // namespace

std::vector<std::string> text_needs(const TextMap& map) {
  Needs needs(map);
  map.kind == "power" ? power_needs(map, needs) : chamber_needs(map, needs);
  return std::move(needs.sentences);
}

}  // namespace soak::hal
