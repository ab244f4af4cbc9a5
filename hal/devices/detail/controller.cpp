// SPDX-License-Identifier: Apache-2.0
#include "hal/devices/detail/controller.h"

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <thread>
#include <utility>

namespace soak::hal {

std::unique_ptr<Codec> make_codec(const DeviceMap& map) {
  return map.protocol == MapProtocol::text ? make_text_codec(map) : make_modbus_codec(map);
}

Controller::Controller(DeviceMap map) : map_(std::move(map)), codec_(make_codec(map_)) {}

// --- what the map says

bool Controller::has(std::string_view quantity) const { return map_.quantities.contains(std::string(quantity)); }

bool Controller::has_action(std::string_view action) const { return map_.actions.contains(std::string(action)); }

Controller::Range Controller::range(const std::string& quantity) const {
  const Quantity& held = map_.quantities.at(quantity);
  return {held.min, held.max};
}

std::optional<double> Controller::code(const std::string& quantity, const std::string& name) const {
  const auto& codes = map_.quantities.at(quantity).codes;
  const auto found = codes.find(name);
  return found == codes.end() ? std::nullopt : std::optional<double>(found->second);
}

std::string Controller::place(const std::string& quantity) const { return codec_->place(map_.quantities.at(quantity)); }

std::string Controller::description() const { return fmt::format("{} at {}", map_.name, codec_->link().address()); }

tl::unexpected<base::Error> Controller::fail(std::string message) const {
  return base::fail(base::ErrorKind::device, std::move(message), description());
}

tl::unexpected<base::Error> Controller::fail(const NoAnswer& fault) const {
  return fail(fmt::format("{} ({}): {}", fault.what, fault.place, fault.why));
}

// --- reading

base::Status Controller::connect() {
  Link& link = codec_->link();
  link.begin_call();
  if (link.is_open()) return {};
  if (auto opened = link.open(); !opened) return fail(opened.error().text);
  codec_->begin_connection();
  for (const Probe& probe : map_.probes) {
    if (probe.link && *probe.link != link_kind(map_)) continue;
    if (auto proved = prove(probe); !proved) {
      if (link.is_open()) link.give_up(proved.error().message);
      return proved;
    }
  }
  link.confirm();
  return {};
}

base::Status Controller::prove(const Probe& probe) {
  const auto answer = codec_->read(probe);
  if (!answer) return fail(answer.error());
  if (answer->as_expected) return {};
  return fail(fmt::format("{} ({}) is {}, not {}: {}", probe.name, codec_->place(probe), answer->found,
                          answer->expected, probe.otherwise));
}

base::Result<Values> Controller::read_all(const std::vector<std::string>& names) {
  if (auto ready = connect(); !ready) return base::forward_error(ready);
  const auto contents = codec_->read(names);
  if (!contents) return fail(contents.error());
  Values values;
  for (std::size_t i = 0; i < names.size(); ++i) values[names[i]] = (*contents)[i].value;
  return values;
}

base::Result<std::vector<ChamberAlarm>> Controller::active_alarms() {
  if (auto ready = connect(); !ready) return base::forward_error(ready);
  const auto answers = codec_->read(map_.alarms);
  if (!answers) return fail(answers.error());
  std::vector<ChamberAlarm> active;
  for (std::size_t i = 0; i < map_.alarms.size(); ++i) {
    if ((*answers)[i].active) active.push_back({map_.alarms[i].name, map_.alarms[i].outputs_off});
  }
  return active;
}

// --- writing

base::Status Controller::check_limits(const std::string& name, double value) const {
  const Quantity& quantity = map_.quantities.at(name);
  const bool within = value >= quantity.min.value_or(value) && value <= quantity.max.value_or(value);
  if (within && std::isfinite(value)) return {};
  const auto text = [](const std::optional<double>& limit) { return limit ? fmt::format("{}", *limit) : "any"; };
  return base::bad_input(
      fmt::format("{} = {} is beyond its limits, {} to {}", name, value, text(quantity.min), text(quantity.max)),
      description());
}

base::Result<Content> Controller::held_content(const std::string& name) {
  auto contents = codec_->read(std::vector<std::string>{name});
  if (!contents) return fail(contents.error());
  return std::move(contents->front());
}

base::Result<Content> Controller::encode(const std::string& name, double value, const Content& held) const {
  auto content = codec_->encode(map_.quantities.at(name), value, held);
  if (!content) return base::bad_input(fmt::format("{}: {}", name, content.error().message), description());
  return content;
}

base::Status Controller::write(const std::string& name, double value, Held rule) {
  if (auto within = check_limits(name, value); !within) return within;
  if (auto ready = connect(); !ready) return ready;
  const Quantity& quantity = map_.quantities.at(name);
  const bool compare = map_.write_policy.only_on_change && !quantity.command;
  Content held;
  if (compare || codec_->needs_held(quantity)) {
    auto read = held_content(name);
    if (!read) return base::forward_error(read);
    held = *std::move(read);
  }
  const auto wanted = encode(name, value, held);
  if (!wanted) return base::forward_error(wanted);
  const bool is_held = compare && codec_->is_same(quantity, held, *wanted);
  if (is_held && rule == Held::by_policy) return {};
  if (const auto written = codec_->write(name, *wanted); !written) {
    return is_held && answers() ? base::Status{} : fail(written.error());
  }
  return map_.write_policy.read_back && !quantity.command ? expect_content(name, *wanted) : base::Status{};
}

base::Status Controller::expect(const std::string& name, double value) {
  if (auto ready = connect(); !ready) return ready;
  Content held;
  if (codec_->needs_held(map_.quantities.at(name))) {
    auto read = held_content(name);
    if (!read) return base::forward_error(read);
    held = *std::move(read);
  }
  const auto wanted = encode(name, value, held);
  return wanted ? expect_content(name, *wanted) : base::forward_error(wanted);
}

base::Status Controller::expect_content(const std::string& name, const Content& wanted) {
  constexpr int tries = 5;
  constexpr std::chrono::milliseconds pause{100};
  const Quantity& quantity = map_.quantities.at(name);
  for (int attempt = 1;; ++attempt) {
    const auto held = held_content(name);
    if (!held) return base::forward_error(held);
    if (codec_->is_same(quantity, *held, wanted)) return {};
    if (attempt == tries) {
      return fail(
          fmt::format("{} ({}) holds {} where {} was written", name, codec_->place(quantity), held->text, wanted.text));
    }
    std::this_thread::sleep_for(pause);
  }
}

base::Status Controller::run(const std::string& action, Held held) {
  for (const ActionStep& step : map_.actions.at(action)) {
    if (auto done = write(step.quantity, step.value, held); !done) return done;
    std::this_thread::sleep_for(std::chrono::duration<double>(step.delay_s));
  }
  return {};
}

}  // namespace soak::hal
