// SPDX-License-Identifier: Apache-2.0
#include "calib/deploy/detail/section.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/hash.h"
#include "calib/runtime/soak_runtime.h"

namespace soak::calib::file {
namespace {

constexpr std::array<std::uint8_t, 8> kMagic = {0x89, 'S', 'O', 'A', 'K', 0x0D, 0x0A, 0x1A};
constexpr std::uint16_t kMajorVersion = 1;
constexpr std::uint8_t kSectionVersion = 1;
constexpr std::uint32_t kHeaderSize = 24;
constexpr std::size_t kSectionHeadSize = 8;
constexpr std::size_t kCheckSize = 4;

std::size_t padded(std::size_t size) { return (size + 3) / 4 * 4; }

/// The minor version that a type of section came with.
std::uint16_t minor_version_of(std::uint16_t type) {
  if (type == SOAK_SECTION_THERMOMETERS) return 4;
  if (type == SOAK_SECTION_COUPLINGS) return 3;
  if (type == kReferenceSection) return 2;
  return type == SOAK_SECTION_TABLE_BOUND ? 1 : 0;
}

/// The least minor version that has all these sections.
std::uint16_t minor_version(const std::vector<Section>& sections) {
  std::uint16_t version = 0;
  for (const Section& section : sections) version = std::max(version, minor_version_of(section.type));
  return version;
}

}  // namespace

std::string place(Sensor sensor, Quantity quantity) {
  return std::string(name_of(sensor)) + ' ' + std::string(name_of(quantity));
}

base::ByteWriter payload_of(Sensor sensor, Quantity quantity) {
  base::ByteWriter out;
  out.write(static_cast<std::uint8_t>(index_of(sensor)));
  out.write(static_cast<std::uint8_t>(quantity));
  return out;
}

void write_floats(base::ByteWriter& out, const std::vector<double>& values) {
  for (const double value : values) out.write(static_cast<float>(value));
}

bool fits_float(double value) { return std::isfinite(static_cast<float>(value)); }

bool fit_float(const std::vector<double>& values) { return std::all_of(values.begin(), values.end(), fits_float); }

std::vector<double> read_floats(const std::uint8_t* payload, std::size_t count) {
  std::vector<double> values(count);
  for (std::size_t i = 0; i < count; ++i) values[i] = static_cast<double>(soak_f32(payload + 4 * i));
  return values;
}

void write_text(base::ByteWriter& out, const std::string& text) {
  out.write(std::span(reinterpret_cast<const std::uint8_t*>(text.data()), text.size()));
}

std::string text_at(const std::uint8_t* first, std::size_t length) { return {first, first + length}; }

base::Status check_text(const std::string& text, const std::string& what) {
  if (text.size() <= kMaxText) return {};
  return base::bad_input(what + " is longer than " + std::to_string(kMaxText) + " bytes", what);
}

base::Bytes assemble(const std::vector<Section>& sections) {
  std::size_t size = kHeaderSize + kCheckSize;
  for (const Section& section : sections) size += kSectionHeadSize + padded(section.payload.size());
  base::ByteWriter out;
  out.write(kMagic);
  out.write(kMajorVersion);
  out.write(minor_version(sections));
  out.write(static_cast<std::uint32_t>(size));
  out.write(kHeaderSize);
  out.write(static_cast<std::uint32_t>(sections.size()));
  for (const Section& section : sections) {
    out.write(section.type);
    out.write(kSectionVersion);
    out.write(static_cast<std::uint8_t>(section.critical ? 1 : 0));
    out.write(static_cast<std::uint32_t>(padded(section.payload.size())));
    out.write(section.payload);
    while (out.size() % 4 != 0) out.write(std::uint8_t{0});
  }
  out.write(base::crc32c(out.bytes()));
  return out.take();
}

}  // namespace soak::calib::file
