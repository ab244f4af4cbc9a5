// SPDX-License-Identifier: Apache-2.0
// Units of the other families, read by decoders that were written from the makers' manuals for these tests.
#include "hal/sim/electronics/unit_electronics.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tests/sim/support.h"

namespace soak::hal::sim {
namespace {

using base::Bytes;

class OtherUnit : public testing::Test {
 protected:
  explicit OtherUnit(UnitKind kind) : device_(make_unit(kind, config_, 2)) {}

  /// Lets time pass; what the unit sent in it.
  Bytes wait(double duration_s) {
    const Tick end = now_ + ticks_of(duration_s);
    while (now_ < end) {
      ++now_;
      device_->advance_to(now_, attitude_);
    }
    return device_->take_output();
  }

  Bytes say(std::string_view text) {
    device_->receive({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}, now_);
    return device_->take_output();
  }

  void boot() {
    device_->switch_power(true, now_);
    wait(config_.lab.electronics.boot_s + 0.01);
  }

  CampaignConfig config_ = test::shipped_config();
  std::unique_ptr<UnitElectronics> device_;
  Attitude attitude_{{0.0, 0.0, 1.0}, {}};
  Tick now_ = 1001;
};

std::string text_of(const Bytes& bytes) { return {bytes.begin(), bytes.end()}; }

// --- AHRS400

class SimulatedAhrs400 : public OtherUnit {
 protected:
  SimulatedAhrs400() : OtherUnit(UnitKind::ahrs400) {}
};

int word(const Bytes& bytes, std::size_t at) { return static_cast<std::int16_t>(bytes[at] * 256 + bytes[at + 1]); }

TEST_F(SimulatedAhrs400, IsSilentWithoutPowerAndIdleWithIt) {
  EXPECT_EQ(say("R"), Bytes{});
  boot();
  EXPECT_EQ(wait(5.0), Bytes{});
  EXPECT_EQ(text_of(say("R")), "H");
  EXPECT_EQ(text_of(say("c")), "C");
}

TEST_F(SimulatedAhrs400, TellsItsSerialNumberWithHeaderAndSum) {
  boot();
  // 0380A002 of unit 2.
  EXPECT_EQ(say("S"), (Bytes{0xFF, 0x03, 0x80, 0xA0, 0x02, 0x25}));
  EXPECT_NE(text_of(say("v")).find("SIMULATED"), std::string::npos);
}

TEST_F(SimulatedAhrs400, SendsNothingInAModeThatItDoesNotMeasureIn) {
  boot();
  say("C");
  EXPECT_EQ(wait(1.0), Bytes{});
}

TEST_F(SimulatedAhrs400, SendsOnePacketWhenAskedForOne) {
  boot();
  say("c");
  say("G");
  EXPECT_EQ(wait(1.0).size(), 24U);
  EXPECT_EQ(wait(1.0), Bytes{});
}

TEST_F(SimulatedAhrs400, StreamsPacketsWhoseNumbersAndTimerHold) {
  boot();
  say("c");
  say("C");
  const Bytes stream = wait(60.0);
  ASSERT_EQ(stream.size() % 24, 0U);
  const std::size_t count = stream.size() / 24;
  EXPECT_NEAR(static_cast<double>(count), 60.0 * 400.0 * 3.0 / 19.0, 2.0);
  std::vector<double> mean(7, 0.0);
  double elapsed_s = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    const Bytes packet(stream.begin() + static_cast<long>(24 * i), stream.begin() + static_cast<long>(24 * i + 24));
    ASSERT_EQ(packet[0], 0xFF);
    unsigned sum = 0;
    for (std::size_t at = 1; at < 23; ++at) sum += packet[at];
    ASSERT_EQ(packet[23], sum % 256);
    for (std::size_t k = 0; k < 3; ++k) {
      mean[k] += word(packet, 1 + 2 * k) * 100.0 * 1.5 / 32768.0 / static_cast<double>(count);
      mean[3 + k] += word(packet, 7 + 2 * k) * 2.0 * 1.5 / 32768.0 / static_cast<double>(count);
    }
    mean[6] += ((packet[19] * 256 + packet[20]) * 5.0 / 4096.0 - 1.375) * 44.44 / static_cast<double>(count);
    if (i == 0) continue;
    const int steps = (stream[24 * i - 3] * 256 + stream[24 * i - 2]) - (packet[21] * 256 + packet[22]);
    elapsed_s += ((steps % 65536 + 65536) % 65536) * 0.79e-6;
  }
  EXPECT_NEAR(elapsed_s, 60.0, 0.05);
  // Unit 2 is mounted as lab.toml says: one axis along gravity, the others level; bias below 2 deg/s and 1 m/s2.
  double force_g = 0.0;
  for (int k = 0; k < 3; ++k) {
    EXPECT_LT(std::abs(mean[static_cast<std::size_t>(k)]), 2.0);
    force_g += mean[static_cast<std::size_t>(3 + k)] * mean[static_cast<std::size_t>(3 + k)];
  }
  EXPECT_NEAR(std::sqrt(force_g), 1.0, 0.1);
  EXPECT_NEAR(mean[6], device_->unit().temp_c(), 0.1);
}

TEST_F(SimulatedAhrs400, ForgetsThatItWasToStreamWithItsPower) {
  boot();
  say("c");
  say("C");
  EXPECT_FALSE(wait(1.0).empty());
  device_->switch_power(false, now_);
  EXPECT_EQ(wait(1.0), Bytes{});
  device_->switch_power(true, now_);
  EXPECT_EQ(wait(10.0), Bytes{});
}

// --- VectorNav

class SimulatedVectorNav : public OtherUnit {
 protected:
  SimulatedVectorNav() : OtherUnit(UnitKind::vectornav) {}
};

unsigned exclusive_or(std::string_view text) {
  unsigned sum = 0;
  for (const char c : text) sum ^= static_cast<unsigned char>(c);
  return sum;
}

/// The CRC of all bytes after the first, the frame's own CRC included, is 0 (the makers' remark).
unsigned crc_over(std::span<const std::uint8_t> bytes) {
  unsigned crc = 0;
  for (const std::uint8_t byte : bytes) {
    crc ^= static_cast<unsigned>(byte) << 8U;
    for (int bit = 0; bit < 8; ++bit) crc = ((crc & 0x8000U) != 0 ? crc << 1U ^ 0x1021U : crc << 1U) & 0xFFFFU;
  }
  return crc;
}

TEST_F(SimulatedVectorNav, SendsLinesWithASumUntilToldNotTo) {
  boot();
  const std::string lines = text_of(wait(10.0));
  EXPECT_NEAR(static_cast<double>(std::count(lines.begin(), lines.end(), '\n')), 400.0, 1.0);
  const std::string line = lines.substr(0, lines.find('\r'));
  const auto star = line.find('*');
  ASSERT_NE(star, std::string::npos);
  EXPECT_EQ(std::stoul(line.substr(star + 1), nullptr, 16), exclusive_or(std::string_view(line).substr(1, star - 1)));
  EXPECT_EQ(text_of(say("$VNWRG,06,0*XX\r\n")).substr(0, 11), "$VNWRG,06,0");
  EXPECT_EQ(wait(1.0), Bytes{});
}

TEST_F(SimulatedVectorNav, RefusesWhatItDoesNotKnowByTheMakersNumbers) {
  boot();
  EXPECT_EQ(text_of(say("$VNRRG,01*00\r\n")).substr(0, 9), "$VNERR,03");
  EXPECT_EQ(text_of(say("$VNABC*XX\r\n")).substr(0, 9), "$VNERR,04");
  EXPECT_EQ(text_of(say("$VNWRG,75,1,8*XX\r\n")).substr(0, 9), "$VNERR,05");
  EXPECT_EQ(text_of(say("$VNWRG,75,1,8,05,0001,8610*XX\r\n")).substr(0, 9), "$VNERR,07");
  EXPECT_EQ(text_of(say("$VNRRG,99*XX\r\n")).substr(0, 9), "$VNERR,08");
}

TEST_F(SimulatedVectorNav, StreamsTheFieldsThatWereAskedForAtTheRateAskedFor) {
  boot();
  say("$VNWRG,06,0*XX\r\n");
  EXPECT_EQ(text_of(say("$VNRRG,03*XX\r\n")).substr(0, 20), "$VNRRG,03,0058761218");  // 0380A002 in decimals
  EXPECT_EQ(text_of(say("$VNWRG,75,1,8,05,0001,0610*XX\r\n")).substr(0, 9), "$VNWRG,75");
  const Bytes stream = wait(10.0);
  constexpr std::size_t kSize = 1 + 5 + 8 + 4 + 12 + 12 + 2;
  ASSERT_EQ(stream.size(), 500 * kSize);
  std::uint64_t last_ns = 0;
  for (std::size_t i = 0; i < 500; ++i) {
    const std::span<const std::uint8_t> frame = std::span(stream).subspan(i * kSize, kSize);
    ASSERT_EQ(frame[0], 0xFA);
    ASSERT_EQ(crc_over(frame.subspan(1)), 0U);
    std::uint64_t time_ns = 0;
    std::memcpy(&time_ns, frame.data() + 6, sizeof time_ns);
    if (i > 0) {
      ASSERT_EQ(time_ns - last_ns, 20'000'000U);
    }
    last_ns = time_ns;
    std::array<float, 4> values{};
    std::memcpy(values.data(), frame.data() + 14, sizeof values);
    ASSERT_NEAR(values[0], device_->unit().temp_c(), 0.5);
    ASSERT_NEAR(std::hypot(values[1], values[2], values[3]), 9.8, 1.0);
  }
}

TEST_F(SimulatedVectorNav, BeginsAnewWithLinesAndWithoutPacketsAfterARestart) {
  boot();
  say("$VNWRG,06,0*XX\r\n");
  say("$VNWRG,75,1,8,05,0001,0610*XX\r\n");
  device_->switch_power(false, now_);
  EXPECT_EQ(wait(1.0), Bytes{});
  boot();
  EXPECT_EQ(wait(1.0)[0], '$');
}

}  // namespace
}  // namespace soak::hal::sim
