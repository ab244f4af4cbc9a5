// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "anfis/model/one_input.h"
#include "base/bytes.h"
#include "calib/curve/calibration.h"
#include "calib/deploy/table_form.h"

namespace soak::calib::samples {

/// CRC-32C bit by bit, straight from its definition: independent of the product's tables.
inline std::uint32_t plain_crc32c(const std::uint8_t* data, std::size_t size) {
  std::uint32_t crc = 0xFFFFFFFFU;
  for (std::size_t i = 0; i < size; ++i) {
    crc ^= data[i];
    for (int bit = 0; bit < 8; ++bit) crc = (crc & 1U) != 0 ? (crc >> 1) ^ 0x82F63B78U : crc >> 1;
  }
  return ~crc;
}

template <class T>
void put(base::Bytes& bytes, std::size_t at, T value) {
  std::memcpy(bytes.data() + at, &value, sizeof value);
}

template <class T>
T get(const base::Bytes& bytes, std::size_t at) {
  T value;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

/// Makes size field and CRC fit the bytes again.
inline void seal(base::Bytes& bytes) {
  put(bytes, 12, static_cast<std::uint32_t>(bytes.size()));
  put(bytes, bytes.size() - 4, plain_crc32c(bytes.data(), bytes.size() - 4));
}

/// Offset of the head of the first section of a type; 0 if there is none.
inline std::size_t head_of(const base::Bytes& bytes, std::uint16_t type) {
  for (std::size_t at = get<std::uint32_t>(bytes, 16); at + 12 <= bytes.size();
       at += 8 + get<std::uint32_t>(bytes, at + 4)) {
    if (get<std::uint16_t>(bytes, at) == type) return at;
  }
  return 0;
}

/// Puts a section behind the last one.
inline void append_section(base::Bytes& bytes, std::uint16_t type, std::uint8_t version, bool critical,
                           const base::Bytes& payload) {
  base::ByteWriter section;
  section.write(type);
  section.write(version);
  section.write(static_cast<std::uint8_t>(critical ? 1 : 0));
  section.write(static_cast<std::uint32_t>(payload.size()));
  section.write(payload);
  bytes.insert(bytes.end() - 4, section.bytes().begin(), section.bytes().end());
  put(bytes, 20, get<std::uint32_t>(bytes, 20) + 1);
  seal(bytes);
}

/// Offset of the payload of the first section of this type that starts with sensor and quantity; 0 if there is none.
inline std::size_t payload_of(const base::Bytes& bytes, std::uint16_t type, std::uint8_t sensor,
                              std::uint8_t quantity) {
  for (std::size_t at = get<std::uint32_t>(bytes, 16); at + 12 < bytes.size();
       at += 8 + get<std::uint32_t>(bytes, at + 4)) {
    if (get<std::uint16_t>(bytes, at) == type && bytes[at + 8] == sensor && bytes[at + 9] == quantity) return at + 8;
  }
  return 0;
}

/// Model over -30 ... 70 °C.
inline anfis::Model fis_of(anfis::Shape shape, const std::vector<anfis::CurveRule>& rules, anfis::Scale input,
                           anfis::Scale output) {
  anfis::Model model = anfis::curve_model(shape, rules);
  model.inputs[0].scale = input;
  model.inputs[0].min = -30.0;
  model.inputs[0].max = 70.0;
  model.output = output;
  return model;
}

/// Rule k of sensor i in the golden files, whose values tests/data/golden/make_values.py computes by the same formulas.
inline anfis::Model fis(std::size_t sensor, anfis::Shape shape, double centre, double half_range) {
  const auto i = static_cast<double>(sensor);
  std::vector<anfis::CurveRule> rules;
  for (int n = 0; n < 6; ++n) {
    const double k = n;
    anfis::CurveRule rule;
    rule.width = 0.15 + 0.02 * k;
    rule.slope = shape == anfis::Shape::bell ? 1.5 + 0.25 * k : 0.0;
    rule.centre = -1.0 + 0.4 * k;
    rule.gain = 0.3 * (k - i);
    rule.offset = 0.8 - 0.1 * k * k + 0.05 * i;
    rules.push_back(rule);
  }
  return fis_of(shape, rules, {20.0, 50.0}, {centre, half_range});
}

inline SplineCurve spline(double amplitude) {
  return {{-30.0, -5.0, 20.0, 45.0, 70.0},
          {{amplitude * 1.0, amplitude * 0.01, amplitude * -0.002, amplitude * 0.00004},
           {amplitude * 0.625, amplitude * -0.015, amplitude * 0.001, amplitude * -0.00002},
           {amplitude * 0.5625, amplitude * -0.0025, amplitude * -0.0005, amplitude * 0.00001},
           {amplitude * 0.34375, amplitude * -0.00875, amplitude * 0.00025, amplitude * 0.0}}};
}

inline TableCurve table(double amplitude) {
  TableCurve curve{-30.0, 2.5, {}};
  for (int k = 0; k <= 40; ++k) curve.values.push_back(amplitude * (1.0 + 0.02 * k - 0.001 * k * k));
  return curve;
}

inline UncertaintyTable uncertainty(double ci95, double pi95) {
  return {{-30.0, 20.0, 70.0}, {ci95, 0.5 * ci95, 2.0 * ci95}, {pi95, pi95, 1.5 * pi95}};
}

inline Calibration provenance(const std::string& unit) {
  Calibration calibration;
  calibration.unit = unit;
  calibration.unit_type = "demo";
  calibration.epoch = 2;
  calibration.model_version = 7;
  calibration.created_utc_s = 1795248000.25;
  calibration.gravity_mps2 = 9.8123;
  calibration.gravity_assumed = false;
  calibration.run_hashes = {"e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855",
                            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"};
  return calibration;
}

/// Golden file "fis": six sensors, bells for the gyros and Gaussians for the accelerometers, no cross terms.
inline Calibration golden_fis() {
  Calibration calibration = provenance("SN-0001");
  for (const Sensor sensor : kSensors) {
    SensorCalibration one;
    one.sensor = sensor;
    one.temp_min_c = -30.0;
    one.temp_max_c = 70.0;
    one.model = "anfis";
    const std::size_t i = index_of(sensor);
    if (is_gyro(sensor)) {
      one.bias = fis(i, anfis::Shape::bell, 0.01, 0.004);
    } else {
      one.bias = fis(i, anfis::Shape::gaussian, -0.2, 0.1);
      one.scale_ppm = fis(i, anfis::Shape::gaussian, 1500.0, 400.0);
      one.scale_uncertainty = UncertaintyTable{{-30.0, 70.0}, {20.0, 30.0}, {}};
    }
    one.bias_uncertainty = uncertainty(0.0001, 0.0005);
    calibration.sensors.push_back(one);
  }
  return calibration;
}

/// Golden file "whole": as "fis", but for bells whose exponents 2b are whole numbers, odd and even.
inline Calibration golden_whole() {
  Calibration calibration = golden_fis();
  calibration.unit = "SN-0004";
  for (SensorCalibration& sensor : calibration.sensors) {
    if (!is_gyro(sensor.sensor)) continue;
    auto rules = anfis::curve_rules(std::get<anfis::Model>(sensor.bias));
    for (std::size_t k = 0; k < rules.size(); ++k) rules[k].slope = 1.0 + 0.5 * static_cast<double>(k);
    sensor.bias = fis_of(anfis::Shape::bell, rules, {20.0, 50.0}, {0.01, 0.004});
  }
  return calibration;
}

/// Golden file "table": the table form of "fis", a point at each whole °C.
inline Calibration golden_table() {
  Calibration calibration = *table_form(golden_fis(), 101);
  calibration.unit = "SN-0005";
  return calibration;
}

/// Golden file "mixed": splines and tables, misalignment, g-sensitivity, an accepted term; simulated; no gyro_y.
inline Calibration golden_mixed() {
  Calibration calibration = provenance("SN-0002");
  calibration.simulated = true;
  calibration.gravity_mps2 = 9.80665;
  calibration.gravity_assumed = true;
  for (const Sensor sensor : kSensors) {
    if (sensor == Sensor::gyro_y) continue;
    SensorCalibration one;
    one.sensor = sensor;
    one.temp_min_c = -25.0;
    one.temp_max_c = 65.0;
    one.model = is_gyro(sensor) ? "spline" : "table";
    const auto i = static_cast<double>(index_of(sensor));
    if (is_gyro(sensor)) {
      one.bias = spline(0.01 * (1.0 + i));
      one.bias_uncertainty = uncertainty(0.0002, 0.0004);
    } else {
      one.bias = table(0.1 * (i - 2.0));
      one.scale_ppm = spline(1000.0 * (i - 2.0));
    }
    calibration.sensors.push_back(one);
  }
  calibration.accel_misalignment = {{{0.0, 0.002, -0.001}, {0.003, 0.0, 0.0015}, {-0.0025, 0.001, 0.0}}};
  calibration.g_sensitivity = {{{1e-4, 2e-5, 0.0}, {0.0, 1e-4, 3e-5}, {-2e-5, 0.0, 1.5e-4}}};
  calibration.terms = {
      {"temperature_rate", false, {Sensor::gyro_x, Sensor::gyro_z}, {{"gyro_x", 1e-4}, {"gyro_z", -2e-4}}}};
  return calibration;
}

/// A reference that is good, and one that was used by a waiver. It is signed with the key that RFC 8032 prints.
inline std::vector<ReferenceUse> references() {
  const Reference probe{"01890a5d-ac96-774b-bcce-b302099a8057",
                        ReferenceKind::chamber_probe,
                        "probe 3",
                        "D-K-15048-2026-07",
                        -0.02,
                        0.025,
                        1767225600.0,
                        1798761600.0};
  const Reference cube{"018cc251-f400-7c3e-8000-0000000000c2",
                       ReferenceKind::fixture_squareness,
                       "cube 7",
                       "PTB 5.31-4012",
                       std::nullopt,
                       1e-4,
                       1704067200.0,
                       1735689600.0};
  const Waiver waiver{"019ada3c-9e00-7a10-8000-00000000a11e",
                      cube.record_id,
                      "a new cube is ordered; its faces were compared on 2025-11-28",
                      "Ann Example",
                      "d75a980182b10ab7d54bfed3c964073a0ee172f3daa62325af021a68f707511a",
                      1764590400.0,
                      "ea7e2f2f430fa5fa282d72ef553a9fb320587e880291e1bc63e70937a36ea899"
                      "57923163777f8b993a67cec3f8e3b3f01eaa3d5275c89a444d36be2254fb5f0c"};
  return {{probe, std::nullopt}, {cube, waiver}};
}

/// Golden file "referenced": as "fis", with references.
inline Calibration golden_referenced() {
  Calibration calibration = golden_fis();
  calibration.unit = "SN-0006";
  calibration.references = references();
  return calibration;
}

/// Golden file "couplings": as "mixed", with all that can be stated of couplings but the even-order term of accel_y.
/// The numbers are exact in float32.
inline Calibration golden_couplings() {
  Calibration calibration = golden_mixed();
  calibration.unit = "SN-0007";
  calibration.misalignment_uncertainty = {
      {{{0.0, 0x1p-13, 0x1p-14}, {0x1.8p-13, 0.0, 0x1p-13}, {0x1p-14, 0x1p-13, 0.0}}}, false};
  calibration.g_sensitivity_uncertainty = {
      {{{0x1p-17, 0x1p-18, 0x1p-18}, {0x1p-18, 0x1p-17, 0x1p-18}, {0x1p-18, 0x1p-18, 0x1p-17}}}, true};
  calibration.even_order = {EvenOrderTerm{-0x1p-18, 0x1p-20, false}, std::nullopt,
                            EvenOrderTerm{0x1p-19, 0x1p-19, true}};
  return calibration;
}

/// Golden file "thermometers": as "fis", with gyro_x and accel_z over thermometers of their own.
inline Calibration golden_thermometers() {
  Calibration calibration = golden_fis();
  calibration.unit = "SN-0008";
  calibration.sensors[0].own_thermometer = true;
  calibration.sensors[5].own_thermometer = true;
  return calibration;
}

/// Golden file "gyros": as "mixed", with misalignment of the gyros. Powers of two come back from float32 unchanged.
inline Calibration golden_gyros() {
  Calibration calibration = golden_mixed();
  calibration.unit = "SN-0009";
  calibration.gyro_misalignment = {{{0.0, 0.004, -0.003}, {0.002, 0.0, 0.005}, {-0.001, 0.0035, 0.0}}};
  calibration.gyro_misalignment_uncertainty = {
      {{{0.0, 0x1p-12, 0x1p-13}, {0x1.8p-12, 0.0, 0x1p-12}, {0x1p-13, 0x1p-12, 0.0}}}, true};
  return calibration;
}

/// Golden file "one_way": as "fis", of one run, with temperatures that gyro_x, accel_y and accel_z were visited at one
/// way only. The numbers are exact in float32.
inline Calibration golden_one_way() {
  Calibration calibration = golden_fis();
  calibration.unit = "SN-0010";
  calibration.run_hashes.resize(1);
  for (SensorCalibration& sensor : calibration.sensors) {
    sensor.bias_uncertainty.pi95.clear();
    sensor.bias_uncertainty.one_run = true;
    if (sensor.scale_uncertainty) sensor.scale_uncertainty->one_run = true;
  }
  calibration.sensors[0].one_way =
      OneWay{{{-22.5, 17.5, Sweep::up}, {32.5, 62.5, Sweep::up}}, {0x1p-12, HysteresisSource::type}};
  calibration.sensors[4].one_way = OneWay{{{-30.0, 70.0, Sweep::up}}, {0x1p-8, HysteresisSource::fleet}};
  calibration.sensors[5].one_way = OneWay{{{-30.0, 20.0, Sweep::down}, {20.0, 45.0, Sweep::up}}, {}};
  return calibration;
}

/// golden_fis() with a memory in two gyros that a device can follow.
inline Calibration golden_unreleased() {
  Calibration calibration = golden_fis();
  calibration.unit = "SN-0012";
  calibration.unreleased = true;
  return calibration;
}

inline Calibration golden_history() {
  Calibration calibration = golden_fis();
  calibration.unit = "SN-0011";
  calibration.terms = {{"thermal_hysteresis",
                        false,
                        {Sensor::gyro_x, Sensor::gyro_z},
                        {{"amplitude", 0x1p-9},
                         {"amplitude_per_c", 0x1p-16},
                         {"width_c", 8.0},
                         {"reference_c", 20.0},
                         {"mean_1_c", -30.0},
                         {"mean_1", -0x1p-11},
                         {"mean_2_c", 70.0},
                         {"mean_2", 0x1p-10}}}};
  return calibration;
}

/// One sensor with the given bias curve, valid from -30 to 70 °C.
inline Calibration with_bias(const Curve& curve, Sensor sensor = Sensor::gyro_x) {
  Calibration calibration = provenance("SN-0003");
  SensorCalibration one;
  one.sensor = sensor;
  one.temp_min_c = -30.0;
  one.temp_max_c = 70.0;
  one.model = "anfis";
  one.bias = curve;
  calibration.sensors.push_back(one);
  return calibration;
}

inline std::string data_file(const std::string& name) { return SOAK_TEST_FOLDER "/data/golden/" + name; }

inline base::Bytes read_file(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

}  // namespace soak::calib::samples
