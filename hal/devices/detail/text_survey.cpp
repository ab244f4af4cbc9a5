// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <string>
#include <utility>

#include "hal/devices/detail/answer.h"
#include "hal/devices/detail/mapped_chamber.h"
#include "hal/devices/detail/surveys.h"
#include "hal/links/detail/text_link.h"

namespace soak::hal {
namespace {

bool contains(const std::vector<std::string>& texts, const std::string& text) {
  return std::find(texts.begin(), texts.end(), text) != texts.end();
}

/// Asks one thing after the other. A link that cannot be opened any more ends it.
class TextSurvey {
 public:
  explicit TextSurvey(const TextMap& map) : map_(map), link_(map.link) {
    survey_.description = fmt::format("{} at {}", map.name, link_.address());
  }

  base::Result<ChamberSurvey> run() {
    for (const TextProbe& probe : map_.probes) {
      SurveyEntry* entry = add(SurveyKind::probe, probe.name, probe.from);
      if (entry && !contains(probe.expected, entry->text) && entry->trouble.empty()) {
        entry->trouble = fmt::format("not '{}': {}", fmt::join(probe.expected, "' or '"), probe.otherwise);
      }
    }
    for (const auto& [name, quantity] : map_.quantities) {
      if (SurveyEntry* entry = add(SurveyKind::quantity, name, quantity.from)) tell(quantity, *entry);
    }
    for (const TextAlarm& alarm : map_.alarms) {
      SurveyEntry* entry = add(SurveyKind::alarm, alarm.name, alarm.from);
      if (!entry || !entry->trouble.empty()) continue;
      entry->active = !contains(alarm.inactive, entry->text);
      entry->text = fmt::format("{} ({})", *entry->active ? "ACTIVE" : "not active", answer_);
    }
    if (!lost_.empty()) return base::fail(base::ErrorKind::device, lost_, survey_.description);
    return std::move(survey_);
  }

 private:
  /// An entry with the field as its text, or with its trouble; null once the link is lost.
  SurveyEntry* add(SurveyKind kind, const std::string& name, const TextField& from) {
    if (!lost_.empty()) return nullptr;
    if (const auto opened = open_again(link_); !opened) {
      lost_ = opened.error();
      return nullptr;
    }
    SurveyEntry& entry = survey_.entries.emplace_back();
    entry.kind = kind;
    entry.name = name;
    entry.place = fmt::format("field {} of '{}'", from.field, from.ask);
    fetch(from, entry);
    if (link_.is_open()) link_.confirm();
    first_answer_.note(link_.is_open());
    if (first_answer_.missing())
      lost_ = fmt::format("none of the first three questions got a sound answer: {}", entry.trouble);
    return &entry;
  }

  void fetch(const TextField& from, SurveyEntry& entry) {
    auto answer = link_.ask(from.ask);
    if (!answer) {
      entry.trouble = std::move(answer.error());
      return;
    }
    answer_ = *std::move(answer);
    const auto held = field_of(from, answer_);
    if (is_refusal(map_, answer_)) {
      entry.trouble = fmt::format("refused: '{}'", answer_);
    } else if (held) {
      entry.text = *held;
    } else {
      entry.trouble = held.error().message;
    }
  }

  void tell(const TextQuantity& quantity, SurveyEntry& entry) const {
    if (!entry.trouble.empty()) return;
    const auto value = decode_answer(quantity, answer_);
    if (!value) {
      entry.trouble = value.error().message;
    } else if (!quantity.words.empty()) {
      entry.text = quantity.words[static_cast<std::size_t>(*value)].first;
    } else {
      entry.value = *value;
      if (!is_credible(entry.name, *value)) entry.trouble = "no chamber has that: sensor or map";
    }
  }

  const TextMap& map_;
  TextLink link_;
  ChamberSurvey survey_;
  std::string answer_;
  FirstAnswer first_answer_;
  std::string lost_;
};

}  // namespace

base::Result<ChamberSurvey> survey(const TextMap& map) { return TextSurvey(map).run(); }

}  // namespace soak::hal
