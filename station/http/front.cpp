// SPDX-License-Identifier: Apache-2.0
#include "station/http/front.h"

#include <cerrno>
#include <chrono>
#include <exception>
#include <system_error>
#include <utility>

#include "station/http/api.h"
#include "station/http/web_files.h"
#include "station/report/html.h"

namespace soak::station {
namespace {

using base::ErrorKind;

constexpr std::chrono::milliseconds kListens{1};

/// The library's own default, SO_REUSEPORT, would let two daemons share one port unnoticed.
void set_socket_options(socket_t socket) {
  const int on = 1;
  ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
}

std::string content_type(std::string_view name) {
  if (name.ends_with(".html")) return "text/html; charset=utf-8";
  if (name.ends_with(".css")) return "text/css; charset=utf-8";
  if (name.ends_with(".svg")) return "image/svg+xml";
  if (name.ends_with(".png")) return "image/png";
  if (name.ends_with(".toml") || name.ends_with(".txt")) return "text/plain; charset=utf-8";
  return "text/javascript; charset=utf-8";
}

void set_security_headers(const httplib::Request& request, httplib::Response& response) {
  response.set_header("Cache-Control", request.path.starts_with(kApiPath) ? "no-store" : "no-cache");
  response.set_header("X-Content-Type-Options", "nosniff");
  response.set_header("Referrer-Policy", "no-referrer");
  response.set_header("Cross-Origin-Resource-Policy", "same-origin");
  response.set_header("Content-Security-Policy",
                      "default-src 'self'; base-uri 'none'; form-action 'self'; frame-ancestors 'none'");
}

/// What the library itself refuses (unknown path, body too long...), as our error document.
void describe_library_error(const httplib::Request& request, httplib::Response& response) {
  if (!response.body.empty()) return;
  base::Error error{ErrorKind::bad_input, "the request cannot be understood", request.path};
  if (response.status == 404) error.message = "this path does not exist, or not for the method " + request.method;
  if (response.status == 413) error.message = "the body is longer than 1 MiB";
  if (response.status >= 500) error.kind = ErrorKind::internal;
  refuse(response, {response.status, std::move(error)});
}

void describe_exception(const httplib::Request& request, httplib::Response& response, std::exception_ptr thrown) {
  std::string message;
  try {
    std::rethrow_exception(std::move(thrown));
  } catch (const std::exception& reason) {
    message = reason.what();
  } catch (...) {
    message = "unexpected failure";
  }
  refuse(response, {500, {ErrorKind::internal, std::move(message), request.path}});
}

}  // namespace

void prepare(BoundedListener& listener) {
  listener.set_socket_options(set_socket_options);
  listener.set_error_handler(httplib::Server::Handler(describe_library_error));
  listener.set_exception_handler(describe_exception);
  listener.set_post_routing_handler(set_security_headers);
}

std::optional<Refusal> refused_by_origin(const httplib::Request& request, bool tls,
                                         const std::vector<std::string>& own_names) {
  const auto stranger = why_refused({request.get_header_value("Host"), header(request, "Origin"), tls}, own_names);
  if (!stranger) return std::nullopt;
  return Refusal{403, {ErrorKind::bad_input, *stranger, "headers"}};
}

std::optional<Refusal> refused_by_body(const httplib::Request& request) {
  // The library counts the length of a body only where it is stated, and unpacks a packed one to any size.
  if (request.has_header("Transfer-Encoding")) {
    return Refusal{411, {ErrorKind::bad_input, "the length of the body must be stated", "Content-Length"}};
  }
  if (request.get_header_value_count("Content-Length") > 1) {
    return Refusal{400, {ErrorKind::bad_input, "the length of the body must be stated once", "Content-Length"}};
  }
  if (request.has_header("Content-Encoding")) {
    return Refusal{415, {ErrorKind::bad_input, "the body must not be compressed", "Content-Encoding"}};
  }
  return std::nullopt;
}

bool wants_page(const httplib::Request& request) {
  return request.get_header_value("Accept").find("text/html") != std::string::npos;
}

void send_refusal_page(httplib::Response& response, const std::string& why, const std::string& own_address) {
  const std::string own = html::escaped(own_address);
  response.set_content(
      "<!doctype html><html lang=\"en\"><title>Soak: not at this address</title><h1>Not at this "
      "address</h1><p>" +
          html::escaped(why) + ".</p><p>The station listens at <a href=\"" + own + "/\">" + own +
          "/</a>. To reach it by another name, write that name into its configuration, as in "
          "<code>allowed_hosts = [\"lab-pc\"]</code>, and start soakd again.</p></html>",
      content_type(".html"));
}

void send_file(httplib::Response& response, std::string_view name) {
  const WebFile* file = find_web_file(name);
  if (file == nullptr) {
    response.status = 404;
    return;
  }
  // Not as content, which the library would pack anew for each request: half a second of a processor for the page.
  response.set_content_provider(
      file->content.size(), content_type(name),
      [content = file->content](std::size_t offset, std::size_t length, httplib::DataSink& sink) {
        return sink.write(content.data() + offset, length);
      });
}

base::Result<int> ListenerThread::start(HostPort& address) {
  errno = 0;
  const int port = address.port == 0 ? listener_.bind_to_any_port(address.host)
                                     : (listener_.bind_to_port(address.host, address.port) ? address.port : -1);
  if (port < 0) {
    const std::string why = errno != 0 ? std::generic_category().message(errno) : "no such address";
    return base::bad_input(
        "cannot listen there: " + why +
            (errno == EADDRINUSE ? " (is another soakd running? --listen takes another address)" : ""),
        to_text(address));
  }
  address.port = port;
  listener_.widen_backlog();
  thread_ = std::thread([this] {
    listener_.listen_after_bind();
    ended_ = true;
  });
  // The library ignores stop() before its loop runs.
  while (!listener_.is_running() && !ended_) std::this_thread::sleep_for(kListens);
  return port;
}

void ListenerThread::stop() {
  if (!thread_.joinable()) return;
  listener_.cut_all();
  listener_.stop();
  thread_.join();
}

}  // namespace soak::station
