// SPDX-License-Identifier: Apache-2.0
#include "station/http/client.h"

#include <httplib.h>
#include <pthread.h>

#include <chrono>
#include <condition_variable>
#include <csignal>
#include <ctime>
#include <deque>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <thread>
#include <utility>

#include "station/http/tls.h"

namespace soak::station {
namespace {

using base::ErrorKind;
using nlohmann::json;

constexpr int kConnectSeconds = 5;
constexpr int kSilenceSeconds = 25;  // a stream says something every ten seconds
constexpr std::chrono::milliseconds kKeepOnEvery{100};

std::string text_of(const StationEntry& entry) { return (entry.tls ? "https://" : "") + to_text(entry.address); }

/// OpenSSL sends without MSG_NOSIGNAL: where the connection has gone, its farewell would end the program. Held back in
/// this thread alone and for as long as this object lives: output into a closed pipe ends the program as ever.
class HoldBackSigpipe {
 public:
  HoldBackSigpipe() {
    ::sigemptyset(&pipe_);
    ::sigaddset(&pipe_, SIGPIPE);
    ::pthread_sigmask(SIG_BLOCK, &pipe_, &before_);
  }
  HoldBackSigpipe(const HoldBackSigpipe&) = delete;
  HoldBackSigpipe& operator=(const HoldBackSigpipe&) = delete;
  ~HoldBackSigpipe() {
    const timespec at_once{};
    ::sigtimedwait(&pipe_, nullptr, &at_once);
    ::pthread_sigmask(SIG_SETMASK, &before_, nullptr);
  }

 private:
  sigset_t pipe_{};
  sigset_t before_{};
};

/// A client of the library, with the station's certificate and the token.
base::Result<std::unique_ptr<httplib::ClientImpl>> make_client(const StationEntry& entry) {
  const HostPort& at = entry.address;
  std::unique_ptr<httplib::ClientImpl> client;
  if (entry.tls) {
    auto secure = std::make_unique<httplib::SSLClient>(at.host, at.port);
    // By names and authorities: one that is given is compared instead.
    if (entry.any_certificate || !entry.certificate.empty()) secure->enable_server_certificate_verification(false);
    if (!entry.any_certificate && !entry.certificate.empty()) {
      if (auto trusts = trust_only(secure->ssl_context(), entry.certificate); !trusts)
        return base::forward_error(trusts);
    }
    client = std::move(secure);
  } else {
    client = std::make_unique<httplib::ClientImpl>(at.host, at.port);
  }
  if (!entry.token.empty()) client->set_bearer_token_auth(entry.token);
  client->set_connection_timeout(kConnectSeconds);
  return client;
}

base::Error unreachable(const StationEntry& entry, httplib::Error reason) {
  const std::string where = text_of(entry);
  const bool untrusted = reason == httplib::Error::SSLConnection || reason == httplib::Error::SSLServerVerification ||
                         reason == httplib::Error::SSLLoadingCerts;
  if (untrusted) {
    return {ErrorKind::device,
            "what answers there does not speak TLS or does not show a certificate that is trusted: give the station's "
            "own (soakd.crt of its data folder) with --certificate FILE or $SOAK_CERTIFICATE",
            where};
  }
  if (reason == httplib::Error::Connection || reason == httplib::Error::ConnectionTimeout) {
    return {ErrorKind::device,
            "no soakd answers there: start one with 'soakd --config FILE --listen " + where +
                "', or name another with --station HOST:PORT or $SOAK_STATION",
            where};
  }
  return {ErrorKind::device, "the connection to soakd broke (" + httplib::to_string(reason) + ")", where};
}

/// The error that an answer other than 2xx describes.
base::Error refusal_of(const httplib::Response& response, const StationEntry& entry) {
  const json document = json::parse(response.body, nullptr, false);
  const json error = document.is_object() ? document.value("error", json()) : json();
  const json code = error.is_object() ? error.value("code", json()) : json();
  if (response.status == 400 && response.body.find("HTTPS only") != std::string::npos) {
    return {ErrorKind::bad_input, "this soakd speaks TLS: write https:// before the address", text_of(entry)};
  }
  if (!code.is_number_integer() || code < 1 || code > 5 || !error.value("message", json()).is_string()) {
    return {ErrorKind::device,
            "the program that answers there (HTTP status " + std::to_string(response.status) + ") is not soakd",
            text_of(entry)};
  }
  return {static_cast<ErrorKind>(code.get<int>()), error["message"].get<std::string>(),
          error.value("where", std::string())};
}

base::Result<json> answer_document(const httplib::Result& result, const StationEntry& entry) {
  if (!result) return tl::unexpected(unreachable(entry, result.error()));
  if (result->status != 200) return tl::unexpected(refusal_of(*result, entry));
  json document = json::parse(result->body, nullptr, false);
  if (document.is_discarded()) {
    return base::fail(ErrorKind::device, "the program that answers there is not soakd", text_of(entry));
  }
  return document;
}

/// One stream, read by a thread of its own so that the reader can leave at any time.
class StreamReader {
 public:
  StreamReader(const StationEntry& entry, std::unique_ptr<httplib::ClientImpl> client)
      : entry_(entry), client_(std::move(client)) {
    client_->set_read_timeout(kSilenceSeconds);
    thread_ = std::thread([this] { run(); });
  }

  ~StreamReader() {
    const HoldBackSigpipe held_back;
    std::unique_lock lock(mutex_);
    leaving_ = true;
    // stop() has no effect on a request that is just about to begin: it is repeated.
    while (!ended_) {
      client_->stop();
      changed_.wait_for(lock, kKeepOnEvery);
    }
    lock.unlock();
    thread_.join();
    client_.reset();
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
    const HoldBackSigpipe held_back;
    std::string error_body;
    int status = 0;
    const auto result = client_->Get(
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
      ended_ = refusal_of(response, entry_);
    } else {
      ended_ = result ? base::Error{ErrorKind::device, "soakd ended the stream of events", text_of(entry_)}
                      : unreachable(entry_, result.error());
    }
    changed_.notify_all();
  }

  bool add(std::string_view piece) {
    const std::lock_guard lock(mutex_);
    for (ServerEvent& event : parser_.take(piece)) events_.push_back(std::move(event));
    changed_.notify_all();
    return !leaving_;
  }

  const StationEntry entry_;
  std::unique_ptr<httplib::ClientImpl> client_;
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
  const HoldBackSigpipe held_back;
  const auto client = make_client(entry_);
  if (!client) return base::forward_error(client);
  (*client)->set_read_timeout(answer_s_);
  return answer_document((*client)->Get(kApiPath + path), entry_);
}

base::Result<json> Client::command(const std::string& command, const json& body) const {
  const HoldBackSigpipe held_back;
  const auto client = make_client(entry_);
  if (!client) return base::forward_error(client);
  (*client)->set_read_timeout(answer_s_);
  const std::string text = body.dump(-1, ' ', false, json::error_handler_t::replace);
  return answer_document((*client)->Post(kApiPath + ("campaign/" + command), text, "application/json"), entry_);
}

base::Status Client::follow(const std::function<bool(const ServerEvent&)>& on_event,
                            const std::function<bool()>& keep_on) const {
  auto client = make_client(entry_);
  if (!client) return base::forward_error(client);
  StreamReader reader(entry_, *std::move(client));
  while (keep_on()) {
    for (const ServerEvent& event : reader.take()) {
      if (!on_event(event)) return {};
    }
    if (const auto error = reader.end()) return tl::unexpected(*error);
  }
  return {};
}

}  // namespace soak::station
