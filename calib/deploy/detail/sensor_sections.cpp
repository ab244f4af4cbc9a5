// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "base/hash.h"
#include "base/text.h"
#include "calib/deploy/detail/sections.h"
#include "calib/model/deployed_terms.h"
#include "calib/runtime/soak_history.h"
#include "calib/runtime/soak_runtime.h"

namespace soak::calib::file {
namespace {

constexpr std::uint32_t kHasPi95 = 1;
constexpr std::uint32_t kOneRun = 2;
constexpr std::uint8_t kLabOnly = 1;
constexpr std::uint32_t kGyroReadingsOnly = 2;  ///< of section 0x0025: its uncertainties are those of the readings

/// Of an uncertainty: finite, and not negative.
bool is_half_width(double value) { return value >= 0.0 && fits_float(value); }

// ---- matrices and their uncertainties ----

std::vector<double> entries_of(const Matrix3& matrix) {
  std::vector<double> list;
  for (const Vector3& row : matrix) list.insert(list.end(), row.begin(), row.end());
  return list;
}

base::Result<Section> matrix_section(std::uint16_t type, const Matrix3& matrix, const std::string& where) {
  const auto numbers = entries_of(matrix);
  if (!fit_float(numbers)) return base::bad_input("a number of the matrix is not finite", where);
  base::ByteWriter out;
  write_floats(out, numbers);
  return Section{type, true, out.take()};
}

/// Blocks of section 0x0023 in the making: bit k of the flags for block k, bit 8 + k where it is of the readings only.
struct CouplingBlocks {
  std::uint32_t flags = 0;
  std::vector<double> numbers;

  void add(std::uint32_t block, bool readings_only, const std::vector<double>& values) {
    flags |= 1U << block | (readings_only ? 1U << (8U + block) : 0U);
    numbers.insert(numbers.end(), values.begin(), values.end());
  }
};

base::Status check_misalignment(const Matrix3& misalignment, const std::string& where) {
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      const double number = misalignment[i][j];
      const bool good = i == j ? number == 0.0 : std::abs(number) <= static_cast<double>(SOAK_MAX_MISALIGNMENT);
      if (!good) return base::bad_input("misalignment needs a diagonal of 0 and no number beyond 0.2", where);
    }
  }
  return {};
}

base::Status check_uncertainty(const CouplingUncertainty& uncertainty, const std::string& where, bool misalignment) {
  const auto list = entries_of(uncertainty.standard);
  if (!std::all_of(list.begin(), list.end(), is_half_width)) {
    return base::bad_input("standard uncertainties must be finite and not negative", where);
  }
  if (misalignment && (list[0] != 0.0 || list[4] != 0.0 || list[8] != 0.0)) {
    return base::bad_input("the diagonal must be 0: it belongs to the scale curves", where);
  }
  return {};
}

base::Status add_coupling(CouplingBlocks& blocks, std::uint32_t block, const std::optional<Matrix3>& matrix,
                          const std::optional<CouplingUncertainty>& uncertainty, const std::string& where) {
  if (!uncertainty) return {};
  if (!matrix) return base::bad_input("an uncertainty needs the matrix that it is of", where);
  auto status = check_uncertainty(*uncertainty, where, block == SOAK_MISALIGNMENT);
  if (!status) return status;
  blocks.add(block, uncertainty->readings_only, entries_of(uncertainty->standard));
  return {};
}

base::Status add_even_order(CouplingBlocks& blocks, const Calibration& calibration) {
  for (std::uint32_t axis = 0; axis < 3; ++axis) {
    const auto& term = calibration.even_order[axis];
    if (!term) continue;
    if (!fits_float(term->value) || !is_half_width(term->standard_uncertainty)) {
      return base::bad_input("an even-order term needs a finite value and a finite uncertainty, not negative",
                             "even_order");
    }
    blocks.add(SOAK_BLOCK_EVEN_ORDER + axis, term->readings_only, {term->value, term->standard_uncertainty});
  }
  return {};
}

bool is_of_readings_only(const std::uint8_t* payload, std::uint32_t block) {
  return (soak_u32(payload) >> (8U + block) & 1U) != 0;
}

std::optional<CouplingUncertainty> read_coupling(const std::uint8_t* payload, std::uint32_t block) {
  const std::uint8_t* at = soak_coupling_block(payload, block);
  if (at == nullptr) return std::nullopt;
  return CouplingUncertainty{read_matrix(at), is_of_readings_only(payload, block)};
}

// ---- terms ----

bool is_memory(std::string_view name) { return name == "thermal_hysteresis"; }

