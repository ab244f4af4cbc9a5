// SPDX-License-Identifier: Apache-2.0
#include "calib/deploy/calibration_file.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "base/hash.h"
#include "calib/deploy/detail/sections.h"
#include "calib/runtime/soak_history.h"
#include "calib/runtime/soak_runtime.h"

namespace soak::calib {

// ---- parts of payloads (detail/sections.h) ----

namespace file {

std::string place(Sensor sensor, Quantity quantity) {
  return std::string(name_of(sensor)) + (quantity == Quantity::bias ? " bias" : " scale_ppm");
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

std::vector<double> read_floats(const std::uint8_t* payload, std::size_t count) {
  std::vector<double> values(count);
  for (std::size_t i = 0; i < count; ++i) values[i] = static_cast<double>(soak_f32(payload + 4 * i));
  return values;
}

bool fits_float(double value) { return std::isfinite(static_cast<float>(value)); }

bool fit_float(const std::vector<double>& values) { return std::all_of(values.begin(), values.end(), fits_float); }

void write_text(base::ByteWriter& out, const std::string& text) {
  out.write(std::span(reinterpret_cast<const std::uint8_t*>(text.data()), text.size()));
}

base::Status check_text(const std::string& text, const std::string& what) {
  if (text.size() <= kMaxText) return {};
  return base::bad_input(what + " is longer than " + std::to_string(kMaxText) + " bytes", what);
}

}  // namespace file

namespace {

using file::Quantity;
using file::Section;

constexpr std::array<std::uint8_t, 8> kMagic = {0x89, 'S', 'O', 'A', 'K', 0x0D, 0x0A, 0x1A};
constexpr std::uint16_t kMajorVersion = 1;
constexpr std::uint8_t kSectionVersion = 1;
constexpr std::uint32_t kHeaderSize = 24;
constexpr std::size_t kSectionHeadSize = 8;
constexpr std::size_t kCheckSize = 4;

// ---- writing ----

/// Sections in the making, up to the first that is refused; the error bounds come last.
struct Draft {
  std::vector<Section> sections;
  std::vector<Section> bounds;
  base::Status status;

