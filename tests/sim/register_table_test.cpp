// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/lab/register_table.h"

#include <gtest/gtest.h>

#include <array>
#include <limits>
#include <vector>

#include "tests/sim/registers.h"

namespace soak::hal::sim {
namespace {

using Words = std::vector<std::uint16_t>;

/// 100, 101: a value from 0 to 100; 102, 103: a number, 1 or 2, that spans two registers; 104: a number to read only.
class RegisterTableOfOneDevice : public testing::Test {
 protected:
  RegisterTableOfOneDevice() {
    table_.add_value(100, [this] { return value_; },
                     {[](double v) { return v >= 0.0 && v <= 100.0; }, [this](double v) { value_ = v; }});
    table_.add_number(102, 2, [this] { return number_; },
                      {[](int v) { return v == 1 || v == 2; }, [this](int v) { number_ = v; }});
    table_.add_number(104, 1, [] { return 77; });
  }

  double value_ = 23.25;
  int number_ = 1;
  RegisterTable table_;
};

// 23.25 is 0x41BA0000 in IEEE 754.
TEST_F(RegisterTableOfOneDevice, GivesTheLowWordOfAValueFirst) {
  Words words(5);
  ASSERT_EQ(table_.read(100, words), ModbusAnswer::done);
  EXPECT_EQ(words, (Words{0x0000, 0x41BA, 1, 0, 77}));
}

// −40.25 is 0xC2210000, which the device does not take; 40.25 is 0x42210000.
TEST_F(RegisterTableOfOneDevice, TakesTheLowWordOfAValueFirst) {
  EXPECT_EQ(table_.write(100, Words{0x0000, 0x4221}), ModbusAnswer::done);
  EXPECT_EQ(value_, 40.25);
  EXPECT_EQ(table_.write(100, Words{0x0000, 0xC221}), ModbusAnswer::illegal_value);
  EXPECT_EQ(value_, 40.25);
}

TEST_F(RegisterTableOfOneDevice, AnswersAnIllegalAddressWhereThereIsNothing) {
  Words one(1);
  EXPECT_EQ(table_.read(99, one), ModbusAnswer::illegal_address);
  EXPECT_EQ(table_.read(105, one), ModbusAnswer::illegal_address);
  Words six(6);
  EXPECT_EQ(table_.read(100, six), ModbusAnswer::illegal_address) << "a hole within the range";
  EXPECT_EQ(table_.write(99, Words{1}), ModbusAnswer::illegal_address);
}

TEST_F(RegisterTableOfOneDevice, CanBeReadFromTheMiddleOfAValue) {
  Words words(2);
  ASSERT_EQ(table_.read(101, words), ModbusAnswer::done);
  EXPECT_EQ(words, (Words{0x41BA, 1}));
}

TEST_F(RegisterTableOfOneDevice, RefusesToWriteWhatIsOnlyRead) {
  EXPECT_EQ(table_.write(104, Words{77}), ModbusAnswer::illegal_address);
}

TEST_F(RegisterTableOfOneDevice, RefusesHalfAValue) {
  EXPECT_EQ(table_.write(100, Words{0x4221}), ModbusAnswer::illegal_value);
  EXPECT_EQ(table_.write(101, Words{0x4221}), ModbusAnswer::illegal_value);
  EXPECT_EQ(value_, 23.25);
}

TEST_F(RegisterTableOfOneDevice, RefusesValuesThatAreNoNumbers) {
  EXPECT_EQ(test::write_value(table_, 100, std::numeric_limits<float>::quiet_NaN()), ModbusAnswer::illegal_value);
  EXPECT_EQ(test::write_value(table_, 100, std::numeric_limits<float>::infinity()), ModbusAnswer::illegal_value);
}

TEST_F(RegisterTableOfOneDevice, TakesANumberInOneRegisterOrInBoth) {
  EXPECT_EQ(table_.write(102, Words{2}), ModbusAnswer::done);
  EXPECT_EQ(number_, 2);
  EXPECT_EQ(table_.write(102, Words{1, 0}), ModbusAnswer::done);
  EXPECT_EQ(number_, 1);
  EXPECT_EQ(table_.write(102, Words{2, 1}), ModbusAnswer::illegal_value) << "0x00010002 is not 2";
  EXPECT_EQ(table_.write(102, Words{3}), ModbusAnswer::illegal_value);
  EXPECT_EQ(number_, 1);
}

TEST_F(RegisterTableOfOneDevice, WritesAllOfARequestOrNone) {
  EXPECT_EQ(table_.write(100, Words{0x0000, 0x4221, 3}), ModbusAnswer::illegal_value);
  EXPECT_EQ(value_, 23.25);
  EXPECT_EQ(table_.write(100, Words{0x0000, 0x4221, 2, 0, 1}), ModbusAnswer::illegal_address);
  EXPECT_EQ(value_, 23.25);
  EXPECT_EQ(table_.write(100, Words{0x0000, 0x4221, 2, 0}), ModbusAnswer::done);
  EXPECT_EQ(value_, 40.25);
  EXPECT_EQ(number_, 2);
}

}  // namespace
}  // namespace soak::hal::sim
