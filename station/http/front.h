// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <httplib.h>

#include <atomic>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "base/result.h"
#include "station/http/address.h"
#include "station/http/answers.h"
#include "station/http/connections.h"

/// What a server of the station does alike, whether the station works or is set up.
namespace soak::station {

/// Errors as our documents, and the headers that keep other pages out (docs/access.md).
void prepare(BoundedListener& listener);

/// Why a request is refused that a page of another site has made a browser send: why_refused(), with status 403.
[[nodiscard]] std::optional<Refusal> refused_by_origin(const httplib::Request& request, bool tls,
                                                       const std::vector<std::string>& own_names);

/// Why a request is refused whose body does not say its length, or is packed: before anything of it is read.
[[nodiscard]] std::optional<Refusal> refused_by_body(const httplib::Request& request);

/// Whether somebody looks at the answer in a browser.
[[nodiscard]] bool wants_page(const httplib::Request& request);

/// What somebody reads who has typed a name that this station does not go by. `own_address`: "http://127.0.0.1:8088".
void send_refusal_page(httplib::Response& response, const std::string& why, const std::string& own_address);

/// The file of web/ with that name; 404 where there is none.
void send_file(httplib::Response& response, std::string_view name);

/// The thread in which a listener answers.
class ListenerThread {
 public:
  /// The listener must outlive it.
  explicit ListenerThread(BoundedListener& listener) : listener_(listener) {}
  ~ListenerThread() { stop(); }
  ListenerThread(const ListenerThread&) = delete;
  ListenerThread& operator=(const ListenerThread&) = delete;

  /// Listens; the port, which goes into `address`, too. Refuses (bad_input) an address that is not one or not free.
  [[nodiscard]] base::Result<int> start(HostPort& address);
  /// Cuts off what is still open and lets go of the address. Waits for what is being carried out.
  void stop();

 private:
  BoundedListener& listener_;
  std::atomic<bool> ended_ = false;
  std::thread thread_;
};

}  // namespace soak::station
