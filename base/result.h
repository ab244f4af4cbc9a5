// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <tl/expected.hpp>
#include <utility>

namespace soak::base {

/// Why an operation did not succeed. The values are the exit statuses of the programs.
enum class ErrorKind {
  internal = 1,   ///< none of the kinds below
  bad_input = 2,  ///< the user's input or usage: the message says what would be right
  device = 3,     ///< a device failed or did not answer
  corrupt = 4,    ///< stored data fail their check
  limits = 5,     ///< the unit fails its limits
};

/// A refusal that a user can act on: what is wrong and what would be right, and where.
struct Error {
  ErrorKind kind = ErrorKind::internal;
  std::string message;
  std::string where;  ///< file, line, column, sensor...: as precise as known, may be empty
};

/// A value, or the reason why there is none.
template <class T>
using Result = tl::expected<T, Error>;

/// Success, or the reason why not.
using Status = Result<void>;

inline tl::unexpected<Error> fail(ErrorKind kind, std::string message, std::string where = {}) {
  return tl::unexpected<Error>(Error{kind, std::move(message), std::move(where)});
}

inline tl::unexpected<Error> bad_input(std::string message, std::string where = {}) {
  return fail(ErrorKind::bad_input, std::move(message), std::move(where));
}

inline tl::unexpected<Error> corrupt(std::string message, std::string where = {}) {
  return fail(ErrorKind::corrupt, std::move(message), std::move(where));
}

/// Passes the error of one result on as that of another.
template <class T>
tl::unexpected<Error> forward_error(const Result<T>& result) {
  return tl::unexpected<Error>(result.error());
}

}  // namespace soak::base
