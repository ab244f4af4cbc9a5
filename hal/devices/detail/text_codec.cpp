// SPDX-License-Identifier: Apache-2.0
#include "hal/devices/detail/text_codec.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <utility>

#include "base/text.h"
#include "hal/devices/detail/codec.h"
#include "hal/links/detail/text_link.h"

namespace soak::hal {
namespace {

constexpr std::string_view kPlaceholder = "{}";
constexpr int kValueTries = 3;  ///< for an answer that holds no value

std::string trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(' ');
  if (first == std::string_view::npos) return "";
  return std::string(text.substr(first, text.find_last_not_of(' ') - first + 1));
}

tl::unexpected<base::Error> unusable(std::string message) {
  return base::fail(base::ErrorKind::device, std::move(message));
}

/// A plus sign before a number means nothing.
std::string_view without_plus(std::string_view text) {
  const bool plus = text.size() > 1 && text[0] == '+' && text[1] != '+' && text[1] != '-';
  return plus ? text.substr(1) : text;
}

bool contains_text(const std::vector<std::string>& texts, const std::string& text) {
  return std::find(texts.begin(), texts.end(), text) != texts.end();
}

bool is_whole(const std::string& text) { return base::parse_int(text).has_value(); }

std::string quoted(const std::string& command) { return "'" + command + "'"; }

std::string field_text(const TextField& from) {
  if (from.character > 0) return fmt::format("character {} of '{}'", from.character, from.ask);
  return fmt::format("field {} of '{}'", from.field, from.ask);
}

/// Characters of a text in UTF-8.
std::size_t length_of(std::string_view text) {
  return static_cast<std::size_t>(
      std::ranges::count_if(text, [](char c) { return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U; }));
}

/// Within one call each command is sent once, however many values its answer carries.
class TextCodec final : public Codec {
 public:
  explicit TextCodec(const DeviceMap& map) : map_(map), link_(map.link) {}

  Link& link() override { return link_; }

  std::string place(const Quantity& quantity) const override { return field_text(quantity.text.from); }
  std::string place(const Probe& probe) const override { return field_text(probe.text.from); }
  std::string place(const AlarmRule& rule) const override { return field_text(rule.text.from); }

  Answer<std::vector<Content>> read(const std::vector<std::string>& names) override {
    Lines lines;
    std::vector<Content> contents;
    for (const std::string& name : names) {
      auto content = read_content(name, map_.quantities.at(name).text, lines);
      if (!content) return tl::unexpected(std::move(content.error()));
      contents.push_back(*std::move(content));
    }
    return contents;
  }

  Answer<ProbeAnswer> read(const Probe& probe) override {
    Lines lines;
    const auto found = read_field(probe.name, probe.text.from, lines);
    if (!found) return tl::unexpected(found.error());
    return ProbeAnswer{contains_text(probe.text.expected, *found), *found,
                       fmt::format("'{}'", fmt::join(probe.text.expected, "' or '"))};
  }

  Answer<std::vector<AlarmAnswer>> read(std::span<const AlarmRule> rules) override {
    Lines lines;
    std::vector<AlarmAnswer> answers;
    for (const AlarmRule& rule : rules) {
      const auto held = read_alarm(rule, lines);
      if (!held) return tl::unexpected(held.error());
      answers.push_back({!contains_text(rule.text.inactive, *held), lines.at(rule.text.from.ask)});
    }
    return answers;
  }

  base::Result<Content> encode(const Quantity& quantity, double value, const Content& /*held*/) const override {
    auto spelt = spell(quantity.text, value);
    if (!spelt) return base::forward_error(spelt);
    return Content{value, *std::move(spelt), {}, 0};
  }

  /// Whether two values are spelt alike.
  bool is_same(const Quantity& quantity, const Content& held, const Content& wanted) const override {
    const double half_step = quantity.text.words.empty() ? 0.5 * std::pow(10.0, -quantity.text.decimals) : 0.5;
    return std::abs(held.value - wanted.value) <= half_step;
  }

