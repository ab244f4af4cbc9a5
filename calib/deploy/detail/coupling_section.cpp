// SPDX-License-Identifier: Apache-2.0
#include "calib/deploy/detail/coupling_section.h"

#include <algorithm>
#include <array>
#include <string>
#include <utility>
#include <vector>

#include "calib/runtime/soak_runtime.h"

namespace soak::calib::file {
namespace {

using MaybeUncertainty = std::optional<CouplingUncertainty>;

/// Blocks of the section in the making: bit k of the flags for block k, bit 8 + k where it is of the readings only.
struct Blocks {
  std::uint32_t flags = 0;
  std::vector<double> numbers;

  void add(std::uint32_t block, bool readings_only, const std::vector<double>& values) {
    flags |= 1U << block | (readings_only ? 1U << (8U + block) : 0U);
    numbers.insert(numbers.end(), values.begin(), values.end());
  }
};

bool is_uncertainty(double value) { return value >= 0.0 && fits_float(value); }

std::vector<double> entries(const CouplingUncertainty& uncertainty) {
  std::vector<double> list;
  for (const Vector3& row : uncertainty.standard) list.insert(list.end(), row.begin(), row.end());
  return list;
}

base::Status check(const MaybeUncertainty& uncertainty, bool has_matrix, bool has_diagonal, const std::string& where) {
  if (!uncertainty) return {};
  if (!has_matrix) return base::bad_input("an uncertainty needs the matrix that it is of", where);
  const auto list = entries(*uncertainty);
  if (!std::all_of(list.begin(), list.end(), is_uncertainty)) {
    return base::bad_input("standard uncertainties must be finite and not negative", where);
  }
  if (!has_diagonal && (list[0] != 0.0 || list[4] != 0.0 || list[8] != 0.0)) {
    return base::bad_input("the diagonal must be 0: it belongs to the scale curves", where);
  }
  return {};
}

base::Status add_even_order(const Calibration& calibration, Blocks& blocks) {
  for (std::uint32_t axis = 0; axis < 3; ++axis) {
    const auto& term = calibration.even_order[axis];
    if (!term) continue;
    if (!fits_float(term->value) || !is_uncertainty(term->standard_uncertainty)) {
      return base::bad_input("an even-order term needs a finite value and a finite uncertainty, not negative",
                             "even_order");
    }
    blocks.add(SOAK_BLOCK_EVEN_ORDER + axis, term->readings_only, {term->value, term->standard_uncertainty});
  }
  return {};
}

MaybeUncertainty read_uncertainty_of(const std::uint8_t* payload, std::uint32_t block) {
  const std::uint8_t* at = soak_coupling_block(payload, block);
  if (at == nullptr) return std::nullopt;
  CouplingUncertainty uncertainty;
  const auto numbers = read_floats(at, 9);
  for (std::size_t i = 0; i < 9; ++i) uncertainty.standard[i / 3][i % 3] = numbers[i];
  uncertainty.readings_only = (soak_u32(payload) >> (8U + block) & 1U) != 0;
  return uncertainty;
}

}  // namespace

base::Result<std::optional<Section>> coupling_section(const Calibration& calibration) {
  const auto& misalignment = calibration.misalignment_uncertainty;
  const auto& g_sensitivity = calibration.g_sensitivity_uncertainty;
  auto status = check(misalignment, calibration.accel_misalignment.has_value(), false, "misalignment_uncertainty");
  if (status) status = check(g_sensitivity, calibration.g_sensitivity.has_value(), true, "g_sensitivity_uncertainty");
  Blocks blocks;
  if (misalignment) blocks.add(SOAK_MISALIGNMENT, misalignment->readings_only, entries(*misalignment));
  if (g_sensitivity) blocks.add(SOAK_G_SENSITIVITY, g_sensitivity->readings_only, entries(*g_sensitivity));
  if (status) status = add_even_order(calibration, blocks);
  if (!status) return base::forward_error(status);
  if (blocks.flags == 0) return std::optional<Section>();
  base::ByteWriter out;
  // byte by byte: gcc 12 takes a word into the empty buffer for an overflow
  for (int shift = 0; shift < 32; shift += 8) out.write(static_cast<std::uint8_t>(blocks.flags >> shift));
  write_floats(out, blocks.numbers);
  return std::optional<Section>(Section{SOAK_SECTION_COUPLINGS, false, out.take()});
}

void read_couplings(const std::uint8_t* payload, Calibration& calibration) {
  calibration.misalignment_uncertainty = read_uncertainty_of(payload, SOAK_MISALIGNMENT);
  calibration.g_sensitivity_uncertainty = read_uncertainty_of(payload, SOAK_G_SENSITIVITY);
  for (std::uint32_t axis = 0; axis < 3; ++axis) {
    const std::uint32_t block = SOAK_BLOCK_EVEN_ORDER + axis;
    const std::uint8_t* at = soak_coupling_block(payload, block);
    if (at == nullptr) continue;
    const auto numbers = read_floats(at, 2);
    calibration.even_order[axis] = EvenOrderTerm{numbers[0], numbers[1], (soak_u32(payload) >> (8U + block) & 1U) != 0};
  }
}

}  // namespace soak::calib::file
