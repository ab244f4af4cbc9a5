// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <functional>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "base/result.h"
#include "modbus_peer.h"

/// Peers that speak lines of text, as processes.
namespace soak::hal::test {

/// A script of tests/hal that prints "PORT n", then answers orders on its standard input, a line for a line.
class TextPeer {
 public:
  explicit TextPeer(const std::string& script, int port = 0) : TextPeer(script, port, {}) {}
  /// `argument`: a second one, after a port of the script's choice.
  TextPeer(const std::string& script, const std::string& argument) : TextPeer(script, 0, {argument}) {}
  TextPeer(const std::string& script, int port, const std::vector<std::string>& more)
      : process_(command(script, port, more)) {
    const std::string greeting = process_.line().value_or("");
    if (!greeting.starts_with("PORT ")) throw std::runtime_error(script + " did not start");
    port_ = std::stoi(greeting.substr(5));
  }
  static std::vector<std::string> command(const std::string& script, int port, const std::vector<std::string>& more) {
    std::vector<std::string> words = {"/usr/bin/python3", "-B", SOAK_TEST_FOLDER "/hal/" + script,
                                      std::to_string(port)};
    words.insert(words.end(), more.begin(), more.end());
    return words;
  }
  [[nodiscard]] int port() const { return port_; }
  std::string tell(const std::string& order) {
    process_.tell(order);
    return process_.line().value_or("");
  }

 private:
  Process process_;
  int port_ = 0;
};

/// Reads until three readings in a row came, for 30 s at most. Each on the way must be right: `check` fails otherwise.
template <class Reading>
void expect_recovery(const std::function<base::Result<Reading>()>& read,
                     const std::function<void(const Reading&)>& check) {
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(30);
  for (int good = 0; good < 3;) {
    ASSERT_LT(std::chrono::steady_clock::now(), deadline) << "the link did not come back";
    const auto reading = read();
    good = reading ? good + 1 : 0;
    if (!reading) {
      ASSERT_EQ(reading.error().kind, base::ErrorKind::device);
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
      continue;
    }
    check(*reading);
    if (testing::Test::HasFatalFailure()) return;
  }
}

inline std::string text_of(const base::Status& status) { return status ? "" : status.error().message; }

}  // namespace soak::hal::test
