// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "hal/devices/detail/mapped_chamber.h"
#include "hal/devices/detail/registers.h"
#include "hal/devices/detail/surveys.h"
#include "hal/links/detail/modbus_link.h"

namespace soak::hal {
namespace {

constexpr int kReadHolding = 3;

/// Asks one thing after the other. A link that cannot be opened any more ends it.
class ModbusSurvey {
 public:
  explicit ModbusSurvey(const RegisterMap& map) : map_(map), link_(map.link) {
    survey_.description = fmt::format("{} at {}", map.name, link_.address());
  }

  base::Result<ChamberSurvey> run() {
    for (const Probe& probe : map_.probes) {
      if (!probe.link || *probe.link == link_kind())
        add(SurveyKind::probe, probe.name, [&](auto& e) { ask(probe, e); });
    }
    for (const auto& [name, quantity] : map_.quantities) {
      if (!quantity.command) add(SurveyKind::quantity, name, [&, &q = quantity](auto& e) { ask(q, e); });
    }
    for (const AlarmRule& rule : map_.alarms) add(SurveyKind::alarm, rule.name, [&](auto& e) { ask(rule, e); });
    if (!lost_.empty()) return base::fail(base::ErrorKind::device, lost_, survey_.description);
    return std::move(survey_);
  }

 private:
  [[nodiscard]] LinkKind link_kind() const {
    return std::holds_alternative<ModbusTcp>(map_.link.address) ? LinkKind::tcp : LinkKind::rtu;
  }

  template <class Ask>
  void add(SurveyKind kind, const std::string& name, Ask ask_it) {
    if (!lost_.empty()) return;
    if (const auto opened = open_again(link_); !opened) {
      lost_ = opened.error().text;
      return;
    }
    SurveyEntry& entry = survey_.entries.emplace_back();
    entry.kind = kind;
    entry.name = name;
    ask_it(entry);
    if (link_.is_open()) link_.confirm();
    first_answer_.note(link_.is_open());
    if (first_answer_.missing())
      lost_ = fmt::format("none of the first three questions got a sound answer: {}", entry.trouble);
  }

  /// The registers; empty with the entry's trouble where they cannot be read.
  Words fetch(int function, int address, int count, SurveyEntry& entry) {
    Words words(static_cast<std::size_t>(count));
    if (const auto done = link_.read(function, address, words); !done) {
      entry.trouble = fmt::format("{}: {}", registers_text(address, count), done.error().text);
      words.clear();
    }
    return words;
  }

  void ask(const Probe& probe, SurveyEntry& entry) {
    entry.place = registers_text(probe.address, 1);
    const Words words = fetch(kReadHolding, probe.address, 1, entry);
    if (words.empty()) return;
    Quantity quantity;
    quantity.type = probe.type;
    const int found = static_cast<int>(decode_value(quantity, words, 0));
    entry.value = found;
    entry.text = fmt::format("{}", found);
    const auto& expected = probe.expected;
    if (std::find(expected.begin(), expected.end(), found) != expected.end()) return;
    entry.trouble = fmt::format("not {}: {}", fmt::join(expected, " or "), probe.otherwise);
  }

  void ask(const Quantity& quantity, SurveyEntry& entry) {
    entry.place = registers_text(quantity.address, word_count(quantity.type));
    const Words words = fetch(quantity.read_function, quantity.address, word_count(quantity.type), entry);
    if (words.empty()) return;
    int decimals = 0;
    if (quantity.decimals_register) {
      const Words held = fetch(quantity.read_function, *quantity.decimals_register, 1, entry);
      if (held.empty()) return;
      decimals = held.front();
      if (decimals > kMaxDecimals) {
        entry.trouble = fmt::format("its decimals (register {}) are {}", *quantity.decimals_register, decimals);
        return;
      }
    }
    tell(quantity, words, decimals, entry);
  }

  static void tell(const Quantity& quantity, const Words& words, int decimals, SurveyEntry& entry) {
    const double value = decode_value(quantity, words, decimals);
    entry.text = fmt::format("{:.6g}", value);
    if (std::isfinite(value)) entry.value = value;
    if (!quantity.codes.empty()) {
      const auto code = std::find_if(quantity.codes.begin(), quantity.codes.end(),
                                     [value](const auto& one) { return one.second == value; });
      if (code != quantity.codes.end()) entry.text = code->first;
      return;
    }
    if (is_credible(entry.name, value)) return;
    entry.trouble = "no chamber has that: sensor, word order or map";
    if (quantity.type != RegisterType::f32) return;
    const Words swapped(words.rbegin(), words.rend());
    const double other = decode_value(quantity, swapped, decimals);
    if (is_credible(entry.name, other)) {
      entry.trouble += fmt::format(" (in the other 'word_order' it reads {:.6g})", other);
    }
  }

  void ask(const AlarmRule& rule, SurveyEntry& entry) {
    bool active = false;
    std::vector<int> contents;
    for (const int address : rule.addresses) {
      const Words words = fetch(kReadHolding, address, 1, entry);
      if (words.empty()) return;
      active = active || says_alarm(rule, words.front());
      contents.push_back(words.front());
    }
    entry.place = fmt::format("register{} {}", rule.addresses.size() == 1 ? "" : "s", fmt::join(rule.addresses, ", "));
    entry.active = active;
    entry.text = fmt::format("{} ({})", active ? "ACTIVE" : "not active", fmt::join(contents, ", "));
  }

  const RegisterMap& map_;
  ModbusLink link_;
  ChamberSurvey survey_;
  FirstAnswer first_answer_;
  std::string lost_;
};

}  // namespace

base::Result<ChamberSurvey> survey(const RegisterMap& map) { return ModbusSurvey(map).run(); }

}  // namespace soak::hal
