// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/bytes.h"
#include "base/result.h"
#include "calib/curve/calibration.h"

/// The sections of a calibration file (docs/blob-format.md §3, §4), each way: the writers refuse what the format cannot
/// carry, the readers take payloads that soak_load() has accepted, unless they say otherwise.
namespace soak::calib::file {

/// One section before it is written.
struct Section {
  std::uint16_t type = 0;
  bool critical = true;
  base::Bytes payload;  ///< its length is made a multiple of 4 when the file is put together
};

/// Type of the section of a reference; the runtime, which has no use for it, passes over it.
inline constexpr std::uint16_t kReferenceSection = 0x0002;

/// Type of the section of temperatures that were visited one way only; the runtime passes over it too.
inline constexpr std::uint16_t kOneWaySection = 0x0015;
/// Most ranges that it carries.
inline constexpr std::size_t kMaxOneWayRanges = 64;

/// Longest text that the format carries, in bytes.
inline constexpr std::size_t kMaxText = 255;

/// What a curve describes; the value is its number in the file.
enum class Quantity : std::uint8_t { bias, scale_ppm };

/// "gyro_x bias": names a curve in messages.
[[nodiscard]] std::string place(Sensor sensor, Quantity quantity);

// ---- parts of payloads ----

/// Starts the payload of a section that belongs to one curve.
[[nodiscard]] base::ByteWriter payload_of(Sensor sensor, Quantity quantity);

/// The numbers rounded to float32, one after the other; and `count` of them from a payload, which holds them all.
void write_floats(base::ByteWriter& out, const std::vector<double>& values);
[[nodiscard]] std::vector<double> read_floats(const std::uint8_t* payload, std::size_t count);

/// Whether numbers are finite and stay so when rounded to float32.
[[nodiscard]] bool fits_float(double value);
[[nodiscard]] bool fit_float(const std::vector<double>& values);

/// The bytes of a text, without its length.
void write_text(base::ByteWriter& out, const std::string& text);

/// Refuses a text that is longer than the format carries; `what` names it.
[[nodiscard]] base::Status check_text(const std::string& text, const std::string& what);

/// Takes a payload apart that nobody has checked; a piece that is not there leaves the reader failed.
class PayloadReader {
 public:
  explicit PayloadReader(std::span<const std::uint8_t> payload) : in_(payload) {}

  template <class T>
  T number() {
    const auto value = in_.read<T>();
    failed_ = failed_ || !value;
    return value.value_or(T{});
  }
  std::span<const std::uint8_t> bytes(std::size_t count) {
    const auto piece = in_.take(count);
    failed_ = failed_ || !piece;
    return piece.value_or(std::span<const std::uint8_t>());
  }
  std::string text(std::size_t count) {
    const auto piece = bytes(count);
    return {piece.begin(), piece.end()};
  }
  [[nodiscard]] bool failed() const { return failed_; }
  /// Whether every piece was there and nothing but padding is left.
  [[nodiscard]] bool is_whole() const { return !failed_ && in_.remaining() < 4; }

