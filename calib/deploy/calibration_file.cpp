// SPDX-License-Identifier: Apache-2.0
#include "calib/deploy/calibration_file.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "calib/deploy/detail/coupling_section.h"
#include "calib/deploy/detail/curve_section.h"
#include "calib/deploy/detail/float32_check.h"
#include "calib/deploy/detail/record_section.h"
#include "calib/deploy/detail/reference_section.h"
#include "calib/deploy/detail/section.h"
#include "calib/deploy/detail/spline_form.h"
#include "calib/runtime/soak_runtime.h"

namespace soak::calib {
namespace {

using file::Quantity;
using file::Section;

/// Sections in the making; the error bounds come last.
struct Draft {
  std::vector<Section> sections;
  std::vector<Section> bounds;

  base::Status add(base::Result<Section> section) {
    if (!section) return base::forward_error(section);
    sections.push_back(*std::move(section));
    return {};
  }
};

base::Status add_curve(Draft& draft, const SensorCalibration& sensor, Quantity quantity, const Curve& curve) {
  if (auto status = file::check_curve(curve, file::place(sensor.sensor, quantity)); !status) return status;
  const auto samples = file::sample(curve, sensor, quantity);
  if (!samples) return base::forward_error(samples);
  auto checked = file::checked_curve(curve, *samples, sensor.sensor, quantity);
  if (!checked && std::holds_alternative<anfis::Model>(curve)) {
    const auto [low_c, high_c] = domain_of(curve);
    const auto spline = file::spline_form(curve, std::max(low_c, sensor.temp_min_c),
                                          std::min(high_c, sensor.temp_max_c), samples->span());
    auto other = spline ? file::checked_curve(*spline, *samples, sensor.sensor, quantity) : checked;
    if (other) checked = std::move(other);
  }
  if (!checked) return base::forward_error(checked);
  draft.sections.push_back(std::move(checked->curve));
  draft.bounds.push_back(std::move(checked->bound));
  if (auto bound = file::table_bound_section(sensor.sensor, quantity, curve)) draft.bounds.push_back(*std::move(bound));
  return {};
}

base::Status add_uncertainty(Draft& draft, Sensor sensor, Quantity quantity, const UncertaintyTable& table) {
  if (table.temp_c.empty()) return {};
  return draft.add(file::uncertainty_section(sensor, quantity, table));
}

base::Status add_sensor(Draft& draft, const SensorCalibration& sensor) {
  if (auto status = draft.add(file::sensor_section(sensor)); !status) return status;
  if (auto status = add_curve(draft, sensor, Quantity::bias, sensor.bias); !status) return status;
  if (auto status = add_uncertainty(draft, sensor.sensor, Quantity::bias, sensor.bias_uncertainty); !status) {
    return status;
  }
  if (!sensor.scale_ppm) return {};
  if (auto status = add_curve(draft, sensor, Quantity::scale_ppm, *sensor.scale_ppm); !status) return status;
  if (!sensor.scale_uncertainty) return {};
  return add_uncertainty(draft, sensor.sensor, Quantity::scale_ppm, *sensor.scale_uncertainty);
}

base::Status add_sensors(Draft& draft, const Calibration& calibration) {
  if (calibration.sensors.empty()) return base::bad_input("the calibration has no sensor", "sensors");
  std::array<bool, kSensorCount> seen{};
  for (const SensorCalibration& sensor : calibration.sensors) {
    if (std::exchange(seen[index_of(sensor.sensor)], true)) {
      return base::bad_input("the sensor occurs twice", std::string(name_of(sensor.sensor)));
    }
    if (auto status = add_sensor(draft, sensor); !status) return status;
  }
  return {};
}

base::Status add_cross_terms(Draft& draft, const Calibration& calibration) {
  if (calibration.accel_misalignment) {
    if (auto status = draft.add(file::misalignment_section(*calibration.accel_misalignment)); !status) return status;
  }
  if (calibration.g_sensitivity) {
    if (auto status = draft.add(file::g_sensitivity_section(*calibration.g_sensitivity)); !status) return status;
  }
  auto couplings = file::coupling_section(calibration);
  if (!couplings) return base::forward_error(couplings);
  if (*couplings) draft.sections.push_back(**std::move(couplings));
  if (calibration.terms.size() > SOAK_MAX_TERMS) {
    return base::bad_input("the file carries at most " + std::to_string(SOAK_MAX_TERMS) + " accepted terms", "terms");
  }
  for (const AcceptedTerm& term : calibration.terms) {
    if (auto status = draft.add(file::term_section(term)); !status) return status;
  }
  return {};
}

void add_thermometers(Draft& draft, const Calibration& calibration) {
  unsigned own = 0;
  for (const SensorCalibration& sensor : calibration.sensors) {
    if (sensor.own_thermometer) own |= 1U << index_of(sensor.sensor);
  }
  if (own == 0) return;
  draft.sections.push_back({SOAK_SECTION_THERMOMETERS, true, {static_cast<std::uint8_t>(own), 0, 0, 0}});
}

base::Status add_references(Draft& draft, const Calibration& calibration) {
  if (calibration.references.size() > file::kMaxReferences) {
    return base::bad_input("the runs were measured with " + std::to_string(calibration.references.size()) +
                               " entries of the register of references, a file carries at most " +
                               std::to_string(file::kMaxReferences) +
                               "; fit fewer campaigns together ('soak fit --campaign NAME')",
                           "references");
  }
  for (const ReferenceUse& use : calibration.references) {
    if (auto status = draft.add(file::reference_section(use)); !status) return status;
  }
  return {};
}

base::Status check_size(const base::Bytes& bytes) {
  if (bytes.size() <= SOAK_MAX_FILE) return {};
  return base::bad_input("the file would have " + std::to_string(bytes.size()) + " bytes; the format allows " +
                         std::to_string(SOAK_MAX_FILE));
}

/// The runtime must accept what is about to leave the lab.
base::Status check_loads(const base::Bytes& bytes) {
  soak_cal loaded;
  if (soak_load(&loaded, bytes.data(), bytes.size()) == SOAK_OK) return {};
  return base::fail(base::ErrorKind::internal, "the runtime refuses the file that was just written",
                    "byte " + std::to_string(loaded.error_offset));
}

// ---- reading ----

constexpr std::array<std::uint8_t, 8> kMagic = {0x89, 'S', 'O', 'A', 'K', 0x0D, 0x0A, 0x1A};
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
  return base::corrupt("the check sum does not fit: the calibration file is damaged; copy it again from the station",
                       "CRC-32C");
}

tl::unexpected<base::Error> refuse_magic(std::span<const std::uint8_t> bytes) {
  const auto foreign = [] { return base::bad_input("not a Soak calibration file", "magic"); };
  if (bytes.size() < kMagic.size()) {
    const bool cut = bytes.size() >= kTellingMagicBytes && std::equal(bytes.begin(), bytes.end(), kMagic.begin());
    return cut ? refuse_check(bytes) : foreign();
  }
  if (std::equal(kMagic.begin(), kMagic.begin() + 5, bytes.begin())) {
    return base::corrupt("the file was damaged on its way, probably by a transfer as text; copy it again as binary",
                         "magic");
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

void take_curve(Calibration& calibration, std::uint32_t type, const std::uint8_t* payload) {
  SensorCalibration& sensor = sensor_of(calibration, payload[0]);
  if (payload[1] == 0) {
    sensor.bias = file::read_curve(type, payload);
  } else {
    sensor.scale_ppm = file::read_curve(type, payload);
  }
}

void take_table_bound(Calibration& calibration, const std::uint8_t* payload) {
  SensorCalibration& sensor = sensor_of(calibration, payload[0]);
  Curve& curve = payload[1] == 0 ? sensor.bias : *sensor.scale_ppm;
  std::get<TableCurve>(curve).bound = static_cast<double>(soak_f32(payload + 4));
}

void take_uncertainty(Calibration& calibration, const std::uint8_t* payload) {
  SensorCalibration& sensor = sensor_of(calibration, payload[0]);
  if (payload[1] == 0) {
    sensor.bias_uncertainty = file::read_uncertainty(payload);
  } else {
    sensor.scale_uncertainty = file::read_uncertainty(payload);
  }
}

base::Status take_reference(Calibration& calibration, std::span<const std::uint8_t> payload) {
  if (calibration.references.size() == file::kMaxReferences) {
    return base::corrupt(
        "the calibration file has more than " + std::to_string(file::kMaxReferences) + " references; export it again",
        "references");
  }
  auto use = file::read_reference(payload);
  if (!use) return base::forward_error(use);
  calibration.references.push_back(*std::move(use));
  return {};
}

base::Status take_term(Calibration& calibration, std::span<const std::uint8_t> payload) {
  if (calibration.terms.size() == SOAK_MAX_TERMS) {
    return base::corrupt(
        "the calibration file has more than " + std::to_string(SOAK_MAX_TERMS) + " accepted terms; export it again",
        "terms");
  }
  auto term = file::read_term(payload);
  if (!term) return base::forward_error(term);
  calibration.terms.push_back(*std::move(term));
  return {};
}

/// Takes over one section of a file that soak_load() has accepted.
base::Status take_section(Calibration& calibration, std::uint32_t type, std::span<const std::uint8_t> payload) {
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
      take_curve(calibration, type, payload.data());
      break;
    case SOAK_SECTION_UNCERTAINTY:
      take_uncertainty(calibration, payload.data());
      break;
    case SOAK_SECTION_TABLE_BOUND:
      take_table_bound(calibration, payload.data());
      break;
    case SOAK_SECTION_MISALIGNMENT:
      calibration.accel_misalignment = file::read_matrix(payload.data());
      break;
    case SOAK_SECTION_G_SENSITIVITY:
      calibration.g_sensitivity = file::read_matrix(payload.data());
      break;
    case SOAK_SECTION_COUPLINGS:
      file::read_couplings(payload.data(), calibration);
      break;
    case SOAK_SECTION_TERM:
      return take_term(calibration, payload);
    case file::kReferenceSection:
      return take_reference(calibration, payload);
    default:
      break;
  }
  return {};
}

}  // namespace

base::Result<base::Bytes> encode(const Calibration& calibration) {
  Draft draft;
  if (auto status = draft.add(file::provenance_section(calibration)); !status) return base::forward_error(status);
  if (auto status = add_references(draft, calibration); !status) return base::forward_error(status);
  if (auto status = add_sensors(draft, calibration); !status) return base::forward_error(status);
  add_thermometers(draft, calibration);
  if (auto status = add_cross_terms(draft, calibration); !status) return base::forward_error(status);
  draft.sections.insert(draft.sections.end(), draft.bounds.begin(), draft.bounds.end());
  base::Bytes bytes = file::assemble(draft.sections);
  if (auto status = check_size(bytes); !status) return base::forward_error(status);
  if (auto status = check_loads(bytes); !status) return base::forward_error(status);
  return bytes;
}

base::Result<Calibration> decode(std::span<const std::uint8_t> bytes) {
  soak_cal cal;
  const soak_status status = soak_load(&cal, bytes.data(), bytes.size());
  if (status != SOAK_OK) return refuse(status, cal, bytes);
  Calibration calibration;
  for (std::size_t at = cal.sections[0]; at < cal.sections[1];) {
    const std::uint8_t* head = bytes.data() + at;
    const std::size_t length = soak_u32(head + 4);
    const bool known_version = head[2] == 1;
    if (known_version) {
      auto taken = take_section(calibration, soak_u16(head), bytes.subspan(at + 8, length));
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