  void add(base::Result<Section> section) {
    if (!status) return;
    if (section) {
      sections.push_back(*std::move(section));
    } else {
      status = base::forward_error(section);
    }
  }
  void refuse(std::string message, std::string where) {
    if (status) status = base::bad_input(std::move(message), std::move(where));
  }
};

void add_curve(Draft& draft, const SensorCalibration& sensor, Quantity quantity, const Curve& curve) {
  auto checked = file::checked_curve(curve, sensor, quantity);
  if (!checked) return draft.add(base::forward_error(checked));
  draft.add(std::move(checked->curve));
  draft.bounds.push_back(std::move(checked->bound));
  if (auto bound = file::table_bound_section(sensor.sensor, quantity, curve)) draft.bounds.push_back(*std::move(bound));
}

void add_sensor(Draft& draft, const SensorCalibration& sensor) {
  const auto add_uncertainty = [&](Quantity quantity, const UncertaintyTable& table) {
    if (!table.temp_c.empty()) draft.add(file::uncertainty_section(sensor.sensor, quantity, table));
  };
  draft.add(file::sensor_section(sensor));
  if (draft.status) add_curve(draft, sensor, Quantity::bias, sensor.bias);
  add_uncertainty(Quantity::bias, sensor.bias_uncertainty);
  if (sensor.one_way) draft.add(file::one_way_section(sensor.sensor, *sensor.one_way));
  if (!sensor.scale_ppm) return;
  if (draft.status) add_curve(draft, sensor, Quantity::scale_ppm, *sensor.scale_ppm);
  if (sensor.scale_uncertainty) add_uncertainty(Quantity::scale_ppm, *sensor.scale_uncertainty);
}

void add_sensors(Draft& draft, const Calibration& calibration) {
  if (calibration.sensors.empty()) draft.refuse("the calibration has no sensor", "sensors");
  std::array<bool, kSensorCount> seen{};
  unsigned own_thermometers = 0;
  for (const SensorCalibration& sensor : calibration.sensors) {
    if (std::exchange(seen[index_of(sensor.sensor)], true)) {
      draft.refuse("the sensor is duplicated", std::string(name_of(sensor.sensor)));
    }
    add_sensor(draft, sensor);
    if (sensor.own_thermometer) own_thermometers |= 1U << index_of(sensor.sensor);
  }
  if (own_thermometers == 0) return;
  draft.add(Section{SOAK_SECTION_THERMOMETERS, true, {static_cast<std::uint8_t>(own_thermometers), 0, 0, 0}});
}

void add_cross_terms(Draft& draft, const Calibration& calibration) {
  if (calibration.accel_misalignment) draft.add(file::misalignment_section(*calibration.accel_misalignment));
  if (calibration.gyro_misalignment) draft.add(file::gyro_misalignment_section(calibration));
  if (calibration.g_sensitivity) draft.add(file::g_sensitivity_section(*calibration.g_sensitivity));
  auto couplings = file::coupling_section(calibration);
  if (!couplings) return draft.add(base::forward_error(couplings));
  if (*couplings) draft.add(**std::move(couplings));
  if (calibration.terms.size() > SOAK_MAX_TERMS) {
    draft.refuse("the file carries at most " + std::to_string(SOAK_MAX_TERMS) + " accepted terms", "terms");
  }
  for (const AcceptedTerm& term : calibration.terms) draft.add(file::term_section(term));
}

void add_references(Draft& draft, const Calibration& calibration) {
  if (calibration.references.size() > file::kMaxReferences) {
    draft.refuse("the runs were measured with " + std::to_string(calibration.references.size()) +
                     " entries of the register of references, a file carries at most " +
                     std::to_string(file::kMaxReferences) +
                     "; fit fewer campaigns together ('soak fit --campaign NAME')",
                 "references");
  }
  for (const ReferenceUse& use : calibration.references) draft.add(file::reference_section(use));
}

/// The minor version that a type of section came with, or what it says.
std::uint16_t minor_version_of(const Section& section) {
  switch (section.type) {
    case SOAK_SECTION_PROVENANCE:
      return file::says_unreleased(section.payload) ? 8 : 0;
    case SOAK_SECTION_TERM:
      return file::is_memory_to_follow(section.payload) ? std::uint16_t{SOAK_HISTORY_MINOR_VERSION} : std::uint16_t{0};
    case file::kOneWaySection:
      return 6;
    case SOAK_SECTION_UNCERTAINTY:
      return file::says_one_run(section.payload) ? 6 : 0;
    case SOAK_SECTION_GYRO_MISALIGNMENT:
      return 5;
    case SOAK_SECTION_THERMOMETERS:
      return 4;
    case SOAK_SECTION_COUPLINGS:
      return 3;
    case file::kReferenceSection:
      return 2;
    case SOAK_SECTION_TABLE_BOUND:
      return 1;
    default:
      return 0;
  }
}

std::size_t padded(std::size_t size) { return (size + 3) / 4 * 4; }

/// The whole file: header, sections, CRC.
base::Bytes assemble(const std::vector<Section>& sections) {
  std::size_t size = kHeaderSize + kCheckSize;
  std::uint16_t minor_version = 0;  // the least that has all these sections
  for (const Section& section : sections) {
    size += kSectionHeadSize + padded(section.payload.size());
    minor_version = std::max(minor_version, minor_version_of(section));
  }
  base::ByteWriter out;
  out.write(kMagic);
  out.write(kMajorVersion);
  out.write(minor_version);
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

// ---- reading ----

// A few wrong bits in the magic are damage; more, and it is some other file.
constexpr int kDamagedMagicBits = 8;
// Of a file that ends within the magic: one byte alone begins other kinds of file too.
constexpr std::size_t kTellingMagicBytes = 2;

tl::unexpected<base::Error> refuse_check(std::span<const std::uint8_t> bytes) {
  if (bytes.size() < 28) {
    return base::corrupt("the calibration file is truncated to " + std::to_string(bytes.size()) + " bytes", "size");
  }
  const std::uint32_t stated = soak_u32(bytes.data() + 12);
  if (stated != bytes.size()) {
    return base::corrupt("the calibration file has " + std::to_string(bytes.size()) + " bytes and says that it has " +
                             std::to_string(stated) + ": truncated or damaged; copy it again from the station",
                         "size");
  }
  return base::corrupt("the checksum does not match: the calibration file is damaged; copy it again from the station",
                       "CRC-32C");
}

tl::unexpected<base::Error> refuse_magic(std::span<const std::uint8_t> bytes) {
  const auto foreign = [] { return base::bad_input("not a Soak calibration file", "magic"); };
  if (bytes.size() < kMagic.size()) {
    const bool cut = bytes.size() >= kTellingMagicBytes && std::equal(bytes.begin(), bytes.end(), kMagic.begin());
    return cut ? refuse_check(bytes) : foreign();
  }
  if (std::equal(kMagic.begin(), kMagic.begin() + 5, bytes.begin())) {
    return base::corrupt(
        "the file was damaged in transfer, probably because it was sent as text; copy it again as binary", "magic");
  }
  int different = 0;
  for (std::size_t i = 0; i < kMagic.size(); ++i) {
    different += std::popcount(static_cast<unsigned>(bytes[i] ^ kMagic[i]));
  }
  if (different > kDamagedMagicBits) return foreign();
  return base::corrupt("the file is damaged in its first bytes; copy it again from the station", "magic");
}

tl::unexpected<base::Error> refuse(soak_status status, const soak_cal& cal, std::span<const std::uint8_t> bytes) {
  const std::string where = "byte " + std::to_string(cal.error_offset);
  switch (status) {
    case SOAK_E_ARGUMENT:
    case SOAK_E_MAGIC:
      return refuse_magic(bytes);
    case SOAK_E_CHECK:
      return refuse_check(bytes);
    case SOAK_E_VERSION:
      return base::bad_input("the calibration file has format version " + std::to_string(soak_u16(bytes.data() + 8)) +
                                 '.' + std::to_string(soak_u16(bytes.data() + 10)) +
                                 "; this program reads version 1: use a newer one",
                             "version");
    case SOAK_E_UNKNOWN:
      return base::bad_input("the calibration file relies on a section of type " +
                                 std::to_string(soak_u16(bytes.data() + cal.error_offset)) +
                                 " that this program does not know: use a newer one",
                             where);
    default:
      return base::corrupt("the content of the calibration file breaks its format; export it again", where);
  }
}

SensorCalibration& sensor_of(Calibration& calibration, std::uint8_t index) {
  return *std::find_if(calibration.sensors.begin(), calibration.sensors.end(),
                       [&](const SensorCalibration& s) { return index_of(s.sensor) == index; });
}

/// Takes over one section that belongs to a curve; the curve's own comes first.
void take_of_curve(Calibration& calibration, std::uint32_t type, const std::uint8_t* payload) {
  SensorCalibration& sensor = sensor_of(calibration, payload[0]);
  const bool of_bias = payload[1] == 0;
  if (type == SOAK_SECTION_UNCERTAINTY) {
    (of_bias ? sensor.bias_uncertainty : sensor.scale_uncertainty.emplace()) = file::read_uncertainty(payload);
  } else if (type == SOAK_SECTION_TABLE_BOUND) {
    Curve& curve = of_bias ? sensor.bias : *sensor.scale_ppm;
    std::get<TableCurve>(curve).bound = static_cast<double>(soak_f32(payload + 4));
  } else {
    (of_bias ? sensor.bias : sensor.scale_ppm.emplace()) = file::read_curve(type, payload);
  }
}

/// Takes over the temperatures that a sensor was calibrated at one way only. Refuses them before the sensor's own
/// section, and twice.
base::Status take_one_way(Calibration& calibration, std::span<const std::uint8_t> payload) {
  auto one_way = file::read_one_way(payload);
  if (!one_way) return base::forward_error(one_way);
  const auto sensor = std::ranges::find_if(
      calibration.sensors, [&](const SensorCalibration& known) { return index_of(known.sensor) == payload[0]; });
  if (sensor == calibration.sensors.end() || sensor->one_way) {
    return base::corrupt("temperatures visited one way of a sensor that has them already, or that comes later",
                         "one_way");
  }
  sensor->one_way = *std::move(one_way);
  return {};
}

/// Adds one more entry to a list of `most` at most.
template <class T>
base::Status take_entry(std::vector<T>& list, std::size_t most, const char* what, const char* where,
                        base::Result<T> entry) {
  if (list.size() == most) {
    return base::corrupt(
        "the calibration file has more than " + std::to_string(most) + ' ' + what + "; export it again", where);
  }
  if (!entry) return base::forward_error(entry);
  list.push_back(*std::move(entry));
  return {};
}

/// Takes over one section of a file of that minor version, which soak_load() has accepted.
base::Status take_section(Calibration& calibration, std::uint32_t type, std::span<const std::uint8_t> payload,
                          std::uint16_t minor_version) {
  switch (type) {
    case SOAK_SECTION_PROVENANCE:
      file::read_provenance(payload.data(), calibration);
      break;
    case SOAK_SECTION_SENSOR:
      calibration.sensors.push_back(file::read_sensor(payload.data()));
      break;
    case SOAK_SECTION_FIS:
    case SOAK_SECTION_SPLINE:
    case SOAK_SECTION_TABLE:
    case SOAK_SECTION_UNCERTAINTY:
    case SOAK_SECTION_TABLE_BOUND:
      take_of_curve(calibration, type, payload.data());
      break;
    case file::kOneWaySection:
      return take_one_way(calibration, payload);
    case SOAK_SECTION_MISALIGNMENT:
      calibration.accel_misalignment = file::read_matrix(payload.data());
      break;
    case SOAK_SECTION_GYRO_MISALIGNMENT:
      file::read_gyro_misalignment(payload.data(), calibration);
      break;
    case SOAK_SECTION_G_SENSITIVITY:
      calibration.g_sensitivity = file::read_matrix(payload.data());
      break;
    case SOAK_SECTION_COUPLINGS:
      file::read_couplings(payload.data(), calibration);
      break;
    case SOAK_SECTION_TERM:
      return take_entry(calibration.terms, SOAK_MAX_TERMS, "accepted terms", "terms",
                        file::read_term(payload, minor_version));
    case file::kReferenceSection:
      return take_entry(calibration.references, file::kMaxReferences, "references", "references",
                        file::read_reference(payload));
    default:
      break;
  }
  return {};
}

}  // namespace

base::Result<base::Bytes> encode(const Calibration& calibration) {
  Draft draft;
  draft.add(file::provenance_section(calibration));
  add_references(draft, calibration);
  add_sensors(draft, calibration);
  add_cross_terms(draft, calibration);
  if (!draft.status) return base::forward_error(draft.status);
  draft.sections.insert(draft.sections.end(), draft.bounds.begin(), draft.bounds.end());
  base::Bytes bytes = assemble(draft.sections);
  if (bytes.size() > SOAK_MAX_FILE) {
    return base::bad_input("the file would have " + std::to_string(bytes.size()) + " bytes; the format allows " +
                           std::to_string(SOAK_MAX_FILE));
  }
  // The runtime must accept what is about to leave the lab.
  soak_cal loaded;
  if (soak_load(&loaded, bytes.data(), bytes.size()) == SOAK_OK) return bytes;
  return base::fail(base::ErrorKind::internal, "the runtime refuses the file that was just written",
                    "byte " + std::to_string(loaded.error_offset));
}

base::Result<Calibration> decode(std::span<const std::uint8_t> bytes) {
  soak_cal cal;
  const soak_status status = soak_load(&cal, bytes.data(), bytes.size());
  if (status != SOAK_OK) return refuse(status, cal, bytes);
  Calibration calibration;
  const auto minor_version = static_cast<std::uint16_t>(soak_u16(bytes.data() + 10));
  for (std::size_t at = cal.sections[0]; at < cal.sections[1];) {
    const std::uint8_t* head = bytes.data() + at;
    const std::size_t length = soak_u32(head + 4);
    const bool known_version = head[2] == 1;
    if (known_version) {
      auto taken = take_section(calibration, soak_u16(head), bytes.subspan(at + 8, length), minor_version);
      if (!taken) return base::forward_error(taken);
    }
    at += 8 + length;
  }
  for (SensorCalibration& sensor : calibration.sensors) {
    sensor.own_thermometer = soak_has_own_thermometer(&cal, static_cast<int>(index_of(sensor.sensor))) != 0;
  }
  return calibration;
}

}  // namespace soak::calib
