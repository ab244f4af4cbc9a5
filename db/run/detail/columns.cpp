// SPDX-License-Identifier: Apache-2.0
#include "db/run/detail/columns.h"

#include <algorithm>
#include <cstddef>

namespace soak::db::run {
namespace {

std::ptrdiff_t signed_of(std::size_t count) { return static_cast<std::ptrdiff_t>(count); }

bool all_present(const Column& column, std::size_t first, std::size_t count) {
  if (column.present.empty()) return true;
  const auto begin = column.present.begin() + signed_of(first);
  return std::none_of(begin, begin + signed_of(count), [](std::uint8_t present) { return present == 0; });
}

}  // namespace

void append_rows(Column& to, const Column& from, std::size_t first, std::size_t count) {
  const std::size_t size = size_of(from.type);
  const std::size_t rows_before = to.rows();
  const auto raw = from.raw.begin() + signed_of(first * size);
  to.raw.insert(to.raw.end(), raw, raw + signed_of(count * size));
  const bool complete = all_present(from, first, count);
  if (complete && to.present.empty()) return;
  to.present.resize(rows_before, 1);
  to.present.resize(rows_before + count, 1);
  if (complete) return;
  for (std::size_t row = 0; row < count; ++row) {
    if (from.present[first + row] != 0) continue;
    to.present[rows_before + row] = 0;
    std::fill_n(to.raw.begin() + signed_of((rows_before + row) * size), size, std::uint8_t{0});
  }
}

Column rows_of(const Column& column, std::size_t first, std::size_t count) {
  Column part{column.type, {}, {}};
  append_rows(part, column, first, count);
  return part;
}

void drop_first_rows(Column& column, std::size_t count) {
  column.raw.erase(column.raw.begin(), column.raw.begin() + signed_of(count * size_of(column.type)));
  if (!column.present.empty()) {
    column.present.erase(column.present.begin(), column.present.begin() + signed_of(count));
  }
}

}  // namespace soak::db::run
