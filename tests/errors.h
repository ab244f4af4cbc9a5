// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <initializer_list>
#include <string>
#include <string_view>

#include "base/result.h"

/// Errors are judged by their kind, their place and the objects that they name; the wording is free. Found by their
/// arguments, in every namespace.
namespace soak::base {

/// Whether a text holds each of these.
inline ::testing::AssertionResult mentions(std::string_view text, std::initializer_list<std::string_view> objects) {
  for (const std::string_view object : objects) {
    if (text.find(object) == std::string_view::npos) {
      return ::testing::AssertionFailure() << "\"" << text << "\" does not name " << object;
    }
  }
  return ::testing::AssertionSuccess();
}

/// Whether a text holds these one after the other: the mistakes of a file are told in the order of its lines.
inline ::testing::AssertionResult mentions_in_order(std::string_view text,
                                                    std::initializer_list<std::string_view> objects) {
  std::size_t from = 0;
  for (const std::string_view object : objects) {
    const std::size_t at = text.find(object, from);
    if (at == std::string_view::npos) {
      return ::testing::AssertionFailure() << "\"" << text << "\" does not name " << object << " in its turn";
    }
    from = at + object.size();
  }
  return ::testing::AssertionSuccess();
}

/// Whether an error names each of these objects in its place or its message: a key, a file, a serial number, a value.
inline ::testing::AssertionResult names(const Error& error, std::initializer_list<std::string_view> objects) {
  return mentions(error.where + ": " + error.message, objects);
}

/// Whether a text has such a part.
inline bool holds(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

/// Whether an operation failed in this way, and the error names these objects.
template <class T>
::testing::AssertionResult fails(const Result<T>& result, ErrorKind kind,
                                 std::initializer_list<std::string_view> objects = {}) {
  if (result) return ::testing::AssertionFailure() << "it succeeded";
  if (result.error().kind != kind) {
    return ::testing::AssertionFailure() << "another kind of error: " << static_cast<int>(result.error().kind) << " ("
                                         << result.error().message << ")";
  }
  return names(result.error(), objects);
}

template <class T>
::testing::AssertionResult is_bad_input(const Result<T>& result, std::initializer_list<std::string_view> objects = {}) {
  return fails(result, ErrorKind::bad_input, objects);
}

template <class T>
::testing::AssertionResult is_device_error(const Result<T>& result,
                                           std::initializer_list<std::string_view> objects = {}) {
  return fails(result, ErrorKind::device, objects);
}

}  // namespace soak::base
