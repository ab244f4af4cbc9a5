// SPDX-License-Identifier: Apache-2.0
#include "station/http/event_parser.h"

#include <utility>

namespace soak::station {

std::vector<ServerEvent> EventParser::take(std::string_view piece) {
  std::vector<ServerEvent> complete;
  rest_ += piece;
  std::size_t begin = 0;
  for (std::size_t end = 0; (end = rest_.find('\n', begin)) != std::string::npos; begin = end + 1) {
    take_line(std::string_view(rest_).substr(begin, end - begin), complete);
  }
  rest_.erase(0, begin);
  return complete;
}

void EventParser::take_line(std::string_view line, std::vector<ServerEvent>& complete) {
  if (line.empty()) {
    if (!event_.data.empty()) complete.push_back(event_);
    event_ = {};
    return;
  }
  const std::size_t colon = line.find(':');
  const std::string_view field = line.substr(0, colon);
  std::string_view value = colon == std::string_view::npos ? std::string_view() : line.substr(colon + 1);
  if (value.starts_with(' ')) value.remove_prefix(1);
  if (field == "event") event_.type = value;
  if (field == "data") event_.data += (event_.data.empty() ? "" : "\n") + std::string(value);
}

}  // namespace soak::station
