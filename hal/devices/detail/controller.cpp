// SPDX-License-Identifier: Apache-2.0
#include "hal/devices/detail/controller.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <thread>

namespace soak::hal {
namespace {

bool contains(const std::vector<int>& numbers, int number) {
  return std::find(numbers.begin(), numbers.end(), number) != numbers.end();
}

}  // namespace

Controller::Controller(RegisterMap map) : map_(std::move(map)), link_(map_.link) {}

bool Controller::has(std::string_view quantity) const { return map_.quantities.contains(std::string(quantity)); }

bool Controller::has_action(std::string_view action) const { return map_.actions.contains(std::string(action)); }

QuantityAccess::Range Controller::range(const std::string& quantity) const {
  const Quantity& held = map_.quantities.at(quantity);
  return {held.min, held.max};
}

bool Controller::has_code(const std::string& quantity, const std::string& name) const {
  return map_.quantities.at(quantity).codes.contains(name);
}

double Controller::code(const std::string& quantity, const std::string& name) const {
  return map_.quantities.at(quantity).codes.at(name);
}

std::string Controller::place(const std::string& quantity) const {
  return fmt::format("register {}", map_.quantities.at(quantity).address);
}

std::string Controller::description() const { return fmt::format("{} at {}", map_.name, link_.address()); }

tl::unexpected<base::Error> Controller::fail(std::string message) const {
  return device_fault(*this, std::move(message));
}

base::Status Controller::connect() {
  link_.begin_call();
  if (link_.is_open()) return {};
  if (auto opened = link_.open(); !opened) return fail(opened.error().text);
  over_holes_ = true;
  for (const Probe& probe : map_.probes) {
    if (probe.link && *probe.link != link_kind()) continue;
    if (auto proved = prove(probe); !proved) {
      if (link_.is_open()) link_.give_up(proved.error().message);
      return proved;
    }
  }
  link_.confirm();
  return {};
}

LinkKind Controller::link_kind() const {
  return std::holds_alternative<ModbusTcp>(map_.link.address) ? LinkKind::tcp : LinkKind::rtu;
}

base::Status Controller::prove(const Probe& probe) {
  constexpr int read_holding = 3;
  const RegisterSpan span{read_holding, probe.address, word_count(probe.type), probe.name};
  const auto image = fetch({span});
  if (!image) return base::forward_error(image);
  Quantity quantity;
  quantity.type = probe.type;
  const std::uint16_t word = image->at({read_holding, probe.address});
  const int found = static_cast<int>(decode_value(quantity, {&word, 1}, 0));
  if (contains(probe.expected, found)) return {};
  return fail(fmt::format("{} (register {}) holds {}, not {}: {}", probe.name, probe.address, found,
                          fmt::join(probe.expected, " or "), probe.otherwise));
}

LinkResult Controller::fetch_block(const RegisterBlock& block, Image& image) {
  Words words(static_cast<std::size_t>(block.count));
  if (auto done = link_.read(block.function, block.address, words); !done) return done;
  for (std::size_t i = 0; i < words.size(); ++i)
    image[{block.function, block.address + static_cast<int>(i)}] = words[i];
  return {};
}

base::Result<Controller::Image> Controller::fetch(const std::vector<RegisterSpan>& spans) {
  Image image;
  for (const RegisterBlock& block : plan_blocks(spans, map_.link.max_block, over_holes_)) {
    const LinkResult done = fetch_block(block, image);
    if (done) continue;
    if (done.error().exception != 0 && block.has_holes) {
      over_holes_ = false;
      return fetch(spans);
    }
    return fail(fmt::format("{} ({}): {}", block.names, registers_text(block.address, block.count), done.error().text));
  }
  return image;
}

void Controller::append_spans(const std::string& name, std::vector<RegisterSpan>& spans) const {
  const Quantity& quantity = map_.quantities.at(name);
  spans.push_back({quantity.read_function, quantity.address, word_count(quantity.type), name});
  if (quantity.decimals_register) {
    spans.push_back({quantity.read_function, *quantity.decimals_register, 1, "decimals of " + name});
  }
}

base::Result<Controller::Content> Controller::content(const std::string& name, const Image& image) const {
  const Quantity& quantity = map_.quantities.at(name);
  Content content;
  for (int i = 0; i < word_count(quantity.type); ++i) {
    content.words.push_back(image.at({quantity.read_function, quantity.address + i}));
  }
  if (!quantity.decimals_register) return content;
  content.decimals = image.at({quantity.read_function, *quantity.decimals_register});
  if (content.decimals <= kMaxDecimals) return content;
  return fail(fmt::format("{}: its decimals (register {}) are {}, more than {}", name, *quantity.decimals_register,
                          content.decimals, kMaxDecimals));
}

base::Result<Controller::Content> Controller::fetch_content(const std::string& name) {
  std::vector<RegisterSpan> spans;
  append_spans(name, spans);
  const auto image = fetch(spans);
  if (!image) return base::forward_error(image);
  return content(name, *image);
}

base::Result<double> Controller::value(const std::string& name, const Image& image) const {
  const auto held = content(name, image);
  if (!held) return base::forward_error(held);
  return decode_value(map_.quantities.at(name), held->words, held->decimals);
}

base::Result<Values> Controller::read_all(const std::vector<std::string>& names) {
  if (auto ready = connect(); !ready) return base::forward_error(ready);
  std::vector<RegisterSpan> spans;
  for (const std::string& name : names) append_spans(name, spans);
  const auto image = fetch(spans);
  if (!image) return base::forward_error(image);
  Values values;
  for (const std::string& name : names) {
    const auto number = value(name, *image);
    if (!number) return base::forward_error(number);
    values[name] = *number;
  }
  return values;
}

base::Result<double> Controller::read(const std::string& name) {
  const auto values = read_all({name});
  if (!values) return base::forward_error(values);
  return values->at(name);
}

base::Result<std::vector<ChamberAlarm>> Controller::active_alarms() {
  constexpr int read_holding = 3;
  if (auto ready = connect(); !ready) return base::forward_error(ready);
  std::vector<RegisterSpan> spans;
  for (const AlarmRule& rule : map_.alarms) {
    for (const int address : rule.addresses) spans.push_back({read_holding, address, 1, rule.name});
  }
  const auto image = fetch(spans);
  if (!image) return base::forward_error(image);
  std::vector<ChamberAlarm> active;
  for (const AlarmRule& rule : map_.alarms) {
    const bool on = std::any_of(rule.addresses.begin(), rule.addresses.end(),
                                [&](int address) { return says_alarm(rule, image->at({read_holding, address})); });
    if (on) active.push_back({rule.name, rule.outputs_off});
  }
  return active;
}

base::Status Controller::check_limits(const std::string& name, double value) const {
  const Quantity& quantity = map_.quantities.at(name);
  if (value >= quantity.min.value_or(value) && value <= quantity.max.value_or(value)) return {};
  return base::bad_input(fmt::format("{} = {} is beyond its limits, {} to {}", name, value,
                                     quantity.min ? fmt::format("{}", *quantity.min) : "any",
                                     quantity.max ? fmt::format("{}", *quantity.max) : "any"),
                         description());
}

base::Status Controller::send(const std::string& name, const Words& words) {
  const Quantity& quantity = map_.quantities.at(name);
  const auto done = link_.write(*quantity.write_function, quantity.address, words);
  if (done) return {};
  return fail(fmt::format("writing {} ({}): {}", name, registers_text(quantity.address, word_count(quantity.type)),
                          done.error().text));
}

base::Status Controller::write(const std::string& name, double value) {
  if (auto within = check_limits(name, value); !within) return within;
  if (auto ready = connect(); !ready) return ready;
  const Quantity& quantity = map_.quantities.at(name);
  Content held;
  const bool compare = map_.write_policy.only_on_change && !quantity.command;
  if (compare || quantity.decimals_register) {
    auto fetched = fetch_content(name);
    if (!fetched) return base::forward_error(fetched);
    held = *std::move(fetched);
  }
  const auto words = encode_value(quantity, value, held.decimals);
  if (!words) return base::bad_input(fmt::format("{}: {}", name, words.error().message), description());
  if (compare && same_value(quantity, held.words, *words)) return {};
  if (auto sent = send(name, *words); !sent) return sent;
  return map_.write_policy.read_back && !quantity.command ? expect_words(name, *words) : base::Status{};
}

base::Status Controller::expect_words(const std::string& name, const Words& words) {
  constexpr int tries = 5;
  constexpr std::chrono::milliseconds pause{100};
  const Quantity& quantity = map_.quantities.at(name);
  for (int attempt = 1;; ++attempt) {
    const auto held = fetch_content(name);
    if (!held) return base::forward_error(held);
    if (same_value(quantity, held->words, words)) return {};
    if (attempt == tries) {
      return fail(fmt::format(
          "{} ({}) holds {} where {} was written", name, registers_text(quantity.address, word_count(quantity.type)),
          decode_value(quantity, held->words, held->decimals), decode_value(quantity, words, held->decimals)));
    }
    std::this_thread::sleep_for(pause);
  }
}

base::Status Controller::expect(const std::string& name, double value) {
  if (auto ready = connect(); !ready) return ready;
  const auto held = fetch_content(name);
  if (!held) return base::forward_error(held);
  const auto words = encode_value(map_.quantities.at(name), value, held->decimals);
  if (!words) return base::forward_error(words);
  return expect_words(name, *words);
}

base::Status Controller::run(const std::string& action) {
  for (const ActionStep& step : map_.actions.at(action)) {
    if (auto done = write(step.quantity, step.value); !done) return done;
    std::this_thread::sleep_for(std::chrono::duration<double>(step.delay_s));
  }
  return {};
}

}  // namespace soak::hal
