// SPDX-License-Identifier: Apache-2.0
#include "station/http/client.h"

#include <httplib.h>

#include <chrono>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <nlohmann/json.hpp>
#include <thread>
#include <utility>

namespace soak::station {
namespace {

using base::ErrorKind;
using nlohmann::json;

constexpr int kConnectSeconds = 5;
constexpr int kSilenceSeconds = 25;  // a stream says something every ten seconds
constexpr std::chrono::milliseconds kKeepOnEvery{100};

base::Error unreachable(const HostPort& address, httplib::Error reason) {
  const std::string where = to_text(address);
  if (reason == httplib::Error::Connection || reason == httplib::Error::ConnectionTimeout) {
    return {ErrorKind::device,
            "no soakd answers there: start one with 'soakd --config FILE --listen " + where +
                "', or name another with --station HOST:PORT or $SOAK_STATION",
            where};
  }
  return {ErrorKind::device, "the connection to soakd broke (" + httplib::to_string(reason) + ")", where};
}

/// The error that an answer other than 2xx describes.
base::Error refusal_of(const httplib::Response& response, const HostPort& address) {
  const json document = json::parse(response.body, nullptr, false);
  const json error = document.is_object() ? document.value("error", json()) : json();
  const json code = error.is_object() ? error.value("code", json()) : json();
  if (!code.is_number_integer() || code < 1 || code > 5 || !error.value("message", json()).is_string()) {
    return {ErrorKind::device,
            "the program that answers there (HTTP status " + std::to_string(response.status) + ") is not soakd",
            to_text(address)};
  }
  return {static_cast<ErrorKind>(code.get<int>()), error["message"].get<std::string>(),
          error.value("where", std::string())};
}

base::Result<json> answer_document(const httplib::Result& result, const HostPort& address) {
  if (!result) return tl::unexpected(unreachable(address, result.error()));
  if (result->status != 200) return tl::unexpected(refusal_of(*result, address));
  json document = json::parse(result->body, nullptr, false);
  if (document.is_discarded()) {
    return base::fail(ErrorKind::device, "the program that answers there is not soakd", to_text(address));
  }
  return document;
}

/// One stream, read by a thread of its own so that the reader can leave at any time.
class StreamReader {
 public:
  explicit StreamReader(const HostPort& address) : address_(address), client_(address.host, address.port) {
    client_.set_connection_timeout(kConnectSeconds);
    client_.set_read_timeout(kSilenceSeconds);
    thread_ = std::thread([this] { run(); });
  }

  ~StreamReader() {
    std::unique_lock lock(mutex_);
    leaving_ = true;
    // stop() has no effect on a request that is just about to begin: it is repeated.
    while (!ended_) {
      client_.stop();
      changed_.wait_for(lock, kKeepOnEvery);
    }
    lock.unlock();
    thread_.join();
  }

  /// Waits for events, not for long.
  std::deque<ServerEvent> take() {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, kKeepOnEvery, [this] { return !events_.empty() || ended_; });
    return std::exchange(events_, {});
  }

  /// Why the stream has ended; nothing while it has not, or there are events to take.
  std::optional<base::Error> end() {
    const std::lock_guard lock(mutex_);
    return events_.empty() ? ended_ : std::nullopt;
  }

 private:
  void run() {
    std::string error_body;
    int status = 0;
    const auto result = client_.Get(
        std::string(kApiPath) + "events",
        [&](const httplib::Response& response) {
          status = response.status;
          return true;
        },
        [&](const char* data, std::size_t size) {
          if (status != 200) error_body.append(data, size);
          return status != 200 || add(std::string_view(data, size));
        });
    const std::lock_guard lock(mutex_);
    if (result && result->status != 200) {
      httplib::Response response = *result;
      response.body = error_body;
      ended_ = refusal_of(response, address_);
    } else {
      ended_ = result ? base::Error{ErrorKind::device, "soakd ended the stream of events", to_text(address_)}
                      : unreachable(address_, result.error());
    }
    changed_.notify_all();
  }

  bool add(std::string_view piece) {
    const std::lock_guard lock(mutex_);
    for (ServerEvent& event : parser_.take(piece)) events_.push_back(std::move(event));
    changed_.notify_all();
    return !leaving_;
  }

  const HostPort address_;
  httplib::Client client_;
  EventParser parser_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<ServerEvent> events_;
  std::optional<base::Error> ended_;
  bool leaving_ = false;
  std::thread thread_;
};

}  // namespace

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

base::Result<json> Client::get(const std::string& path) const {
  httplib::Client client(address_.host, address_.port);
  client.set_connection_timeout(kConnectSeconds);
  client.set_read_timeout(answer_s_);
  return answer_document(client.Get(kApiPath + path), address_);
}

base::Result<json> Client::command(const std::string& command, const json& body) const {
  httplib::Client client(address_.host, address_.port);
  client.set_connection_timeout(kConnectSeconds);
  client.set_read_timeout(answer_s_);
  const std::string text = body.dump(-1, ' ', false, json::error_handler_t::replace);
  return answer_document(client.Post(kApiPath + ("campaign/" + command), text, "application/json"), address_);
}

base::Status Client::follow(const std::function<bool(const ServerEvent&)>& on_event,
                            const std::function<bool()>& keep_on) const {
  StreamReader reader(address_);
  while (keep_on()) {
    for (const ServerEvent& event : reader.take()) {
      if (!on_event(event)) return {};
    }
    if (const auto error = reader.end()) return tl::unexpected(*error);
  }
  return {};
}

}  // namespace soak::station
