// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace soak::fuzz {

using Input = std::span<const std::uint8_t>;

/// The entry functions. Each feeds one input to a reader and ends the program (require()) where a promise of the reader
/// does not hold; returns whether the reader accepted it. libfuzzer/entry.cpp hands them to libFuzzer, corpus_test.cpp
/// runs them over the corpus.

/// A calibration file, as it is and once more with magic, size field and CRC made right: the runtime as C and decode().
bool runtime_load(Input input);

/// A recording, or a columns map and a recording with a line "----" between them.
bool csv_recording(Input input);

/// A TOML text, read as a procedure and as a columns map.
bool procedure(Input input);

/// A TOML text, read as the map of a controller.
bool controller_map(Input input);

/// A line that a chamber might answer, read as numbers, as words and as a refusal.
bool text_answer(Input input);

/// Bytes of a unit: frames of Xbus, one MTData2 message's data, packets of an AHRS400, messages of a VectorNav.
bool xbus(Input input);
bool mt_data2(Input input);
bool ahrs400(Input input);
bool vectornav(Input input);

/// Prints what was promised and aborts unless it holds.
void require(bool holds, const char* promise);

inline std::string_view as_text(Input input) { return {reinterpret_cast<const char*>(input.data()), input.size()}; }

}  // namespace soak::fuzz