base::Status check_term(const AcceptedTerm& term) {
  const std::string where = "term " + term.name;
  if (term.name.empty()) return base::bad_input("an accepted term has no name", "terms");
  if (auto status = check_text(term.name, "name of a term"); !status) return status;
  if (term.parameters.size() > kMaxText) return base::bad_input("a term has more than 255 parameters", where);
  for (const auto& [name, value] : term.parameters) {
    if (auto status = check_text(name, "name of a parameter"); !status) return status;
    if (!fits_float(value)) return base::bad_input("parameter " + name + " is not a finite float32 number", where);
  }
  if (!can_be_followed(term)) {
    return base::bad_input("a memory needs width_c above 0, and its mean last, in pairs with rising temperatures",
                           where);
  }
  return {};
}

}  // namespace

base::Result<Section> sensor_section(const SensorCalibration& sensor) {
  const std::string where(name_of(sensor.sensor));
  if (auto status = check_text(sensor.model, "model name of " + where); !status) return base::forward_error(status);
  if (!(sensor.temp_min_c >= static_cast<double>(SOAK_TEMP_LOWEST)) ||
      !(sensor.temp_max_c <= static_cast<double>(SOAK_TEMP_HIGHEST)) || !(sensor.temp_min_c <= sensor.temp_max_c)) {
    return base::bad_input("the valid range must rise and lie within -273.15 ... 1000 °C", where);
  }
  base::ByteWriter out;
  out.write(static_cast<std::uint8_t>(index_of(sensor.sensor)));
  out.write(static_cast<std::uint8_t>(sensor.model.size()));
  out.write(std::uint16_t{0});
  write_floats(out, {sensor.temp_min_c, sensor.temp_max_c});
  write_text(out, sensor.model);
  return Section{SOAK_SECTION_SENSOR, true, out.take()};
}

SensorCalibration read_sensor(const std::uint8_t* payload) {
  SensorCalibration sensor;
  sensor.sensor = kSensors[payload[0]];
  sensor.temp_min_c = static_cast<double>(soak_f32(payload + 4));
  sensor.temp_max_c = static_cast<double>(soak_f32(payload + 8));
  sensor.model.assign(payload + 12, payload + 12 + payload[1]);
  return sensor;
}

base::Result<Section> uncertainty_section(Sensor sensor, Quantity quantity, const UncertaintyTable& table) {
  const std::string where = place(sensor, quantity) + " uncertainty";
  const std::size_t count = table.temp_c.size();
  if (count > SOAK_MAX_UNCERTAINTY_POINTS || table.ci95.size() != count ||
      (!table.pi95.empty() && table.pi95.size() != count)) {
    return base::bad_input("an uncertainty table needs as many half-widths as temperatures, at most " +
                               std::to_string(SOAK_MAX_UNCERTAINTY_POINTS),
                           where);
  }
  if (!std::all_of(table.ci95.begin(), table.ci95.end(), is_half_width) ||
      !std::all_of(table.pi95.begin(), table.pi95.end(), is_half_width)) {
    return base::bad_input("half-widths must be finite and not negative", where);
  }
  base::ByteWriter out = payload_of(sensor, quantity);
  out.write(static_cast<std::uint16_t>(count));
  out.write((table.pi95.empty() ? 0U : kHasPi95) | (table.one_run ? kOneRun : 0U));
  write_floats(out, table.temp_c);
  write_floats(out, table.ci95);
  write_floats(out, table.pi95);
  if (soak_rising_temperatures(out.bytes().data() + 8, static_cast<std::uint32_t>(count)) == 0) {
    return base::bad_input("the temperatures must rise within -273.15 ... 1000 °C", where);
  }
  return Section{SOAK_SECTION_UNCERTAINTY, false, out.take()};
}

UncertaintyTable read_uncertainty(const std::uint8_t* payload) {
  const std::size_t count = soak_u16(payload + 2);
  UncertaintyTable table;
  table.temp_c = read_floats(payload + 8, count);
  table.ci95 = read_floats(payload + 8 + 4 * count, count);
  if ((soak_u32(payload + 4) & kHasPi95) != 0) table.pi95 = read_floats(payload + 8 + 8 * count, count);
  table.one_run = (soak_u32(payload + 4) & kOneRun) != 0;
  return table;
}

bool says_one_run(std::span<const std::uint8_t> payload) { return (soak_u32(payload.data() + 4) & kOneRun) != 0; }

