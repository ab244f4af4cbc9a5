// SPDX-License-Identifier: Apache-2.0
#include "station/alarms/alarm_sender.h"

#include <fmt/format.h>

#include <chrono>
#include <exception>
#include <future>
#include <nlohmann/json.hpp>
#include <utility>

#include "station/alarms/alarm_message.h"
#include "station/alarms/alarm_rules.h"
#include "station/io/host.h"
#include "station/runs/run_archive.h"

namespace soak::station {
namespace {

using nlohmann::json;

constexpr std::chrono::milliseconds kLook{500};

double steady_s() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

/// As those of the status, which an engine that stands still does not publish.
json engine_stuck() {
  return {{"code", "engine_stuck"},
          {"about", nullptr},
          {"level", "alarm"},
          {"title", "The station stands still: soakd waits for a device or a disk"},
          {"detail", nullptr},
          {"action",
           "Go to the chamber: the station does not drive it now. Then look at soakd's log for what it waits for."},
          {"deadline", nullptr},
          {"calls", true}};
}

}  // namespace

AlarmSender::AlarmSender(StationService& lab, std::vector<std::unique_ptr<Delivery>> deliveries) : lab_(lab) {
  for (auto& delivery : deliveries) {
    const std::string way = delivery->way();
    couriers_.push_back(std::make_unique<Courier>(
        std::move(delivery),
        [this, way](const std::string& kind, const std::string& text) { lab_.note(kind, way, text, ""); }));
  }
  if (!couriers_.empty()) thread_ = std::thread([this] { watch(); });
}

AlarmSender::~AlarmSender() {
  stop();
  if (thread_.joinable()) thread_.join();
}

void AlarmSender::stop() {
  {
    const std::lock_guard lock(mutex_);
    quits_ = true;
    changed_.notify_all();
  }
  for (const auto& courier : couriers_) courier->stop();
}

json AlarmSender::document() const {
  json ways = json::array();
  for (const auto& courier : couriers_) ways.push_back(courier->document());
  return {{"ways", std::move(ways)}};
}

base::Result<json> AlarmSender::test(const std::string& user) {
  if (couriers_.empty()) {
    return base::bad_input(
        "nobody is told of alarms: write [alarms.mail] or [alarms.webhook] into the station's configuration and start "
        "soakd again",
        "alarms");
  }
  const std::unique_lock turn(test_, std::try_to_lock);
  if (!turn) return base::fail(base::ErrorKind::internal, "another test is being sent", kBusy);
  const AlarmMessage message = message_of("test", fmt::format("A test by {}: nothing is wrong", user), place_now(""));
  std::vector<std::future<base::Status>> tries;
  for (const auto& courier : couriers_) {
    tries.push_back(std::async(std::launch::async, [&] { return courier->test(message, user); }));
  }
  json ways = json::array();
  for (std::size_t i = 0; i < tries.size(); ++i) {
    const base::Status sent = tries[i].get();
    const Delivery& delivery = couriers_[i]->delivery();
    const std::string trouble = sent ? "" : one_line(sent.error().message);
    lab_.note(sent ? "alarm_sent" : "alarm_not_sent", delivery.way(),
              fmt::format("{} to {}: a test{}", sent ? "sent" : "not sent", delivery.destination(),
                          trouble.empty() ? "" : ": " + trouble),
              user);
    ways.push_back({{"way", delivery.way()},
                    {"to", delivery.destination()},
                    {"trouble", trouble.empty() ? json() : json(trouble)}});
  }
  return json{{"ways", std::move(ways)}};
}

void AlarmSender::watch() {
  std::unique_lock lock(mutex_);
  while (!quits_) {
    lock.unlock();
    try {
      look();
    } catch (const std::exception& error) {  // no memory: the next look may have some
      log_line(fmt::format("the look for alarms broke off: {}", error.what()));
    }
    lock.lock();
    changed_.wait_for(lock, kLook, [this] { return quits_; });
  }
}

void AlarmSender::look() {
  const std::uint64_t version = lab_.status_version();
  const json status = lab_.status();
  const json& campaign = status.at("campaign");
  const std::string name = campaign.is_object() ? campaign.at("name").get<std::string>() : "";
  json alarms = status.at("alarms");
  // A status that stands still cannot say so itself.
  if (turns_.stand_still(version, steady_s())) alarms.push_back(engine_stuck());
  const auto may_last = [&](std::string_view code, std::string_view about) {
    return may_last_unseen(status, code, about);
  };
  for (const AlarmBook::Entry& entry : book_.take(alarms, steady_s(), may_last)) tell(entry, name);
}

void AlarmSender::tell(const AlarmBook::Entry& entry, const std::string& campaign) {
  if (entry.turn == AlarmTurn::held_back) {
    lab_.note("alarm_not_sent", entry.alarm.at("title"),
              fmt::format("held back: more than {:.0f} alarms began of late", AlarmBook::kMostAtOnce), "");
    return;
  }
  const AlarmMessage message = message_of(entry, place_now(campaign));
  for (const auto& courier : couriers_) courier->add(message);
}

}  // namespace soak::station
