// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "db/run/sample.h"

namespace soak::db::run {

/// Appends rows `first` ... `first + count - 1` of `from` to `to`, which has the same type. Bytes of absent rows become
/// zero; `to.present` stays empty as long as all rows are present.
void append_rows(Column& to, const Column& from, std::size_t first, std::size_t count);

/// Rows of `column` as a column of their own.
[[nodiscard]] Column rows_of(const Column& column, std::size_t first, std::size_t count);

/// Removes the first `count` rows.
void drop_first_rows(Column& column, std::size_t count);

}  // namespace soak::db::run
