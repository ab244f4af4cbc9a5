// SPDX-License-Identifier: Apache-2.0
#include "hal/devices/survey.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <span>
#include <thread>
#include <utility>

#include "hal/devices/chamber.h"
#include "hal/devices/detail/codec.h"
#include "hal/maps/detail/registers.h"

namespace soak::hal {
namespace {

/// So many questions are asked of a controller that answers none: behind each fault the link pauses, and all of a map
/// would take minutes.
constexpr int kMostUnanswered = 3;

/// What a float would be if its words were in the other order; empty where that is no better.
std::string swapped_text(const std::string& name, const Quantity& quantity, const Content& content) {
  if (content.words.size() != 2) return "";
  const Words swapped(content.words.rbegin(), content.words.rend());
  const double other = decode_value(quantity.modbus, swapped, content.decimals);
  return is_credible(name, other) ? fmt::format(" (in the other 'word_order' it reads {:.6g})", other) : "";
}

/// Asks one thing after the other. A link that cannot be opened any more ends it.
class Survey {
 public:
  explicit Survey(const DeviceMap& map) : map_(map), codec_(make_codec(map)), link_(codec_->link()) {
    survey_.description = fmt::format("{} at {}", map.name, link_.address());
  }

  base::Result<ChamberSurvey> run() {
    for (const Probe& probe : map_.probes) {
      if (!probe.link || *probe.link == link_kind(map_)) add(SurveyKind::probe, probe.name, probe);
    }
    for (const auto& [name, quantity] : map_.quantities) {
      if (!quantity.command) add(SurveyKind::quantity, name, quantity);
    }
    for (const AlarmRule& rule : map_.alarms) add(SurveyKind::alarm, rule.name, rule);
    if (!lost_.empty()) return base::fail(base::ErrorKind::device, lost_, survey_.description);
    return std::move(survey_);
  }

 private:
  template <class Subject>
  void add(SurveyKind kind, const std::string& name, const Subject& subject) {
    if (!lost_.empty()) return;
    if (const auto opened = open_again(); !opened) {
      lost_ = opened.error().text;
      return;
    }
    SurveyEntry& entry = survey_.entries.emplace_back();
    entry.kind = kind;
    entry.name = name;
    entry.place = codec_->place(subject);
    auto asked = ask(subject, entry);
    // One answer may be lost on its way. Of a controller that has answered nothing yet that is not likely.
    if (!asked && answered_ && !link_.is_open() && open_again()) asked = ask(subject, entry);
    if (!asked) {
      const NoAnswer& fault = asked.error();
      entry.trouble = fault.place == entry.place ? fault.why : fmt::format("{}: {}", fault.place, fault.why);
    }
    if (link_.is_open()) link_.confirm();
    answered_ = answered_ || link_.is_open();
    if (!answered_ && survey_.entries.size() >= kMostUnanswered) {
      lost_ = fmt::format("none of the first three requests got a valid answer: {}", entry.trouble);
    }
  }

  /// Opens the link where it is closed; after a fault, when its pause is over. The pause is no part of the call.
  LinkResult open_again() {
    if (!link_.is_open()) std::this_thread::sleep_until(link_.next_try());
    link_.begin_call();
    return link_.open();
  }

  Answer<void> ask(const Probe& probe, SurveyEntry& entry) {
    const auto answer = codec_->read(probe);
    if (!answer) return tl::unexpected(answer.error());
    entry.text = answer->found;
    if (map_.protocol == MapProtocol::modbus) entry.value = std::stoi(answer->found);
    if (!answer->as_expected) entry.trouble = fmt::format("not {}: {}", answer->expected, probe.otherwise);
    return {};
  }

  Answer<void> ask(const Quantity& quantity, SurveyEntry& entry) {
    const auto contents = codec_->read(std::vector<std::string>{entry.name});
    if (!contents) return tl::unexpected(contents.error());
    const Content& content = contents->front();
    entry.text = content.text;
    if (std::isfinite(content.value) && quantity.text.words.empty()) entry.value = content.value;
    if (!quantity.codes.empty()) {
      const auto code = std::find_if(quantity.codes.begin(), quantity.codes.end(),
                                     [&](const auto& one) { return one.second == content.value; });
      if (code != quantity.codes.end()) entry.text = code->first;
    } else if (!is_credible(entry.name, content.value)) {
      entry.trouble =
          "impossible for a chamber: check sensor, word order and map" + swapped_text(entry.name, quantity, content);
    }
    return {};
  }

  Answer<void> ask(const AlarmRule& rule, SurveyEntry& entry) {
    const auto answers = codec_->read(std::span(&rule, 1));
    if (!answers) return tl::unexpected(answers.error());
    const AlarmAnswer& answer = answers->front();
    entry.active = answer.active;
    entry.text = fmt::format("{} ({})", answer.active ? "ACTIVE" : "not active", answer.found);
    return {};
  }

  const DeviceMap& map_;
  std::unique_ptr<Codec> codec_;
  Link& link_;
  ChamberSurvey survey_;
  bool answered_ = false;  ///< any question, also by a refusal
  std::string lost_;
};

}  // namespace

bool ChamberSurvey::sound() const {
  return std::all_of(entries.begin(), entries.end(), [](const SurveyEntry& entry) { return entry.trouble.empty(); });
}

base::Result<ChamberSurvey> survey_chamber(const DeviceMap& map) { return Survey(map).run(); }

}  // namespace soak::hal
