// SPDX-License-Identifier: Apache-2.0
#include "hal/text/text_needs.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace soak::hal {
namespace {

/// Sentences, each once.
class Needs {
 public:
  explicit Needs(const TextMap& map) : map_(map) {}

  void quantity(const std::string& name) {
    if (!find(name)) add(fmt::format("a text map of a chamber needs [quantity.{}]", name));
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

}  // namespace

std::vector<std::string> text_needs(const TextMap& map) {
  Needs needs(map);
  needs.quantity("air_c");
  needs.writable("set_point_c");
  needs.word(map.quantities.contains("actual_mode") ? "actual_mode" : "control_mode", "auto");
  for (const auto& [action, code] : {std::pair{"start", "auto"}, std::pair{"stop", "off"}}) {
    if (map.actions.contains(action)) continue;
    needs.writable("control_mode");
    needs.word("control_mode", code);
  }
  if (map.quantities.contains("ramp_rate")) needs.writable("ramp_rate");
  return needs.sentences;
}

}  // namespace soak::hal