  Answer<void> write(const std::string& name, const Content& content) override {
    const std::string what = "writing " + name;
    const TextPlace& place = map_.quantities.at(name).text;
    const std::string command = write_command(place, content.text);
    if (map_.confirm) {
      const auto sent = link_.send_only(command);
      return sent ? confirm(what, command) : tl::unexpected(NoAnswer{what, quoted(command), sent.error().text});
    }
    Lines none;
    const auto done = ask(what, command, none);
    if (!done) return tl::unexpected(done.error());
    if (place.accepted.empty() || begins_with_any(*done, place.accepted)) return {};
    return tl::unexpected(NoAnswer{what, quoted(command), fmt::format("refused: '{}'", *done)});
  }

 private:
  /// Answers by their commands.
  using Lines = std::map<std::string, std::string>;

  /// The answer, asked for unless `lines` has it. `what`: for messages.
  Answer<std::string> ask(const std::string& what, const std::string& command, Lines& lines,
                          TextLink::Spoilt spoilt = TextLink::Spoilt::ask_again) {
    const auto known = lines.find(command);
    if (known != lines.end()) return known->second;
    const auto answer = link_.ask(command, spoilt);
    if (!answer) return tl::unexpected(NoAnswer{what, quoted(command), answer.error().text});
    if (begins_with_any(*answer, map_.refusals)) {
      return tl::unexpected(NoAnswer{what, quoted(command), fmt::format("refused: '{}'", *answer)});
    }
    return lines[command] = *answer;
  }

  Answer<std::string> read_field(const std::string& what, const TextField& from, Lines& lines) {
    auto answer = ask(what, from.ask, lines);
    if (!answer) {
      answer.error().place = field_text(from);
      return answer;
    }
    auto field = field_of(from, *answer);
    if (!field) return tl::unexpected(NoAnswer{what, field_text(from), field.error().message});
    return *std::move(field);
  }

  /// A value. An answer that holds none may have been spoilt on its way: it is asked for again.
  Answer<Content> read_content(const std::string& name, const TextPlace& place, Lines& lines) {
    for (int attempt = 1;; ++attempt) {
      const auto answer = ask(name, place.from.ask, lines);
      if (!answer) return tl::unexpected(NoAnswer{name, field_text(place.from), answer.error().why});
      const auto value = decode_answer(place, *answer);
      if (value) return Content{*value, field_of(place.from, *answer).value(), {}, 0};
      if (attempt == kValueTries) return tl::unexpected(NoAnswer{name, field_text(place.from), value.error().message});
      lines.erase(place.from.ask);
    }
  }

  /// What an alarm's field holds. One that is a number where there is no alarm is a number where there is one: an
  /// answer that is not belongs to another question, or was spoilt on its way, and is asked for again.
  Answer<std::string> read_alarm(const AlarmRule& rule, Lines& lines) {
    const bool is_number = rule.text.from.character == 0 && std::ranges::all_of(rule.text.inactive, is_whole);
    for (int attempt = 1;; ++attempt) {
      auto held = read_field(rule.name, rule.text.from, lines);
      if (!held || !is_number || is_whole(*held)) return held;
      if (attempt == kValueTries) {
        return tl::unexpected(
            NoAnswer{rule.name, field_text(rule.text.from), fmt::format("'{}' is no whole number", *held)});
      }
      lines.erase(rule.text.from.ask);
    }
  }

