// SPDX-License-Identifier: Apache-2.0
#include "hal/devices/detail/text_controller.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>
#include <utility>

#include "hal/devices/detail/answer.h"

namespace soak::hal {
namespace {

bool contains(const std::vector<std::string>& texts, const std::string& text) {
  return std::find(texts.begin(), texts.end(), text) != texts.end();
}

/// Whether two values are spelt alike.
bool same_value(const TextQuantity& quantity, double a, double b) {
  const double half_step = quantity.words.empty() ? 0.5 * std::pow(10.0, -quantity.decimals) : 0.5;
  return std::abs(a - b) <= half_step;
}

}  // namespace

TextController::TextController(TextMap map) : map_(std::move(map)), link_(map_.link) {}

bool TextController::has(std::string_view quantity) const { return map_.quantities.contains(std::string(quantity)); }

bool TextController::has_action(std::string_view action) const { return map_.actions.contains(std::string(action)); }

QuantityAccess::Range TextController::range(const std::string& quantity) const {
  const TextQuantity& held = map_.quantities.at(quantity);
  return {held.min, held.max};
}

bool TextController::has_code(const std::string& quantity, const std::string& name) const {
  return map_.quantities.at(quantity).code(name).has_value();
}

double TextController::code(const std::string& quantity, const std::string& name) const {
  return map_.quantities.at(quantity).code(name).value();
}

std::string TextController::place(const std::string& quantity) const {
  const TextField& from = map_.quantities.at(quantity).from;
  return fmt::format("field {} of '{}'", from.field, from.ask);
}

std::string TextController::description() const { return fmt::format("{} at {}", map_.name, link_.address()); }

tl::unexpected<base::Error> TextController::fault(const std::string& what, const base::Error& error) const {
  return device_fault(*this, fmt::format("{}: {}", what, error.message));
}

base::Status TextController::connect() {
  link_.begin_call();
  if (link_.is_open()) return {};
  if (auto opened = link_.open(); !opened) return device_fault(*this, opened.error());
  for (const TextProbe& probe : map_.probes) {
    if (auto proved = prove(probe); !proved) {
      if (link_.is_open()) link_.give_up(proved.error().message);
      return proved;
    }
  }
  link_.confirm();
  return {};
}

base::Status TextController::prove(const TextProbe& probe) {
  Answers answers;
  const auto answer = ask(probe.name, probe.from.ask, answers);
  if (!answer) return base::forward_error(answer);
  const auto found = field_of(probe.from, *answer);
  if (!found) return fault(probe.name, found.error());
  if (contains(probe.expected, *found)) return {};
  return device_fault(*this, fmt::format("{} ('{}') is '{}', not '{}': {}", probe.name, probe.from.ask, *found,
                                         fmt::join(probe.expected, "' or '"), probe.otherwise));
}

base::Result<std::string> TextController::ask(const std::string& what, const std::string& command, Answers& answers) {
  const auto known = answers.find(command);
  if (known != answers.end()) return known->second;
  const auto answer = link_.ask(command);
  if (!answer) return device_fault(*this, fmt::format("{} ('{}'): {}", what, command, answer.error()));
  if (is_refusal(map_, *answer)) {
    return device_fault(*this, fmt::format("{}: '{}' was refused: '{}'", what, command, *answer));
  }
  return answers[command] = *answer;
}

base::Result<double> TextController::fetch(const std::string& name, Answers& answers) {
  const TextQuantity& quantity = map_.quantities.at(name);
  const auto answer = ask(name, quantity.from.ask, answers);
  if (!answer) return base::forward_error(answer);
  auto value = decode_answer(quantity, *answer);
  if (!value) return fault(name, value.error());
  return value;
}

base::Result<Values> TextController::read_all(const std::vector<std::string>& names) {
  if (auto ready = connect(); !ready) return base::forward_error(ready);
  Answers answers;
  Values values;
  for (const std::string& name : names) {
    const auto value = fetch(name, answers);
    if (!value) return base::forward_error(value);
    values[name] = *value;
  }
  return values;
}

base::Result<std::vector<ChamberAlarm>> TextController::active_alarms() {
  if (auto ready = connect(); !ready) return base::forward_error(ready);
  Answers answers;
  std::vector<ChamberAlarm> active;
  for (const TextAlarm& alarm : map_.alarms) {
    const auto answer = ask(alarm.name, alarm.from.ask, answers);
    if (!answer) return base::forward_error(answer);
    const auto held = field_of(alarm.from, *answer);
    if (!held) return fault(alarm.name, held.error());
    if (!contains(alarm.inactive, *held)) active.push_back({alarm.name, alarm.outputs_off});
  }
  return active;
}

base::Status TextController::write(const std::string& name, double value) {
  const TextQuantity& quantity = map_.quantities.at(name);
  if (value < quantity.min.value_or(value) || value > quantity.max.value_or(value) || !std::isfinite(value)) {
    return base::bad_input(fmt::format("{} = {} is beyond its limits", name, value), description());
  }
  const auto spelt = spell(quantity, value);
  if (!spelt) return base::bad_input(fmt::format("{}: {}", name, spelt.error().message), description());
  if (auto ready = connect(); !ready) return ready;
  if (map_.write_policy.only_on_change) {
    Answers answers;
    const auto held = fetch(name, answers);
    if (!held) return base::forward_error(held);
    if (same_value(quantity, *held, value)) return {};
  }
  if (auto done = carry_out("writing " + name, write_command(quantity, *spelt)); !done) return done;
  return map_.write_policy.read_back ? read_back(name, value) : base::Status{};
}

base::Status TextController::carry_out(const std::string& what, const std::string& command) {
  if (map_.confirm) {
    if (auto told = link_.tell(command); !told) {
      return device_fault(*this, fmt::format("{} ('{}'): {}", what, command, told.error()));
    }
    return confirm(what, command);
  }
  Answers none;
  const auto done = ask(what, command, none);
  return done ? base::Status{} : base::forward_error(done);
}

base::Status TextController::confirm(const std::string& what, const std::string& command) {
  // An error that is left in the controller's list would be taken for one of the next command.
  constexpr int longest_list = 32;
  std::vector<std::string> refusals;
  for (int i = 0; i < longest_list; ++i) {
    Answers none;
    const auto answer = ask(what, map_.confirm->ask, none);
    if (!answer) return base::forward_error(answer);
    if (begins_with_any(*answer, map_.confirm->accepted)) break;
    refusals.push_back(*answer);
  }
  if (refusals.empty()) return {};
  return device_fault(*this, fmt::format("{}: '{}' was refused: '{}'", what, command, fmt::join(refusals, "', '")));
}

base::Status TextController::expect(const std::string& name, double value) {
  if (auto ready = connect(); !ready) return ready;
  return read_back(name, value);
}

base::Status TextController::read_back(const std::string& name, double value) {
  constexpr int tries = 5;
  constexpr std::chrono::milliseconds pause{100};
  const TextQuantity& quantity = map_.quantities.at(name);
  for (int attempt = 1;; ++attempt) {
    Answers answers;
    const auto held = fetch(name, answers);
    if (!held) return base::forward_error(held);
    if (same_value(quantity, *held, value)) return {};
    if (attempt == tries) {
      return device_fault(*this,
                          fmt::format("{} ({}) is {} where {} was written", name, place(name),
                                      spell(quantity, *held).value_or("?"), spell(quantity, value).value_or("?")));
    }
    std::this_thread::sleep_for(pause);
  }
}

base::Status TextController::run(const std::string& action) {
  for (const ActionStep& step : map_.actions.at(action)) {
    if (auto done = write(step.quantity, step.value); !done) return done;
    std::this_thread::sleep_for(std::chrono::duration<double>(step.delay_s));
  }
  return {};
}

}  // namespace soak::hal
