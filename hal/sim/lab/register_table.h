// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>

namespace soak::hal::sim {

/// Answer to a Modbus request; the values are those of the exception codes.
enum class ModbusAnswer : std::uint8_t { done = 0, illegal_function = 1, illegal_address = 2, illegal_value = 3 };

/// The holding registers of one device. Addresses that hold nothing answer "illegal address", and so do writes to what
/// can only be read; values that the device does not take answer "illegal value".
class RegisterTable {
 public:
  using ReadNumber = std::function<int()>;
  using ReadValue = std::function<double()>;
  /// Whether the device takes a value, and what it then does with it.
  struct NumberWriter {
    std::function<bool(int)> takes;
    std::function<void(int)> store;
  };
  struct ValueWriter {
    std::function<bool(double)> takes;
    std::function<void(double)> store;
  };

  /// A 16-bit number; one that spans two registers has a second one that always reads 0.
  void add_number(int address, int span, ReadNumber read, NumberWriter write = {});
  enum class FirstWord : std::uint8_t { low, high };
  /// A float32 in two registers. Both are written together.
  void add_value(int address, ReadValue read, ValueWriter write = {}, FirstWord first = FirstWord::low);
  /// From here on addresses that hold nothing read as `content`, and writes to them are accepted and change nothing.
  void pretend_everywhere(std::uint16_t content) { elsewhere_ = content; }

  /// Fills `words` with the registers from `address` on.
  [[nodiscard]] ModbusAnswer read(int address, std::span<std::uint16_t> words) const;
  /// Writes all of `words` or, unless the answer is `done`, none.
  [[nodiscard]] ModbusAnswer write(int address, std::span<const std::uint16_t> words);

 private:
  /// Raw content of an entry, low word first.
  struct Entry {
    int span = 1;
    bool writable = false;
    bool whole_only = false;  ///< a write must cover the whole span
    std::function<std::uint32_t()> read;
    std::function<bool(std::uint32_t)> takes;
    std::function<void(std::uint32_t)> store;
  };
  using Entries = std::map<int, Entry>;

  [[nodiscard]] Entries::const_iterator entry_at(int address) const;
  /// Checks (and, with `store`, carries out) a write.
  [[nodiscard]] ModbusAnswer walk_write(int address, std::span<const std::uint16_t> words, bool store) const;

  Entries entries_;
  std::optional<std::uint16_t> elsewhere_;
};

}  // namespace soak::hal::sim
