// SPDX-License-Identifier: Apache-2.0
// Frames that were written down from the makers' documents, with check sums of other people's programs: what the driver
// sends must be the request to the byte, and the answer must decode to the value beside it. The peer is a
// pseudo-terminal that knows these frames and no Modbus.
#include <fcntl.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <pty.h>
#include <termios.h>
#include <unistd.h>

#include <cstdint>
#include <sstream>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "hal/links/detail/modbus_link.h"
#include "hal/maps/detail/registers.h"

namespace soak::hal {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes bytes_of(const std::string& hex) {
  Bytes bytes;
  std::istringstream words(hex);
  for (std::string word; words >> word;) bytes.push_back(static_cast<std::uint8_t>(std::stoi(word, nullptr, 16)));
  return bytes;
}

std::string hex_of(const Bytes& bytes) {
  std::string text;
  for (const std::uint8_t byte : bytes) text += fmt::format("{}{:02X}", text.empty() ? "" : " ", byte);
  return text;
}

/// A line whose other end answers one request by one reply, and keeps the request.
class ScriptedLine {
 public:
  explicit ScriptedLine(const std::string& reply) : reply_(bytes_of(reply)) {
    char name[128] = {};
    termios raw{};
    ::cfmakeraw(&raw);
    if (::openpty(&master_, &slave_, name, &raw, nullptr) != 0) throw std::runtime_error("no pseudo-terminal");
    path_ = name;
    thread_ = std::thread([this] { serve(); });
  }
  ScriptedLine(const ScriptedLine&) = delete;
  ScriptedLine& operator=(const ScriptedLine&) = delete;
  ~ScriptedLine() {
    join();
    ::close(slave_);
    ::close(master_);
  }

  [[nodiscard]] LinkSettings settings(int unit) const {
    LinkSettings settings;
    settings.address = SerialAddress{.device = path_, .baud = 19200};
    settings.unit = unit;
    settings.response_timeout_s = 2.0;
    return settings;
  }
  /// What came from the driver.
  std::string request() {
    join();
    return hex_of(request_);
  }

