// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <memory>
#include <mutex>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <thread>
#include <vector>

#include "base/result.h"
#include "station/alarms/alarm_book.h"
#include "station/alarms/courier.h"
#include "station/lab/station_service.h"

namespace soak::station {

/// Tells people of the station's alarms. A thread of its own looks at the status twice a second, and each way has
/// another one (Courier): no server, however slow, delays the engine. What was sent and what was not is in the event
/// log. Any thread may call.
class AlarmSender {
 public:
  /// Without deliveries nobody is told and there are no threads. The laboratory must outlive it.
  AlarmSender(StationService& lab, std::vector<std::unique_ptr<Delivery>> deliveries);
  AlarmSender(const AlarmSender&) = delete;
  AlarmSender& operator=(const AlarmSender&) = delete;
  ~AlarmSender();

  /// Breaks off what is being sent; nothing is sent any more.
  void stop();
  /// GET /api/v1/alarms: docs/http-api.md.
  [[nodiscard]] nlohmann::json document() const;
  /// Sends a message over every way, at once, and answers with what became of each. Refuses (bad_input) where there is
  /// no way, and (internal, where == kBusy) beside another one that is being sent.
  [[nodiscard]] base::Result<nlohmann::json> test(const std::string& user);

 private:
  void watch();
  void look();
  void tell(const AlarmBook::Entry& entry, const std::string& campaign);

  StationService& lab_;
  std::vector<std::unique_ptr<Courier>> couriers_;
  EngineTurns turns_;
  AlarmBook book_;
  std::mutex test_;
  std::mutex mutex_;
  std::condition_variable changed_;
  bool quits_ = false;
  std::thread thread_;
};

}  // namespace soak::station
