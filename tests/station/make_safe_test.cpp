// SPDX-License-Identifier: Apache-2.0
// What a chamber that answers nonsense is told; tests/lab/test_make_safe.py does the rest over Modbus.
#include "station/lab/make_safe.h"

#include <gtest/gtest.h>

namespace soak::station {
namespace {

using namespace std::chrono_literals;

/// Says by turns that its control is on and that it is off, until it is switched off.
class ContradictingChamber : public hal::Chamber {
 public:
  base::Status connect() override { return {}; }
  base::Result<hal::ChamberReading> read() override {
    hal::ChamberReading reading;
    reading.air_c = 60.0;
    reading.running = !is_off && ++reads_ % 2 == 1;
    return reading;
  }
  base::Status set_temperature(double) override { return {}; }
  base::Status set_ramp_rate(std::optional<double>) override { return {}; }
  base::Status start() override { return {}; }
  base::Status stop() override {
    is_off = true;
    return {};
  }
  std::optional<double> min_set_point_c() const override { return std::nullopt; }
  std::optional<double> max_set_point_c() const override { return std::nullopt; }
  bool can_ramp() const override { return false; }
  std::string description() const override { return "contradicting"; }

  bool is_off = false;

 private:
  int reads_ = 0;
};

TEST(MakeChamberSafe, AChamberWhoseReadingsContradictEachOtherIsSwitchedOff) {
  ContradictingChamber chamber;
  const auto made = make_chamber_safe(chamber, 15.0, {.silence = 50ms, .pause = 1ms});
  ASSERT_TRUE(made) << made.error().message;
  EXPECT_EQ(made->action, SafeAction::switched_off);
  EXPECT_TRUE(chamber.is_off);
}

/// At 60 °C and on. Its first reading looks as if it were at its safe temperature.
class OnceFlippedChamber : public ContradictingChamber {
 public:
  base::Result<hal::ChamberReading> read() override {
    hal::ChamberReading reading;
    reading.air_c = reads_++ == 0 ? 25.0 : 60.0;
    reading.set_point_c = set_point_c;
    reading.running = true;
    return reading;
  }
  base::Status set_temperature(double temp_c) override {
    set_point_c = temp_c;
    return {};
  }

  double set_point_c = 60.0;

 private:
  int reads_ = 0;
};

TEST(MakeChamberSafe, OneReadingOfTheSafeTemperatureIsNotBelieved) {
  OnceFlippedChamber chamber;
  const auto made = make_chamber_safe(chamber, 15.0, {.silence = 50ms, .pause = 1ms});
  ASSERT_TRUE(made) << made.error().message;
  EXPECT_EQ(made->action, SafeAction::driven);
  EXPECT_EQ(chamber.set_point_c, made->target_c);
}

}  // namespace
}  // namespace soak::station