 private:
  void serve() {
    pollfd waiting{master_, POLLIN, 0};
    // The last byte has come when none follows for a while.
    while (::poll(&waiting, 1, request_.empty() ? 10'000 : 100) == 1) {
      std::uint8_t byte = 0;
      if (::read(master_, &byte, 1) != 1) return;
      request_.push_back(byte);
    }
    if (::write(master_, reply_.data(), reply_.size()) < 0) request_.clear();
  }
  void join() {
    if (thread_.joinable()) thread_.join();
  }

  Bytes reply_;
  Bytes request_;
  std::string path_;
  int master_ = -1;
  int slave_ = -1;
  std::thread thread_;
};

struct ReadFrame {
  const char* what;
  int unit;
  RegisterPlace place;
  int count;
  const char* request;
  const char* reply;
  double value;  ///< of the first words
};

class ReadFrames : public ::testing::TestWithParam<ReadFrame> {};

TEST_P(ReadFrames, AreSentAndReadToTheByte) {
  const ReadFrame& frame = GetParam();
  ScriptedLine line(frame.reply);
  ModbusLink link(line.settings(frame.unit));
  ASSERT_TRUE(link.open());
  Words words(static_cast<std::size_t>(frame.count));
  const LinkResult done = link.read(3, frame.place.address, words);
  EXPECT_EQ(line.request(), frame.request);
  ASSERT_TRUE(done) << done.error().text;
  EXPECT_EQ(decode_value(frame.place, words, frame.place.decimals_register ? 1 : 0), frame.value);
}

RegisterPlace place_at(int address, RegisterType type, WordOrder order = WordOrder::low_first) {
  RegisterPlace place;
  place.address = address;
  place.type = type;
  place.word_order = order;
  return place;
}

RegisterPlace tenths_at(int address) {
  RegisterPlace place = place_at(address, RegisterType::i16);
  place.decimals_register = 606;
  return place;
}

// Watlow F4T and F4: ESPEC's and TestEquity's tables, check sums by mbpoll. Eurotherm: handbook HA026230 (unit 2), and
// its float area.
INSTANTIATE_TEST_SUITE_P(Documented, ReadFrames,
                         ::testing::Values(ReadFrame{"f4t_process_value", 1, place_at(2820, RegisterType::f32), 2,
                                                     "01 03 0B 04 00 02 87 EE", "01 03 04 00 00 41 BA 4B D0", 23.25},
                                           ReadFrame{"f4_input_1", 1, tenths_at(100), 1, "01 03 00 64 00 01 C5 D5",
                                                     "01 03 02 FE 6B B9 CB", -40.5},
                                           ReadFrame{"eurotherm_integers", 2, tenths_at(1), 2,
                                                     "02 03 00 01 00 02 95 F8", "02 03 04 00 B2 00 D8 69 4E", 17.8},
                                           ReadFrame{"eurotherm_float", 1,
                                                     place_at(32770, RegisterType::f32, WordOrder::high_first), 2,
                                                     "01 03 80 02 00 02 4C 0B", "01 03 04 41 BA 00 00 CF EA", 23.25}),
                         [](const auto& info) { return std::string(info.param.what); });

struct WriteFrame {
  const char* what;
  int function;
  RegisterPlace place;
  int decimals;
  double value;
  const char* request;
  const char* reply;  ///< the echo that the standard asks for
};

class WriteFrames : public ::testing::TestWithParam<WriteFrame> {};

TEST_P(WriteFrames, AreSentToTheByte) {
  const WriteFrame& frame = GetParam();
  ScriptedLine line(frame.reply);
  ModbusLink link(line.settings(1));
  ASSERT_TRUE(link.open());
  const auto words = encode_value(frame.place, frame.value, frame.decimals);
  ASSERT_TRUE(words);
  const LinkResult done = link.write(frame.function, frame.place.address, *words);
  EXPECT_EQ(line.request(), frame.request);
  EXPECT_TRUE(done) << done.error().text;
}

// The echoes' check sums are those of pymodbus.
INSTANTIATE_TEST_SUITE_P(
    Documented, WriteFrames,
    ::testing::Values(WriteFrame{"f4t_set_point", 16, place_at(2782, RegisterType::f32), 0, -40.0,
                                 "01 10 0A DE 00 02 04 00 00 C2 20 51 67", "01 10 0A DE 00 02 22 2A"},
                      WriteFrame{"f4_set_point", 6, tenths_at(300), 1, -40.0, "01 06 01 2C FE 70 08 7B",
                                 "01 06 01 2C FE 70 08 7B"},
                      WriteFrame{"eurotherm_set_point", 16, place_at(32772, RegisterType::f32, WordOrder::high_first),
                                 0, -40.0, "01 10 80 04 00 02 04 C2 20 00 00 AF E8", "01 10 80 04 00 02 29 C9"}),
    [](const auto& info) { return std::string(info.param.what); });

TEST(ExceptionFrames, SayWhatTheControllerRefuses) {
  // Watlow: writing an inactive parameter gives exception 2, a value out of range exception 3.
  for (const auto& [reply, exception] : {std::pair{"01 86 02 C3 A1", 2}, std::pair{"01 86 03 02 61", 3}}) {
    ScriptedLine line(reply);
    ModbusLink link(line.settings(1));
    ASSERT_TRUE(link.open());
    const std::uint16_t word = 1;
    const LinkResult done = link.write(6, 300, {&word, 1});
    ASSERT_FALSE(done);
    EXPECT_EQ(done.error().exception, exception) << done.error().text;
    EXPECT_TRUE(link.is_open()) << "the line is sound";
  }
}

}  // namespace
}  // namespace soak::hal
