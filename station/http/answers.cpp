// SPDX-License-Identifier: Apache-2.0
#include "station/http/answers.h"

#include <nlohmann/json.hpp>

#include "station/http/api.h"

namespace soak::station {
namespace {

/// With a parameter behind it, since the library packs what is exactly application/json with Brotli at its highest
/// quality, which costs a second of processor time for an answer of 600 kB.
constexpr const char* kJson = "application/json; charset=utf-8";

}  // namespace

void refuse(httplib::Response& response, const Refusal& refusal) {
  response.status = refusal.status;
  response.set_content(error_text(refusal.error), kJson);
}

void answer(httplib::Response& response, const base::Result<nlohmann::json>& result) {
  if (!result) return refuse(response, {http_status(result.error()), result.error()});
  response.set_content(compact(*result), kJson);
}

std::optional<std::string> header(const httplib::Request& request, const char* name) {
  if (!request.has_header(name)) return std::nullopt;
  return request.get_header_value(name);
}

bool is_json(const httplib::Request& request) {
  const std::string type = request.get_header_value("Content-Type");
  return type.substr(0, type.find_first_of("; ")) == "application/json";
}

}  // namespace soak::station
