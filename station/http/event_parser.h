// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "station/http/client.h"

namespace soak::station {

/// Takes a text/event-stream apart (WHATWG HTML, 9.2.6), whatever pieces it arrives in. Lines end with LF, as
/// HttpServer writes them.
class EventParser {
 public:
  /// The events that `piece` completes. Comments and events without data yield none.
  [[nodiscard]] std::vector<ServerEvent> take(std::string_view piece);

 private:
  void take_line(std::string_view line, std::vector<ServerEvent>& complete);

  std::string rest_;  ///< of a line that has not ended yet
  ServerEvent event_;
};

}  // namespace soak::station
