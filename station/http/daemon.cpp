// SPDX-License-Identifier: Apache-2.0
#include "station/http/daemon.h"

#include <fmt/format.h>
#include <signal.h>

#include <iostream>
#include <string_view>
#include <thread>

#include "station/config/station_config.h"
#include "station/config/unit_type_file.h"
#include "station/http/address.h"
#include "station/http/server.h"
#include "station/http/web_files.h"
#include "station/io/data_folder.h"
#include "station/io/host.h"
#include "station/io/service_manager.h"
#include "station/lab/engine.h"

namespace soak::station {
namespace {

/// From its making on, SIGTERM and SIGINT reach no thread but the one that waits for them and stops the engine.
class StopSignals {
 public:
  StopSignals() {
    sigemptyset(&signals_);
    for (const int signal : {SIGTERM, SIGINT, kQuit}) sigaddset(&signals_, signal);
    pthread_sigmask(SIG_BLOCK, &signals_, nullptr);
    // A connection that the peer has closed, a file that grows too large: errors of the write, not our end.
    for (const int signal : {SIGPIPE, SIGXFSZ}) ::signal(signal, SIG_IGN);
  }
  StopSignals(const StopSignals&) = delete;
  StopSignals& operator=(const StopSignals&) = delete;
  ~StopSignals() { release(); }

  /// No signal reaches the engine any more: before it is destroyed.
  void release() {
    if (!waiter_.joinable()) return;
    pthread_kill(waiter_.native_handle(), kQuit);
    waiter_.join();
  }

  void stop_with(Engine& engine, const ServiceManager& manager) {
    waiter_ = std::thread([this, &engine, &manager] {
      for (int signal = 0; sigwait(&signals_, &signal) == 0 && signal != kQuit;) {
        const std::string text = "asked to stop: a running campaign is driven to the safe state first";
        log_line(text);
        manager.stopping(text);
        engine.stop();
      }
    });
  }

 private:
  static constexpr int kQuit = SIGUSR1;  ///< ends the waiting thread
  sigset_t signals_{};
  std::thread waiter_;
};

}  // namespace

std::string config_template() {
  constexpr std::string_view kPlace = "@procedures@";
  const std::string folder = default_unit_type_folder().parent_path().string();
  std::string text(find_web_file("station.toml")->content);
  for (std::size_t at = text.find(kPlace); at != std::string::npos; at = text.find(kPlace, at + folder.size())) {
    text.replace(at, kPlace.size(), folder);
  }
  return text;
}

base::Status run_daemon(const DaemonOptions& options) {
  share_one_heap();
  auto config = find_station_config(options.config, options.data);
  if (!config) return base::forward_error(config);
  if (!options.listen.empty()) config->listen = options.listen;
  ServiceManager manager;
  StopSignals signals;
  auto catalog = open_catalog(config->data.string());
  if (!catalog) return base::forward_error(catalog);
  const auto lock = FolderLock::take(catalog->data_folder() / "soakd.lock", "soakd");
  if (!lock) return base::forward_error(lock);
  const auto engine = Engine::make(*config, *catalog);
  if (!engine) return base::forward_error(engine);
  HttpServer server(**engine, config->listen, catalog->data_folder(), config->allowed_hosts);
  const auto port = server.start();
  if (!port) return base::forward_error(port);
  const std::string address = to_text({parse_host_port(config->listen)->host, *port});
  lock->note_address(address);
  const std::string page = "http://" + address + "/";
  const std::string serving =
      fmt::format("serving {} from {}, {} slots", page, catalog->data_folder().string(), config->slots.size());
  log_line(serving);
  std::cout << page << std::endl;
  signals.stop_with(**engine, manager);
  manager.ready(serving);
  auto ended = (*engine)->run([&manager] { manager.still_alive(); });
  signals.release();
  server.stop();
  return ended;
}

}  // namespace soak::station
