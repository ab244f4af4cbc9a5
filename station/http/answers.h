// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <httplib.h>

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "base/result.h"

/// Answers of the interface in the library's terms.
namespace soak::station {

/// Why a request is refused.
struct Refusal {
  int status = 0;  ///< of HTTP
  base::Error error;
};

/// The error document, with that status.
void refuse(httplib::Response& response, const Refusal& refusal);

/// The document, or the error with the status of its kind.
void answer(httplib::Response& response, const base::Result<nlohmann::json>& result);

/// A header's value; nothing where it is absent.
[[nodiscard]] std::optional<std::string> header(const httplib::Request& request, const char* name);

/// Whether the body says that it is JSON.
[[nodiscard]] bool is_json(const httplib::Request& request);

}  // namespace soak::station
