// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <filesystem>
#include <memory>
#include <string>

#include "base/result.h"
#include "db/catalog/catalog.h"
#include "station/http/address.h"

namespace soak::station {

/// The page on which a station is set up that has no configuration yet, and its interface (docs/http-api.md, "Before a
/// station is set up"). It only reads from chamber and fixture, and tells units what to send. There are no accounts
/// yet: it is for a loopback address.
class SetupServer {
 public:
  /// `file`: where the configuration is to be. `catalog`, whose event log tells who has written it, must outlive the
  /// server.
  SetupServer(HostPort listen, std::filesystem::path file, db::Catalog& catalog);
  ~SetupServer();

  /// Listens and answers from threads of its own; the port. Refuses an address that is not free (bad_input).
  [[nodiscard]] base::Result<int> start();
  /// Waits until the configuration is written and whoever has asked for it has the answer, but no longer than that;
  /// whether it is.
  [[nodiscard]] bool wait_for(std::chrono::milliseconds longest);

 private:
  struct Running;
  std::unique_ptr<Running> running_;
};

}  // namespace soak::station
