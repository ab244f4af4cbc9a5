// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <SQLiteCpp/Column.h>
#include <SQLiteCpp/Statement.h>

#include <concepts>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "base/bytes.h"

/// Values in and out of statements, in the order of their columns. SQLite has no NaN: it is stored as NULL.
namespace soak::db::sqlite {

/// Binds the parameters of a statement one after the other.
class Binder {
 public:
  explicit Binder(SQLite::Statement& statement) : statement_(statement) {}

  Binder& add(std::string_view text) {
    statement_.bind(next_++, std::string(text));
    return *this;
  }
  Binder& add(double value) {
    statement_.bind(next_++, value);
    return *this;
  }
  template <std::integral T>
  Binder& add(T value) {
    statement_.bind(next_++, static_cast<std::int64_t>(value));
    return *this;
  }
  /// `bytes` must live until the statement has run.
  Binder& add(const base::Bytes& bytes) {
    // A null pointer would bind NULL instead of the blob of no bytes.
    static constexpr std::uint8_t kNothing = 0;
    statement_.bindNoCopy(next_++, bytes.empty() ? &kNothing : bytes.data(), static_cast<int>(bytes.size()));
    return *this;
  }
  Binder& add_null() {
    statement_.bind(next_++);
    return *this;
  }
  template <class T>
  Binder& add(const std::optional<T>& value) {
    return value ? add(*value) : add_null();
  }

 private:
  SQLite::Statement& statement_;
  int next_ = 1;
};

/// Binds all of `values` in order.
template <class... Values>
void bind_all(SQLite::Statement& statement, const Values&... values) {
  Binder binder(statement);
  (binder.add(values), ...);
}

/// Reads the columns of the current row one after the other.
class Fields {
 public:
  explicit Fields(SQLite::Statement& statement) : statement_(statement) {}

  std::string text() { return next().getString(); }
  std::int64_t integer() { return next().getInt64(); }
  std::int32_t integer32() { return static_cast<std::int32_t>(next().getInt64()); }
  bool flag() { return next().getInt64() != 0; }

  /// NaN for NULL.
  double real() {
    const SQLite::Column column = next();
    return column.isNull() ? std::numeric_limits<double>::quiet_NaN() : column.getDouble();
  }
  std::optional<double> optional_real() {
    const SQLite::Column column = next();
    return column.isNull() ? std::nullopt : std::optional(column.getDouble());
  }
  std::optional<std::int32_t> optional_integer() {
    const SQLite::Column column = next();
    return column.isNull() ? std::nullopt : std::optional(static_cast<std::int32_t>(column.getInt64()));
  }
  std::optional<std::string> optional_text() {
    const SQLite::Column column = next();
    return column.isNull() ? std::nullopt : std::optional(column.getString());
  }
  /// No bytes for NULL; valid until the statement goes on.
  std::span<const std::uint8_t> blob() {
    const SQLite::Column column = next();
    const auto* first = static_cast<const std::uint8_t*>(column.getBlob());
    if (first == nullptr) return {};
    return {first, static_cast<std::size_t>(column.getBytes())};
  }

 private:
  SQLite::Column next() { return statement_.getColumn(next_++); }

  SQLite::Statement& statement_;
  int next_ = 0;
};

}  // namespace soak::db::sqlite
