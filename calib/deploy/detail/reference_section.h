// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "base/result.h"
#include "calib/deploy/detail/section.h"
#include "calib/vocabulary/reference.h"

namespace soak::calib::file {

/// Most references that a file carries: beside them, 256 sections hold all else that there can be.
inline constexpr std::size_t kMaxReferences = 160;

/// Section 0x0002 (docs/blob-format.md §4). Refuses what the format cannot carry, naming the reference.
[[nodiscard]] base::Result<Section> reference_section(const ReferenceUse& use);

/// soak_load() does not look into references: this reader checks, and refuses as corrupt.
[[nodiscard]] base::Result<ReferenceUse> read_reference(std::span<const std::uint8_t> payload);

}  // namespace soak::calib::file
