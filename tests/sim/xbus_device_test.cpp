// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/electronics/detail/xbus_device.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "tests/sim/measurements.h"
#include "tests/sim/support.h"

namespace soak::hal::sim {
namespace {

using base::Bytes;

constexpr std::uint8_t kWakeUp = 0x3E;
constexpr std::uint8_t kMtData2 = 0x36;

class PoweredDevice : public testing::Test {
 protected:
  /// Lets time pass; what the unit sent in it.
  Bytes wait(double duration_s) {
    const Tick end = now_ + ticks_of(duration_s);
    while (now_ < end) {
      ++now_;
      device_.advance_to(now_, attitude_);
    }
    return device_.take_output();
  }

  Bytes ask(std::uint8_t id, const Bytes& data = {}) {
    device_.receive(xbus_frame(id, data), now_);
    return device_.take_output();
  }

  void configure() {
    device_.switch_power(true, now_);
    wait(1.2);
    ask(0x3F);
    ASSERT_EQ(wait(10.0), Bytes{});
  }

  CampaignConfig config_ = test::shipped_config();
  XbusDevice device_{config_, 2};
  Attitude attitude_{{0.0, 0.0, 1.0}, {}};
  Tick now_ = 1001;
};

TEST_F(PoweredDevice, IsSilentUntilPowered) {
  EXPECT_EQ(ask(0x30), Bytes{});
  EXPECT_EQ(wait(10.0), Bytes{});
}

TEST_F(PoweredDevice, WakesUpAndThenMeasuresAsItLeftTheFactory) {
  device_.switch_power(true, now_);
  EXPECT_EQ(wait(0.99), Bytes{});
  EXPECT_EQ(wait(0.02), xbus_frame(kWakeUp, {}));
  const std::vector<test::Measurement> measurements = test::measurements_in(wait(10.5));
  ASSERT_NEAR(static_cast<double>(measurements.size()), 1000.0, 2.0);
  const auto temperatures =
      std::count_if(measurements.begin(), measurements.end(), [](const auto& m) { return m.temp_c.has_value(); });
  EXPECT_NEAR(static_cast<double>(temperatures), 100.0, 1.0);
  for (std::size_t i = 0; i < measurements.size(); ++i) {
    EXPECT_EQ(measurements[i].counter, static_cast<int>(i));
    EXPECT_TRUE(measurements[i].accel_mps2 && measurements[i].gyro_rps);
    if (i > 0) {
      EXPECT_EQ(measurements[i].time_100us - measurements[i - 1].time_100us, 100);
    }
  }
}

TEST_F(PoweredDevice, StaysUnconfiguredWhenItsWakeUpIsAnswered) {
  configure();
  EXPECT_EQ(ask(0x10), xbus_frame(0x11, {}));
  EXPECT_FALSE(test::measurements_in(wait(1.0)).empty());
}

TEST_F(PoweredDevice, TellsWhoItIs) {
  configure();
  EXPECT_EQ(ask(0x00), xbus_frame(0x01, Bytes{0x03, 0x80, 0xA0, 0x02}));
  const auto product = test::messages_in(ask(0x1C));
  ASSERT_EQ(product.size(), 1U);
  EXPECT_EQ(product[0].id, 0x1D);
  ASSERT_EQ(product[0].data.size(), 20U);
  EXPECT_NE(std::string(product[0].data.begin(), product[0].data.end()).find("SIMULATED"), std::string::npos);
  EXPECT_EQ(ask(0x12).at(2), 0x13);
}

TEST_F(PoweredDevice, PutsOutWhatIsConfiguredAlsoAfterPowerWasOff) {
  configure();
  const Bytes plan = {0x10, 0x20, 0xFF, 0xFF, 0x80, 0x20, 0x00, 50, 0xE0, 0x20, 0xFF, 0xFF};
  EXPECT_EQ(ask(0xC0, plan), xbus_frame(0xC1, plan));
  device_.switch_power(false, now_);
  device_.switch_power(true, now_);
  const std::vector<test::Measurement> measurements = test::measurements_in(wait(2.5));
  ASSERT_NEAR(static_cast<double>(measurements.size()), 50.0, 1.0);
  EXPECT_FALSE(measurements[0].accel_mps2);
  EXPECT_EQ(measurements[0].status, 3U) << "self-test and filter, nothing clipped";
}

TEST_F(PoweredDevice, RefusesWhatItCannotDo) {
  configure();
  EXPECT_EQ(ask(0xC0, {0x20, 0x10, 0x00, 0x64}), xbus_frame(0x42, Bytes{0x21}));
  EXPECT_EQ(ask(0x77), xbus_frame(0x42, Bytes{0x04}));
  ask(0x10);
  EXPECT_EQ(ask(0x00), xbus_frame(0x42, Bytes{0x04})) << "while it measures";
}

TEST_F(PoweredDevice, FallsSilentWithoutPowerAndStartsAnewWithIt) {
  device_.switch_power(true, now_);
  wait(5.0);
  device_.switch_power(false, now_);
  EXPECT_EQ(wait(100.0), Bytes{});
  device_.switch_power(true, now_);
  const Bytes bytes = wait(5.0);
  EXPECT_EQ(test::messages_in(bytes).at(0).id, kWakeUp);
  const std::vector<test::Measurement> measurements = test::measurements_in(bytes);
  EXPECT_EQ(measurements.at(0).counter, 0);
  EXPECT_EQ(measurements.at(0).time_100us, 15100) << "the first 10 ms after 1.5 s since the power came";
}

TEST_F(PoweredDevice, StartsAnewWhenReset) {
  device_.switch_power(true, now_);
  wait(5.0);
  EXPECT_EQ(ask(0x40), xbus_frame(0x41, {}));
  const auto messages = test::messages_in(wait(2.0));
  EXPECT_EQ(messages.at(0).id, kWakeUp);
  EXPECT_EQ(test::measurement_of(messages.at(1)).counter, 0);
}

TEST_F(PoweredDevice, SetsTheBitsOfClippedAxes) {
  configure();
  ask(0xC0, {0x80, 0x20, 0x00, 100, 0xE0, 0x20, 0xFF, 0xFF});
  ask(0x10);
  attitude_.rate_rps = {0.0, 20.0, 0.0};  // 1146 °/s; unit 2 holds its x axis along the fixture's y
  const std::vector<test::Measurement> measurements = test::measurements_in(wait(0.1));
  ASSERT_FALSE(measurements.empty());
  EXPECT_EQ(measurements[0].status, 3U | 1U << 11 | 1U << 19);
  EXPECT_NEAR(measurements[0].gyro_rps->at(0) * 57.29578, 450.0, 0.01);
}

// The mean of 1000 samples is known to 0.375 °/s / √1000 = 0.012 °/s and 0.0167 / √1000 = 0.0005 m/s².
TEST_F(PoweredDevice, ReadsWhatIsTrueOfTheUnitWithTheOffsetsOfEachPowerOn) {
  const SimulatedUnit truth = draw_lab_unit(config_, 2);
  for (int power_on = 0; power_on < 3; ++power_on) {
    device_.switch_power(true, now_);
    wait(2.0);
    const std::vector<test::Measurement> measurements = test::measurements_in(wait(10.0));
    for (const calib::Sensor sensor : calib::kSensors) {
      std::vector<double> values;
      for (const test::Measurement& measurement : measurements) {
        const auto& vector = calib::is_gyro(sensor) ? measurement.gyro_rps : measurement.accel_mps2;
        values.push_back(vector->at(calib::axis_of(sensor)));
      }
      // "+Y-X+Z": the fixture's z is the unit's.
      const double expected = ideal_reading(truth, sensor, device_.unit().temp_c(), {0.0, 0.0, 9.80665}, {}) +
                              power_on_offset(config_, truth, power_on, sensor);
      const double printed = calib::printed_per_si(sensor);
      EXPECT_NEAR(test::mean_of(values) * printed, expected * printed, calib::is_gyro(sensor) ? 0.055 : 0.003)
          << calib::name_of(sensor) << " " << power_on;
    }
    device_.switch_power(false, now_);
  }
}

TEST_F(PoweredDevice, PutsOutWholeStepsOfItsConverter) {
  device_.switch_power(true, now_);
  for (const test::Measurement& measurement : test::measurements_in(wait(3.0))) {
    for (const double gyro_rps : *measurement.gyro_rps) {
      const double counts = gyro_rps * 57.29577951308232 / 0.0137;
      EXPECT_NEAR(counts, std::round(counts), 1e-3);
    }
    const double temperature_counts = 256.0 * measurement.temp_c.value_or(0.0);
    EXPECT_EQ(temperature_counts, std::round(temperature_counts));
  }
}

}  // namespace
}  // namespace soak::hal::sim
