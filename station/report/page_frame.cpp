// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "station/report/html.h"
#include "station/report/page_parts.h"
#include "station/report/style.h"

namespace soak::station {
namespace {

constexpr std::string_view kSimulatedBar =
    "<div class=\"simulated-bar\" role=\"note\">SIMULATED DATA: not measured on a real unit</div>\n"
    "<div class=\"watermark\" aria-hidden=\"true\">SIMULATED</div>\n";

}  // namespace

std::string page_frame(std::string_view title, std::string_view body, std::string_view software,
                       const nlohmann::json& created_utc_s, bool simulated) {
  return fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src 'unsafe-inline'; "
      "img-src data:\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<link rel=\"icon\" "
      "href=\"data:,\">\n<title>{}</title>\n<style>{}</style>\n</head>\n<body>\n{}<main>\n{}<footer>{}, {}</footer>\n"
      "</main>\n</body>\n</html>\n",
      html::escaped(title), report_style(), simulated ? kSimulatedBar : "", body, html::escaped(software),
      html::date_time(created_utc_s));
}

}  // namespace soak::station
