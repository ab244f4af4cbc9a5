// SPDX-License-Identifier: Apache-2.0
#include "station/io/log.h"

#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

namespace soak::station {

void log_line(const std::string& text) {
  static const auto logger = [] {
    auto made = spdlog::stderr_logger_mt("soakd");
    made->set_pattern("%Y-%m-%dT%H:%M:%S.%e%z %v");
    made->flush_on(spdlog::level::info);
    return made;
  }();
  logger->info("{}", text);
}

}  // namespace soak::station
