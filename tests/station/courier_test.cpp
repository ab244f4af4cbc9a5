// SPDX-License-Identifier: Apache-2.0
// What becomes of messages where a way takes some of them only, or none, or breaks.
#include "station/alarms/courier.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <future>
#include <memory>
#include <mutex>
#include <new>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "station/alarms/alarm_sender.h"
#include "tests/station/http_scripted_station.h"

namespace soak::station {
namespace {

using namespace std::chrono_literals;

/// What was tried so far; a test waits for more of it.
class Tried {
 public:
  void add(const std::string& subject) {
    const std::lock_guard lock(mutex_);
    subjects_.push_back(subject);
    changed_.notify_all();
  }
  /// Those so far, once they are that many.
  std::vector<std::string> first(std::size_t count) {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, 60s, [&] { return subjects_.size() >= count; });
    return subjects_;
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<std::string> subjects_;
};

class ScriptedDelivery final : public Delivery {
 public:
  using Server = std::function<base::Status(const std::string& subject, const std::atomic<bool>& stop)>;
  ScriptedDelivery(Tried& tried, Server server) : tried_(tried), server_(std::move(server)) {}

  std::string way() const override { return "mail"; }
  std::string destination() const override { return "eva@lab.example"; }
  base::Status send(const AlarmMessage& message, const std::atomic<bool>& stop) const override {
    tried_.add(message.subject);
    return server_(message.subject, stop);
  }

 private:
  Tried& tried_;
  Server server_;
};

std::unique_ptr<Delivery> delivery(Tried& tried, ScriptedDelivery::Server server) {
  return std::make_unique<ScriptedDelivery>(tried, std::move(server));
}

AlarmMessage message(const std::string& subject) { return {subject, subject + "\n", {}}; }

base::Status refused() { return base::fail(base::ErrorKind::device, "554 no", "mail.example:25"); }

void pass_over(const std::string&, const std::string&) {}

TEST(Courier, ANewMessageIsTriedBeforeOneThatTheServerDoesNotTake) {
  Tried tried;
  Courier courier(
      delivery(tried, [](const auto& subject, const auto&) { return subject == "A" ? refused() : base::Status(); }),
      pass_over);
  courier.add(message("A"));
  ASSERT_EQ(tried.first(2).size(), 2U);
  courier.add(message("B"));  // ten seconds before A would be tried again
  const auto subjects = tried.first(3);
  ASSERT_GE(subjects.size(), 3U);
  EXPECT_EQ(subjects[2], "B");
}

TEST(Courier, ADeliveryThatThrowsIsATryThatFailed) {
  Tried tried;
  Tried noted;
  Courier courier(delivery(tried,
                           [](const auto& subject, const auto&) -> base::Status {
                             if (subject == "A") throw std::runtime_error("no luck");
                             return {};
                           }),
                  [&](const auto& kind, const auto& text) { noted.add(kind + " " + text); });
  courier.add(message("A"));
  courier.add(message("B"));
  const auto notes = noted.first(2);
  ASSERT_EQ(notes.size(), 2U);
  EXPECT_NE(notes[0].find("alarm_not_sent not sent to eva@lab.example: A: the try broke off: no luck"),
            std::string::npos);
  EXPECT_NE(notes[1].find("alarm_sent sent to eva@lab.example: B"), std::string::npos);
  EXPECT_FALSE(courier.test(message("A"), "eva"));
}

/// Its status cannot be made the first time.
class ShortOfMemory final : public ScriptedStation {
 public:
  json status() const override {
    if (!was_asked_.exchange(true)) throw std::bad_alloc();
    return ScriptedStation::status();
  }

 private:
  mutable std::atomic<bool> was_asked_ = false;
};

TEST(AlarmSender, ALookThatThrowsIsFollowedByAnother) {
  ShortOfMemory lab;
  auto status = ShortOfMemory::idle_status();
  status["data"]["trouble"] = "it is gone";
  for (auto& unit : status["units"]) unit["attitude"] = nullptr;
  lab.set_status(status);
  Tried tried;
  std::vector<std::unique_ptr<Delivery>> deliveries;
  deliveries.push_back(delivery(tried, [](const auto&, const auto&) { return base::Status(); }));
  AlarmSender sender(lab, std::move(deliveries));
  const auto subjects = tried.first(1);
  ASSERT_EQ(subjects.size(), 1U);
  EXPECT_NE(subjects[0].find("The data folder is gone"), std::string::npos);
}

TEST(AlarmSender, ATestIsKeptWithItsTimeItsUserAndWhatTheServerAnswered) {
  ScriptedStation lab;
  Tried tried;
  std::atomic<bool> takes = true;
  std::vector<std::unique_ptr<Delivery>> deliveries;
  deliveries.push_back(delivery(tried, [&](const auto&, const auto&) { return takes ? base::Status() : refused(); }));
  AlarmSender sender(lab, std::move(deliveries));
  const auto way = [&] { return sender.document().at("ways").at(0); };
  EXPECT_TRUE(way().at("test").is_null());
  const auto utc_s = [] { return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()); };
  const double before_s = utc_s().count();
  ASSERT_TRUE(sender.test("eva"));
  const auto taken = way();
  EXPECT_EQ(taken.at("test").at("user"), "eva");
  EXPECT_TRUE(taken.at("test").at("trouble").is_null());
  EXPECT_GE(taken.at("test").at("utc_s").get<double>(), before_s);
  EXPECT_LE(taken.at("test").at("utc_s").get<double>(), utc_s().count());
  EXPECT_EQ(taken.at("sent_utc_s"), taken.at("test").at("utc_s"));
  takes = false;
  ASSERT_TRUE(sender.test("bob"));
  EXPECT_EQ(way().at("test").at("user"), "bob");
  EXPECT_EQ(way().at("test").at("trouble"), "554 no");
  EXPECT_EQ(way().at("sent_utc_s"), taken.at("sent_utc_s")) << "nothing was taken since";
}

TEST(AlarmSender, StopBreaksOffATestThatIsBeingSent) {
  ScriptedStation lab;
  Tried tried;
  std::vector<std::unique_ptr<Delivery>> deliveries;
  deliveries.push_back(delivery(tried, [](const auto&, const std::atomic<bool>& stop) {
    while (!stop) std::this_thread::yield();
    return refused();
  }));
  AlarmSender sender(lab, std::move(deliveries));
  auto answer = std::async(std::launch::async, [&] { return sender.test("eva"); });
  ASSERT_EQ(tried.first(1).size(), 1U);
  sender.stop();
  EXPECT_EQ(answer.get()->at("ways").at(0).at("trouble"), "554 no");
}

}  // namespace
}  // namespace soak::station
