// SPDX-License-Identifier: Apache-2.0
#include "calib/deploy/detail/record_section.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "base/hash.h"
#include "base/text.h"
#include "calib/runtime/soak_runtime.h"

namespace soak::calib::file {
namespace {

constexpr std::uint32_t kSimulated = 1;
constexpr std::uint32_t kGravityAssumed = 2;
constexpr std::uint32_t kHasPi95 = 1;
constexpr std::uint8_t kLabOnly = 1;

base::Status check_provenance(const Calibration& calibration) {
  if (calibration.unit.empty()) return base::bad_input("the calibration names no unit", "unit");
  if (auto status = check_text(calibration.unit, "serial number"); !status) return status;
  if (auto status = check_text(calibration.unit_type, "unit type"); !status) return status;
  if (!std::isfinite(calibration.created_utc_s) || !std::isfinite(calibration.gravity_mps2)) {
    return base::bad_input("creation time and gravity must be finite numbers", "created_utc_s, gravity_mps2");
  }
  if (calibration.run_hashes.size() > SOAK_MAX_RUNS) {
    return base::bad_input("the file carries the hashes of at most " + std::to_string(SOAK_MAX_RUNS) + " runs",
                           "run_hashes");
  }
  return {};
}

base::Result<Section> matrix_section(std::uint16_t type, const Matrix3& matrix, const std::string& where) {
  base::ByteWriter out;
  for (const Vector3& row : matrix) {
    const std::vector<double> numbers(row.begin(), row.end());
    if (!fit_float(numbers)) return base::bad_input("a number of the matrix is not finite", where);
    write_floats(out, numbers);
  }
  return Section{type, true, out.take()};
}

base::Status check_term(const AcceptedTerm& term) {
  const std::string where = "term " + term.name;
  if (term.name.empty()) return base::bad_input("an accepted term has no name", "terms");
  if (auto status = check_text(term.name, "name of a term"); !status) return status;
  if (term.parameters.size() > kMaxText) return base::bad_input("a term has more than 255 parameters", where);
  for (const auto& [name, value] : term.parameters) {
    if (auto status = check_text(name, "name of a parameter"); !status) return status;
    if (!fits_float(value)) return base::bad_input("parameter " + name + " is not a finite float32 number", where);
  }
  return {};
}

}  // namespace

base::Result<Section> provenance_section(const Calibration& calibration) {
  if (auto status = check_provenance(calibration); !status) return base::forward_error(status);
  base::ByteWriter out;
  out.write(calibration.epoch);
  out.write(calibration.model_version);
  out.write(calibration.created_utc_s);
  out.write(calibration.gravity_mps2);
  out.write((calibration.simulated ? kSimulated : 0U) | (calibration.gravity_assumed ? kGravityAssumed : 0U));
  out.write(static_cast<std::uint16_t>(calibration.run_hashes.size()));
  out.write(static_cast<std::uint8_t>(calibration.unit.size()));
  out.write(static_cast<std::uint8_t>(calibration.unit_type.size()));
  for (const std::string& hex : calibration.run_hashes) {
    const auto digest = base::bytes_of_hex<32>(hex);
    if (!digest)
      return base::bad_input("a run hash must be 64 lower-case hexadecimal digits, not '" + hex + "'", "run_hashes");
    out.write(*digest);
  }
  write_text(out, calibration.unit);
  write_text(out, calibration.unit_type);
  return Section{SOAK_SECTION_PROVENANCE, true, out.take()};
}

void read_provenance(const std::uint8_t* payload, Calibration& calibration) {
  const std::size_t runs = soak_u16(payload + 28);
  const std::size_t unit_length = payload[30];
  const std::size_t type_length = payload[31];
  base::ByteReader in({payload, 32});
  calibration.epoch = *in.read<std::int32_t>();
  calibration.model_version = *in.read<std::int32_t>();
  calibration.created_utc_s = *in.read<double>();
  calibration.gravity_mps2 = *in.read<double>();
  const auto flags = *in.read<std::uint32_t>();
  calibration.simulated = (flags & kSimulated) != 0;
  calibration.gravity_assumed = (flags & kGravityAssumed) != 0;
  for (std::size_t i = 0; i < runs; ++i) calibration.run_hashes.push_back(base::to_hex({payload + 32 + 32 * i, 32}));
  const std::uint8_t* text = payload + 32 + 32 * runs;
  calibration.unit = text_at(text, unit_length);
  calibration.unit_type = text_at(text + unit_length, type_length);
}

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
  sensor.model = text_at(payload + 12, payload[1]);
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
  const auto is_half_width = [](double value) { return value >= 0.0 && fits_float(value); };
  if (!std::all_of(table.ci95.begin(), table.ci95.end(), is_half_width) ||
      !std::all_of(table.pi95.begin(), table.pi95.end(), is_half_width)) {
    return base::bad_input("half-widths must be finite and not negative", where);
  }
  base::ByteWriter out = payload_of(sensor, quantity);
  out.write(static_cast<std::uint16_t>(count));
  out.write(table.pi95.empty() ? 0U : kHasPi95);
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
  return table;
}

base::Result<Section> misalignment_section(const Matrix3& misalignment) {
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      const double number = misalignment[i][j];
      const bool good = i == j ? number == 0.0 : std::abs(number) <= static_cast<double>(SOAK_MAX_MISALIGNMENT);
      if (!good) {
        return base::bad_input("misalignment needs a diagonal of 0 and no number beyond 0.2", "accel_misalignment");
      }
    }
  }
  return matrix_section(SOAK_SECTION_MISALIGNMENT, misalignment, "accel_misalignment");
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

base::Result<AcceptedTerm> read_term(std::span<const std::uint8_t> payload) {
  const auto damaged = [] { return base::corrupt("an accepted term breaks the format", "terms"); };
  base::ByteReader in(payload);
  const auto head = in.take(4);
  if (!head) return damaged();
  const std::size_t name_length = (*head)[2];
  const std::size_t count = (*head)[3];
  const auto values = in.take(4 * count);
  const auto name = in.take(name_length);
  if (!values || !name || name_length == 0) return damaged();
  const auto numbers = read_floats(values->data(), count);
  if (!fit_float(numbers)) return damaged();
  AcceptedTerm term;
  term.lab_only = ((*head)[0] & kLabOnly) != 0;
  term.name.assign(name->begin(), name->end());
  for (const Sensor sensor : kSensors) {
    if (((*head)[1] >> index_of(sensor) & 1) != 0) term.sensors.push_back(sensor);
  }
  for (const double number : numbers) {
    const auto length = in.read<std::uint8_t>();
    const auto text = length ? in.take(*length) : std::nullopt;
    if (!text) return damaged();
    term.parameters.emplace_back(std::string(text->begin(), text->end()), number);
  }
  if (in.remaining() >= 4) return damaged();
  return term;
}

}  // namespace soak::calib::file