base::Result<Section> one_way_section(Sensor sensor, const OneWay& one_way) {
  const std::string where = std::string(name_of(sensor)) + " one_way";
  if (one_way.ranges.empty() || one_way.ranges.size() > kMaxOneWayRanges) {
    return base::bad_input("one-way temperatures need 1 to " + std::to_string(kMaxOneWayRanges) + " ranges", where);
  }
  for (const OneWayRange& range : one_way.ranges) {
    if (range.sweep == Sweep::unknown) return base::bad_input("a one-way range needs its way, up or down", where);
  }
  base::ByteWriter out;
  out.write(static_cast<std::uint8_t>(index_of(sensor)));
  out.write(static_cast<std::uint8_t>(one_way.known.source));
  out.write(static_cast<std::uint16_t>(one_way.ranges.size()));
  out.write(static_cast<float>(one_way.known.half_gap));
  for (const OneWayRange& range : one_way.ranges) {
    write_floats(out, {range.low_c, range.high_c});
    out.write(static_cast<std::uint32_t>(range.sweep));
  }
  if (!read_one_way(out.bytes())) {
    return base::bad_input(
        "one-way ranges must rise within -273.15 ... 1000 °C and lie apart, a half gap must be finite, "
        "not negative, and have a source",
        where);
  }
  return Section{kOneWaySection, false, out.take()};
}

base::Result<OneWay> read_one_way(std::span<const std::uint8_t> payload) {
  PayloadReader in(payload);
  OneWay one_way;
  in.number<std::uint8_t>();  // the sensor
  const auto source = in.number<std::uint8_t>();
  const auto count = in.number<std::uint16_t>();
  one_way.known = {static_cast<double>(in.number<float>()), static_cast<HysteresisSource>(source)};
  const bool known = one_way.known.source != HysteresisSource::none;
  bool good = count >= 1 && count <= kMaxOneWayRanges && source <= static_cast<std::uint8_t>(HysteresisSource::fleet) &&
              is_half_width(one_way.known.half_gap) && (known || one_way.known.half_gap == 0.0);
  double end_c = static_cast<double>(SOAK_TEMP_LOWEST);
  for (std::size_t i = 0; good && i < count; ++i) {
    const auto low_c = static_cast<double>(in.number<float>());
    const auto high_c = static_cast<double>(in.number<float>());
    const auto way = in.number<std::uint32_t>();
    good = !in.failed() && low_c >= end_c && high_c >= low_c && high_c <= static_cast<double>(SOAK_TEMP_HIGHEST) &&
           (way == 1 || way == 2);
    one_way.ranges.push_back({low_c, high_c, static_cast<Sweep>(way)});
    end_c = high_c;
  }
  if (!good || !in.is_whole()) return base::corrupt("temperatures visited one way break the format", "one_way");
  return one_way;
}

base::Result<Section> misalignment_section(const Matrix3& misalignment) {
  const std::string where = "accel_misalignment";
  if (auto status = check_misalignment(misalignment, where); !status) return base::forward_error(status);
  return matrix_section(SOAK_SECTION_MISALIGNMENT, misalignment, where);
}

base::Result<Section> gyro_misalignment_section(const Calibration& calibration) {
  const std::string where = "gyro_misalignment";
  const Matrix3& misalignment = *calibration.gyro_misalignment;
  const auto& uncertainty = calibration.gyro_misalignment_uncertainty;
  if (auto status = check_misalignment(misalignment, where); !status) return base::forward_error(status);
  std::uint8_t flags = 0;
  if (uncertainty) {
    auto status = check_uncertainty(*uncertainty, where + "_uncertainty", true);
    if (!status) return base::forward_error(status);
    flags = static_cast<std::uint8_t>(SOAK_GYRO_UNCERTAINTIES | (uncertainty->readings_only ? kGyroReadingsOnly : 0U));
  }
  base::ByteWriter out;
  for (const std::uint8_t byte : {flags, std::uint8_t{0}, std::uint8_t{0}, std::uint8_t{0}}) out.write(byte);
  write_floats(out, entries_of(misalignment));
  if (uncertainty) write_floats(out, entries_of(uncertainty->standard));
  return Section{SOAK_SECTION_GYRO_MISALIGNMENT, true, out.take()};
}

void read_gyro_misalignment(const std::uint8_t* payload, Calibration& calibration) {
  const std::uint32_t flags = soak_u32(payload);
  calibration.gyro_misalignment = read_matrix(payload + 4);
  if ((flags & SOAK_GYRO_UNCERTAINTIES) == 0) return;
  calibration.gyro_misalignment_uncertainty =
      CouplingUncertainty{read_matrix(payload + 40), (flags & kGyroReadingsOnly) != 0};
}

base::Result<Section> g_sensitivity_section(const Matrix3& g_sensitivity) {
  return matrix_section(SOAK_SECTION_G_SENSITIVITY, g_sensitivity, "g_sensitivity");
}

