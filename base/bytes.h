// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

namespace soak::base {

using Bytes = std::vector<std::uint8_t>;

/// Any number with a fixed binary form.
template <class T>
concept BinaryNumber = std::integral<T> || std::floating_point<T>;

/// Reads little-endian numbers from a byte sequence that it does not own. Every read is checked: past the end it
/// returns nothing and leaves the position where it was.
class ByteReader {
 public:
  explicit ByteReader(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

  [[nodiscard]] std::size_t position() const { return position_; }
  [[nodiscard]] std::size_t remaining() const { return bytes_.size() - position_; }

  template <BinaryNumber T>
  [[nodiscard]] std::optional<T> read() {
    if (remaining() < sizeof(T)) return std::nullopt;
    T value;
    std::memcpy(&value, bytes_.data() + position_, sizeof(T));
    position_ += sizeof(T);
    return value;
  }

  /// The next `count` bytes, still owned by the underlying sequence.
  [[nodiscard]] std::optional<std::span<const std::uint8_t>> take(std::size_t count) {
    if (remaining() < count) return std::nullopt;
    const auto part = bytes_.subspan(position_, count);
    position_ += count;
    return part;
  }

 private:
  static_assert(std::endian::native == std::endian::little, "byte order of the host is that of the formats");
  std::span<const std::uint8_t> bytes_;
  std::size_t position_ = 0;
};

/// Appends little-endian numbers to a growing byte sequence.
class ByteWriter {
 public:
  template <BinaryNumber T>
  void write(T value) {
    const auto* first = reinterpret_cast<const std::uint8_t*>(&value);
    bytes_.insert(bytes_.end(), first, first + sizeof(T));
  }

  void write(std::span<const std::uint8_t> bytes) { bytes_.insert(bytes_.end(), bytes.begin(), bytes.end()); }

  /// Text of at most 65,535 bytes after its 16-bit length; longer text is cut.
  void write_text16(std::string_view text) {
    text = text.substr(0, 0xFFFF);
    write(static_cast<std::uint16_t>(text.size()));
    bytes_.insert(bytes_.end(), text.begin(), text.end());
  }

  [[nodiscard]] std::size_t size() const { return bytes_.size(); }
  [[nodiscard]] const Bytes& bytes() const { return bytes_; }
  [[nodiscard]] Bytes take() { return std::move(bytes_); }

 private:
  Bytes bytes_;
};

/// The big-endian 16-bit number at `at`, which must lie within `bytes` with the byte after it.
[[nodiscard]] inline std::uint16_t big_endian_u16(std::span<const std::uint8_t> bytes, std::size_t at) {
  return static_cast<std::uint16_t>(bytes[at] << 8 | bytes[at + 1]);
}

/// Appends an unsigned number, its highest byte first.
template <std::unsigned_integral T>
void append_big_endian(Bytes& bytes, T value) {
  for (int shift = 8 * (static_cast<int>(sizeof(T)) - 1); shift >= 0; shift -= 8) {
    bytes.push_back(static_cast<std::uint8_t>(value >> shift));
  }
}

}  // namespace soak::base