  /// Asks the controller what it says of a command that it did not answer. That list is emptied by reading it: what was
  /// spoilt cannot be read again.
  Answer<void> confirm(const std::string& what, const std::string& command) {
    // An error that is left in the controller's list would be taken for one of the next command.
    constexpr int longest_list = 32;
    std::vector<std::string> refusals;
    for (int i = 0; i < longest_list; ++i) {
      Lines none;
      const auto answer = ask(what, map_.confirm->ask, none, TextLink::Spoilt::give_up);
      if (!answer) return tl::unexpected(answer.error());
      if (begins_with_any(*answer, map_.confirm->accepted)) break;
      refusals.push_back(*answer);
    }
    if (refusals.empty()) return {};
    return tl::unexpected(NoAnswer{what, quoted(command), fmt::format("refused: '{}'", fmt::join(refusals, "', '"))});
  }

  const DeviceMap& map_;
  TextLink link_;
};

}  // namespace

std::unique_ptr<Codec> make_text_codec(const DeviceMap& map) { return std::make_unique<TextCodec>(map); }

std::vector<std::string> split_answer(std::string_view answer, std::string_view separator) {
  const bool blanks = separator == " ";
  const std::string text = blanks ? trimmed(answer) : std::string(answer);
  std::string_view rest = text;
  std::vector<std::string> fields;
  for (;;) {
    const std::size_t end = rest.find(separator);
    fields.push_back(trimmed(rest.substr(0, end)));
    if (end == std::string_view::npos) return fields;
    rest.remove_prefix(end + separator.size());
    while (blanks && rest.starts_with(' ')) rest.remove_prefix(1);
  }
}

base::Result<std::string> field_of(const TextField& from, std::string_view answer) {
  if (from.length && length_of(answer) != static_cast<std::size_t>(*from.length)) {
    return unusable(fmt::format("the answer '{}' does not have {} characters", answer, *from.length));
  }
  if (from.character > 0) {
    const auto at = static_cast<std::size_t>(from.character) - 1;
    if (at >= answer.size()) return unusable(fmt::format("the answer '{}' is too short", answer));
    return std::string(1, answer[at]);
  }
  std::vector<std::string> fields = split_answer(answer, from.separator);
  const auto wanted = static_cast<std::size_t>(from.fields.value_or(from.field));
  const bool right = from.fields ? fields.size() == wanted : fields.size() >= wanted;
  if (!right) {
    return unusable(fmt::format("the answer '{}' does not have {} field{}", answer, wanted, wanted == 1 ? "" : "s"));
  }
  return std::move(fields[static_cast<std::size_t>(from.field) - 1]);
}

base::Result<double> decode_answer(const TextPlace& place, std::string_view answer) {
  const auto field = field_of(place.from, answer);
  if (!field) return base::forward_error(field);
  if (place.words.empty()) {
    const auto number = base::parse_double(without_plus(*field));
    if (!number) return unusable(fmt::format("'{}' in the answer '{}' is not a number", *field, answer));
    return *number;
  }
  const auto found = std::find(place.words.begin(), place.words.end(), *field);
  if (found == place.words.end()) {
    return unusable(fmt::format("the map does not know the word '{}' in the answer '{}'", *field, answer));
  }
  return static_cast<double>(found - place.words.begin());
}

base::Result<std::string> spell(const TextPlace& place, double value) {
  if (place.words.empty()) return fmt::format("{:0{}.{}f}", value, place.width, place.decimals);
  const double last = static_cast<double>(place.words.size()) - 1.0;
  if (!(value >= 0.0 && value <= last) || value != std::floor(value)) {
    return base::bad_input(fmt::format("no code has the number {}", value));
  }
  return place.words[static_cast<std::size_t>(value)];
}

std::string write_command(const TextPlace& place, std::string_view spelt) {
  std::string command = place.write;
  const std::size_t at = command.find(kPlaceholder);
  return at == std::string::npos ? command : command.replace(at, kPlaceholder.size(), spelt);
}

bool begins_with_any(std::string_view answer, const std::vector<std::string>& beginnings) {
  return std::any_of(beginnings.begin(), beginnings.end(),
                     [&](const std::string& beginning) { return answer.starts_with(beginning); });
}

}  // namespace soak::hal