Matrix3 read_matrix(const std::uint8_t* payload) {
  const auto numbers = read_floats(payload, 9);
  Matrix3 matrix{};
  for (std::size_t i = 0; i < 9; ++i) matrix[i / 3][i % 3] = numbers[i];
  return matrix;
}

base::Result<std::optional<Section>> coupling_section(const Calibration& calibration) {
  CouplingBlocks blocks;
  auto status = add_coupling(blocks, SOAK_MISALIGNMENT, calibration.accel_misalignment,
                             calibration.misalignment_uncertainty, "misalignment_uncertainty");
  if (status) {
    status = add_coupling(blocks, SOAK_G_SENSITIVITY, calibration.g_sensitivity, calibration.g_sensitivity_uncertainty,
                          "g_sensitivity_uncertainty");
  }
  if (status) status = add_even_order(blocks, calibration);
  if (!status) return base::forward_error(status);
  if (blocks.flags == 0) return std::optional<Section>();
  base::ByteWriter out;
  // byte by byte: gcc 12 takes a word into the empty buffer for an overflow
  for (int shift = 0; shift < 32; shift += 8) out.write(static_cast<std::uint8_t>(blocks.flags >> shift));
  write_floats(out, blocks.numbers);
  return std::optional<Section>(Section{SOAK_SECTION_COUPLINGS, false, out.take()});
}

void read_couplings(const std::uint8_t* payload, Calibration& calibration) {
  calibration.misalignment_uncertainty = read_coupling(payload, SOAK_MISALIGNMENT);
  calibration.g_sensitivity_uncertainty = read_coupling(payload, SOAK_G_SENSITIVITY);
  for (std::uint32_t axis = 0; axis < 3; ++axis) {
    const std::uint32_t block = SOAK_BLOCK_EVEN_ORDER + axis;
    const std::uint8_t* at = soak_coupling_block(payload, block);
    if (at == nullptr) continue;
    const auto numbers = read_floats(at, 2);
    calibration.even_order[axis] = EvenOrderTerm{numbers[0], numbers[1], is_of_readings_only(payload, block)};
  }
}

base::Result<Section> term_section(const AcceptedTerm& term) {
  if (auto status = check_term(term); !status) return base::forward_error(status);
  std::uint8_t sensors = 0;
  for (const Sensor sensor : term.sensors) sensors = static_cast<std::uint8_t>(sensors | (1U << index_of(sensor)));
  base::ByteWriter out;
  out.write(term.lab_only ? kLabOnly : std::uint8_t{0});
  out.write(sensors);
  out.write(static_cast<std::uint8_t>(term.name.size()));
  out.write(static_cast<std::uint8_t>(term.parameters.size()));
  for (const auto& parameter : term.parameters) out.write(static_cast<float>(parameter.second));
  write_text(out, term.name);
  for (const auto& parameter : term.parameters) {
    out.write(static_cast<std::uint8_t>(parameter.first.size()));
    write_text(out, parameter.first);
  }
  return Section{SOAK_SECTION_TERM, false, out.take()};
}

base::Result<AcceptedTerm> read_term(std::span<const std::uint8_t> payload, std::uint16_t minor_version) {
  PayloadReader in(payload);
  AcceptedTerm term;
  const auto flags = in.number<std::uint8_t>();
  const auto sensors = in.number<std::uint8_t>();
  const auto name_length = in.number<std::uint8_t>();
  term.parameters.resize(in.number<std::uint8_t>());
  for (auto& parameter : term.parameters) parameter.second = static_cast<double>(in.number<float>());
  term.lab_only = (flags & kLabOnly) != 0;
  for (const Sensor sensor : kSensors) {
    if ((sensors >> index_of(sensor) & 1) != 0) term.sensors.push_back(sensor);
  }
  term.name = in.text(name_length);
  for (auto& parameter : term.parameters) parameter.first = in.text(in.number<std::uint8_t>());
  if (is_memory(term.name) && minor_version < SOAK_HISTORY_MINOR_VERSION) term.lab_only = true;
  const bool finite =
      std::ranges::all_of(term.parameters, [](const auto& parameter) { return std::isfinite(parameter.second); });
  if (!in.is_whole() || term.name.empty() || !finite || !can_be_followed(term)) {
    return base::corrupt("an accepted term breaks the format", "terms");
  }
  return term;
}

bool is_memory_to_follow(std::span<const std::uint8_t> payload) {
  const auto term = read_term(payload, SOAK_HISTORY_MINOR_VERSION);
  return term && is_memory(term->name) && !term->lab_only;
}

}  // namespace soak::calib::file