 private:
  base::ByteReader in_;
  bool failed_ = false;
};

// ---- where the calibration comes from (provenance_sections.cpp) ----

[[nodiscard]] base::Result<Section> provenance_section(const Calibration& calibration);
void read_provenance(const std::uint8_t* payload, Calibration& calibration);
/// Whether the payload of a provenance section says something that 1.0 to 1.7 do not know.
[[nodiscard]] bool says_unreleased(std::span<const std::uint8_t> payload);

/// Most references that a file carries: beside them, 256 sections hold all else that there can be.
inline constexpr std::size_t kMaxReferences = 160;

/// Section 0x0002. Refuses what the format cannot carry, naming the reference.
[[nodiscard]] base::Result<Section> reference_section(const ReferenceUse& use);
/// soak_load() does not look into references: this reader checks, and refuses as corrupt.
[[nodiscard]] base::Result<ReferenceUse> read_reference(std::span<const std::uint8_t> payload);

// ---- what belongs to sensors beside their curves (sensor_sections.cpp) ----

[[nodiscard]] base::Result<Section> sensor_section(const SensorCalibration& sensor);
[[nodiscard]] SensorCalibration read_sensor(const std::uint8_t* payload);

[[nodiscard]] base::Result<Section> uncertainty_section(Sensor sensor, Quantity quantity,
                                                        const UncertaintyTable& table);
[[nodiscard]] UncertaintyTable read_uncertainty(const std::uint8_t* payload);
/// Whether the payload of an uncertainty table says something that 1.0 to 1.5 do not know.
[[nodiscard]] bool says_one_run(std::span<const std::uint8_t> payload);

/// Section 0x0015. Refuses ranges that do not rise, and a half gap that is negative, not finite or of no source.
[[nodiscard]] base::Result<Section> one_way_section(Sensor sensor, const OneWay& one_way);
/// soak_load() does not look into it: this reader checks, and refuses as corrupt. The first byte of the payload is the
/// sensor.
[[nodiscard]] base::Result<OneWay> read_one_way(std::span<const std::uint8_t> payload);

using Matrix3 = std::array<Vector3, 3>;
[[nodiscard]] base::Result<Section> misalignment_section(const Matrix3& misalignment);
/// Section 0x0025, the gyros' misalignment with what is stated of it. Refuses as misalignment_section(), and
/// uncertainties that are negative or not finite.
[[nodiscard]] base::Result<Section> gyro_misalignment_section(const Calibration& calibration);
void read_gyro_misalignment(const std::uint8_t* payload, Calibration& calibration);
[[nodiscard]] base::Result<Section> g_sensitivity_section(const Matrix3& g_sensitivity);
[[nodiscard]] Matrix3 read_matrix(const std::uint8_t* payload);

/// Section 0x0023 of what the calibration states of its couplings; absent where it states nothing. Refuses
/// uncertainties that are negative, not finite, or of a matrix that the calibration does not have.
[[nodiscard]] base::Result<std::optional<Section>> coupling_section(const Calibration& calibration);
void read_couplings(const std::uint8_t* payload, Calibration& calibration);

[[nodiscard]] base::Result<Section> term_section(const AcceptedTerm& term);
/// soak_load() does not look into terms: this reader checks, and refuses as corrupt. A memory of a file before 1.7
/// comes back as lab only: such a file need not say what its curves hold of it.
[[nodiscard]] base::Result<AcceptedTerm> read_term(std::span<const std::uint8_t> payload, std::uint16_t minor_version);
/// Whether the payload of a term is a memory that a device follows, which 1.0 to 1.6 do not know.
[[nodiscard]] bool is_memory_to_follow(std::span<const std::uint8_t> payload);

// ---- curves (curve_section.cpp, curve_check.cpp) ----

/// Centre and half range that a curve's values are scaled by in the file; both are float32 numbers, half_range > 0.
struct OutputScale {
  double centre = 0.0;
  double half_range = 1.0;
};

/// Whether the curve can be evaluated and lies within the format's limits; of models the format carries those that
/// anfis::validate_curve() accepts: one input, one bell or Gaussian per rule. `where` names the curve.
[[nodiscard]] base::Status check_curve(const Curve& curve, const std::string& where);

/// The section of a curve that check_curve() accepts. What rounding `scale` and the FIS' centres to float32 would cost
/// is put into the other numbers, so that only their own rounding remains. Refuses numbers beyond float32 and knots
/// that coincide there.
[[nodiscard]] base::Result<Section> curve_section(Sensor sensor, Quantity quantity, const Curve& curve,
                                                  const OutputScale& scale);

/// What a table that stands for another curve says of its difference from it (docs/blob-format.md 0x0031); nothing for
/// all other curves. Rounded up.
[[nodiscard]] std::optional<Section> table_bound_section(Sensor sensor, Quantity quantity, const Curve& curve);

/// The curve in a payload; `type` is its section's.
[[nodiscard]] Curve read_curve(std::uint32_t type, const std::uint8_t* payload);

/// A curve's section, and the section that states how far float32 is off (docs/blob-format.md 0x0030).
struct CheckedCurve {
  Section curve;
  Section bound;
};

/// A curve in the form that it has, compared with its double precision by the deployment runtime over the sensor's
/// valid range; a fuzzy model whose own form float32 cannot hold in that of a cubic spline. Refuses what check_curve()
/// refuses, a curve that is not finite in the range or a scale factor error beyond ±500,000 ppm, one that differs by
/// more than docs/blob-format.md allows, and a model with a gap between its rules where every strength is below 1e-30.
[[nodiscard]] base::Result<CheckedCurve> checked_curve(const Curve& curve, const SensorCalibration& sensor,
                                                       Quantity quantity);

}  // namespace soak::calib::file
