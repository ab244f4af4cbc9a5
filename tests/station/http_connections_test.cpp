// SPDX-License-Identifier: Apache-2.0
// Clients that send slowly, much or often: others are answered, memory and descriptors stay bounded.
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <future>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "station/http/server.h"
#include "tests/station/http_raw.h"
#include "tests/station/http_scripted_station.h"

namespace soak::station {
namespace {

class HttpConnections : public ::testing::Test {
 protected:
  explicit HttpConnections(std::unique_ptr<ScriptedStation> scripted = std::make_unique<ScriptedStation>())
      : station(std::move(scripted)) {}

  void SetUp() override {
    const auto started = server.start();
    ASSERT_TRUE(started) << started.error().message;
    port = *started;
  }

  [[nodiscard]] std::string head(const std::string& first_line) const {
    return first_line + " HTTP/1.1\r\nHost: 127.0.0.1:" + std::to_string(port) + "\r\n";
  }
  [[nodiscard]] std::string abort_request() const {
    const std::string body = R"({"reason": "smoke", "user": "eva"})";
    return head("POST /api/v1/campaign/abort") +
           "Content-Type: application/json\r\nContent-Length: " + std::to_string(body.size()) + "\r\n\r\n" + body;
  }
  [[nodiscard]] std::string abort_campaign() const { return exchange_raw(port, abort_request()); }
  /// Connections of whose request a part was sent.
  std::vector<RawConnection> unfinished(int count) {
    std::vector<RawConnection> connections;
    for (int i = 0; i < count; ++i) {
      connections.emplace_back(port);
      connections.back().send(head("GET /api/v1/status") + "X-Slow: ");
    }
    return connections;
  }

  std::unique_ptr<ScriptedStation> station;
  ScriptedStation& lab = *station;
  HttpServer server{lab, "127.0.0.1:0"};
  int port = 0;
};

std::size_t open_descriptors() {
  const std::filesystem::directory_iterator all("/proc/self/fd");
  return static_cast<std::size_t>(std::distance(begin(all), end(all)));
}

TEST_F(HttpConnections, AnAbortIsAnsweredBesideTwoHundredRequestsThatNeverEnd) {
  auto slow = unfinished(200);
  for (RawConnection& connection : slow) connection.send("a");
  EXPECT_EQ(status_of(abort_campaign()), 200);
  EXPECT_EQ(lab.commands().size(), 1U);
}

// Not each request with the path of the event stream becomes one: its connections would never be cut off for others.
TEST_F(HttpConnections, RequestsThatOnlyNameTheEventStreamMakeRoomForOthers) {
  std::vector<RawConnection> named;
  for (int i = 0; i < 100; ++i) {
    named.emplace_back(port);
    named.back().send(head("POST /api/v1/events") + "Content-Type: application/json\r\nContent-Length: 10\r\n\r\n");
  }
  EXPECT_EQ(status_of(abort_campaign()), 200);
  EXPECT_EQ(named.front().read_all(), "") << "it was answered instead of cut off";
}

TEST_F(HttpConnections, StopDoesNotWaitForRequestsThatNeverEnd) {
  auto slow = unfinished(100);
  EXPECT_EQ(status_of(abort_campaign()), 200);
  server.stop();
  for (RawConnection& connection : slow) connection.read_all();
  EXPECT_FALSE(RawConnection(port).connected());
}

TEST_F(HttpConnections, SixHundredConnectionsTakeAboutTwoHundredDescriptorsOfTheServer) {
  const std::size_t before = open_descriptors();
  const auto slow = unfinished(600);
  EXPECT_EQ(status_of(abort_campaign()), 200);
  EXPECT_LE(open_descriptors(), before + 600 + 160 + 32 + 1);
}

TEST_F(HttpConnections, AHeadAboveSixtyFourKibibytesIsNotReadOn) {
  std::string request = head("GET /api/v1/status");
  for (int i = 0; i < 20000; ++i) request += "X-Header-" + std::to_string(i) + ": " + std::string(100, 'x') + "\r\n";
  EXPECT_NE(status_of(exchange_raw(port, request + "\r\n")), 200);
  EXPECT_EQ(status_of(abort_campaign()), 200);
}

// 809 bytes of Brotli can become 1 GiB.
TEST_F(HttpConnections, ACompressedBodyIsRefusedBeforeItIsRead) {
  for (const char* encoding : {"br", "gzip", "deflate", "identity"}) {
    RawConnection connection(port);
    connection.send(head("POST /api/v1/campaign/pause") +
                    "Content-Type: application/json\r\nContent-Length: 809\r\nContent-Encoding: " + encoding +
                    "\r\n\r\n");
    ASSERT_TRUE(connection.read_until("\r\n\r\n")) << encoding;
    EXPECT_EQ(status_of(connection.text()), 415) << encoding;
  }
  EXPECT_TRUE(lab.commands().empty());
}

TEST_F(HttpConnections, TwoLengthsOfABodyAreRefused) {
  const std::string answer =
      exchange_raw(port, head("POST /api/v1/campaign/pause") +
                             "Content-Type: application/json\r\nContent-Length: 2\r\nContent-Length: 30\r\n\r\n{}");
  EXPECT_EQ(status_of(answer), 400);
  EXPECT_EQ(nlohmann::json::parse(body_of(answer))["error"]["where"], "Content-Length");
  EXPECT_TRUE(lab.commands().empty());
}

TEST_F(HttpConnections, AStrangersBodyIsNotReadBeforeTheRefusal) {
  RawConnection connection(port);
  connection.send(
      "POST /api/v1/campaign/pause HTTP/1.1\r\nHost: evil.example\r\nContent-Type: application/json\r\nContent-Length: "
      "1000000\r\n\r\n");
  ASSERT_TRUE(connection.read_until("\r\n\r\n"));
  EXPECT_EQ(status_of(connection.text()), 403);
}

/// A station that takes its time over an abort.
class SlowStation : public ScriptedStation {
 public:
  base::Status abort(const std::string& user, const std::string& reason) override {
    begun.set_value();
    EXPECT_EQ(go_on.get_future().wait_for(std::chrono::seconds(30)), std::future_status::ready);
    return ScriptedStation::abort(user, reason);
  }

  std::promise<void> begun;
  std::promise<void> go_on;
};

class HttpConnectionsOfASlowStation : public HttpConnections {
 protected:
  HttpConnectionsOfASlowStation() : HttpConnections(std::make_unique<SlowStation>()) {}
  SlowStation& slow_lab() { return static_cast<SlowStation&>(*station); }
};

TEST_F(HttpConnectionsOfASlowStation, ACommandThatIsCarriedOutKeepsItsAnswerBesideTwoHundredThatComeLater) {
  RawConnection command(port);
  command.send(abort_request());
  ASSERT_EQ(slow_lab().begun.get_future().wait_for(std::chrono::seconds(30)), std::future_status::ready);
  auto slow = unfinished(200);
  EXPECT_EQ(status_of(exchange_raw(port, head("GET /api/v1/status") + "\r\n")), 200);
  slow_lab().go_on.set_value();
  EXPECT_EQ(status_of(command.read_all()), 200);
}

}  // namespace
}  // namespace soak::station
