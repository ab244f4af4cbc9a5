// SPDX-License-Identifier: Apache-2.0
#include "station/lab/slot_look.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <poll.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <exception>
#include <future>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "base/text.h"
#include "station/io/text.h"
#include "station/lab/unit_channel.h"

namespace soak::station {
namespace {

using nlohmann::json;
using std::chrono::steady_clock;

/// Longer than Imu takes to give up a unit that sends bytes and does not answer.
constexpr std::chrono::seconds kPatience{6};
constexpr int kLongestWait_ms = 50;
/// What units of every decoder can be asked to send.
constexpr hal::Imu::Settings kSettings{50.0, 5.0};

/// The unit's serial number and what else it tells; nothing as long as it has not told it.
std::optional<hal::ImuIdentity> identity_of(const hal::Imu& imu) {
  const auto& identity = imu.identity();
  const bool is_told = imu.state() == hal::ImuState::streaming && identity && !identity->serial.empty();
  return is_told ? identity : std::nullopt;
}

/// What the unit tells of itself; a serial number that no record can carry is none.
void take_identity(SlotFinding& finding, const hal::ImuIdentity& told) {
  if (const auto carried = check_carried_line(told.serial, "its serial number"); !carried) {
    finding.answer = SlotAnswer::anonymous;
    finding.trouble = fmt::format("{} {}", carried.error().where, carried.error().message);
    return;
  }
  finding.answer = SlotAnswer::identified;
  finding.identity = told;
  for (std::string* text : {&finding.identity.product, &finding.identity.firmware}) {
    if (!base::is_plain_line(*text)) text->clear();
  }
}

SlotFinding listen_to(const Slot& slot, const std::atomic<bool>& stop) {
  SlotFinding finding{slot.name, slot.power_output, SlotAnswer::silent, {}, {}};
  const auto failed = [&](const base::Error& error, SlotAnswer answer) {
    finding.answer = answer;
    finding.trouble = error.where.empty() ? error.message : fmt::format("{}: {}", error.where, error.message);
    return finding;
  };
  // The ranges of a type give its samples their scale; who the unit is it tells without.
  const std::unique_ptr<hal::Imu> imu = hal::make_imu({slot.address, slot.decoder});
  if (const auto opened = imu->open(kSettings); !opened) return failed(opened.error(), SlotAnswer::failed);
  std::vector<hal::ImuSample> samples;
  for (const auto end = steady_clock::now() + kPatience; steady_clock::now() < end && !stop;) {
    pollfd wire{imu->wait_fd(), POLLIN, 0};
    ::poll(&wire, 1, kLongestWait_ms);
    samples.clear();
    const auto polled = imu->poll(samples);
    if (const auto identity = polled ? identity_of(*imu) : std::nullopt) {
      take_identity(finding, *identity);
      return finding;
    }
    const bool was_heard = finding.answer == SlotAnswer::anonymous;
    if (!polled) return failed(polled.error(), was_heard ? SlotAnswer::anonymous : SlotAnswer::failed);
    if (imu->state() != hal::ImuState::silent) finding.answer = SlotAnswer::anonymous;
  }
  return finding;
}

/// What a library throws is the slot's trouble: the station has to hear that the look is over.
SlotFinding look_into(const Slot& slot, const std::atomic<bool>& stop) {
  try {
    return listen_to(slot, stop);
  } catch (const std::exception& error) {
    return {slot.name, slot.power_output, SlotAnswer::failed, {}, error.what()};
  }
}

std::string text_of(const SlotFinding& finding) {
  switch (finding.answer) {
    case SlotAnswer::identified:
      return fmt::format("{} ({})", finding.identity.serial, product_text(finding.identity));
    case SlotAnswer::anonymous:
      return "sends data, does not say who it is" + (finding.trouble.empty() ? "" : ": " + finding.trouble);
    case SlotAnswer::silent:
      return "no answer";
    case SlotAnswer::failed:
      break;
  }
  return finding.trouble;
}

json or_null(const std::string& text) { return text.empty() ? json() : json(text); }

}  // namespace

base::Result<std::vector<SlotFinding>> look_into_slots(const std::vector<Slot>& slots, const std::atomic<bool>& stop) {
  std::vector<std::future<SlotFinding>> looks;
  try {
    for (const Slot& slot : slots) {
      looks.push_back(std::async(std::launch::async, [&slot, &stop] { return look_into(slot, stop); }));
    }
  } catch (const std::exception& error) {  // no thread, or no memory
    return base::fail(base::ErrorKind::internal,
                      fmt::format("the computer gives no thread for each slot ({}): try again", error.what()), "slots");
  }
  std::vector<SlotFinding> findings;
  findings.reserve(looks.size());
  for (auto& look : looks) findings.push_back(look.get());
  return findings;
}

json look_document(const std::vector<SlotFinding>& findings) {
  constexpr std::array<const char*, 4> kAnswers = {"identified", "anonymous", "silent", "failed"};
  json slots = json::array();
  for (const SlotFinding& finding : findings) {
    slots.push_back({{"slot", finding.slot},
                     {"power_output", finding.power_output ? json(*finding.power_output) : json()},
                     {"answer", kAnswers.at(static_cast<std::size_t>(finding.answer))},
                     {"serial", or_null(finding.identity.serial)},
                     {"product", or_null(finding.identity.product)},
                     {"firmware", or_null(finding.identity.firmware)},
                     {"trouble", or_null(finding.trouble)}});
  }
  return {{"slots", std::move(slots)}};
}

std::string look_text(const std::vector<SlotFinding>& findings) {
  std::vector<std::string> texts;
  for (const SlotFinding& finding : findings)
    texts.push_back(fmt::format("slot {}: {}", finding.slot, text_of(finding)));
  return fmt::format("looked into: {}", fmt::join(texts, "; "));
}

}  // namespace soak::station
