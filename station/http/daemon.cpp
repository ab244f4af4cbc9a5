// SPDX-License-Identifier: Apache-2.0
#include "station/http/daemon.h"

#include <fmt/format.h>
#include <signal.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <optional>
#include <string_view>
#include <thread>

#include "station/access/accounts.h"
#include "station/alarms/alarm_sender.h"
#include "station/config/station_config.h"
#include "station/config/unit_type_file.h"
#include "station/http/address.h"
#include "station/http/server.h"
#include "station/http/tls.h"
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

/// Whether others than this machine can ask the station, or are to be known by name.
bool is_for_others(const StationConfig& config, const HostPort& listen) {
  return !is_loopback(listen) || !config.allowed_hosts.empty() || !config.tls_certificate.empty();
}

/// All that a browser may call the station, as far as a certificate can hold it.
std::vector<std::string> certificate_names(const StationConfig& config, const HostPort& listen) {
  std::vector<std::string> names = {"localhost", "127.0.0.1", "::1"};
  const auto add = [&](const std::string& name) {
    const bool everywhere = name == "0.0.0.0" || name == "::";
    const bool holds = name.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789-.:") == std::string::npos;
    if (!everywhere && holds && std::ranges::find(names, name) == names.end()) names.push_back(name);
  };
  add(host_of(to_text(listen)));
  std::ranges::for_each(names_of_machine(), add);
  std::ranges::for_each(config.allowed_hosts, add);
  return names;
}

/// The certificate of a station that others can ask. Refuses (bad_input) one to which nobody has an account.
base::Result<CertificateFiles> certificate_for_others(const StationConfig& config, const HostPort& listen) {
  const auto accounts = read_accounts(config.data);
  if (!accounts) return base::forward_error(accounts);
  if (accounts->empty()) {
    return base::bad_input(
        fmt::format("others than this machine can reach this station, and nobody has an account: 'soak user add NAME "
                    "--role engineer --data {}' makes one (or listen at 127.0.0.1, without allowed_hosts)",
                    config.data.string()),
        to_text(listen));
  }
  if (!config.tls_certificate.empty()) return CertificateFiles{config.tls_certificate, config.tls_key};
  CertificateFiles files = certificate_in(config.data);
  const auto made = make_sure_of_certificate(files, certificate_names(config, listen));
  // A full disk keeps no station from its chamber as long as there is an older one.
  if (!made) log_line(fmt::format("the certificate stays as it was: {}: {}", made.error().where, made.error().message));
  const auto digits = fingerprint(files.certificate);
  if (!digits) return base::forward_error(digits);
  log_line(fmt::format("{} the certificate {}, SHA-256 {}", made && *made ? "made" : "shows",
                       files.certificate.string(), *digits));
  return files;
}

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
  // What the page shows, what judges a unit here and the programs that are started from here have the same types.
  ::setenv(kUnitTypesVariable, std::filesystem::absolute(config->unit_types).c_str(), 1);
  ServiceManager manager;
  StopSignals signals;
  auto catalog = open_catalog(config->data.string());
  if (!catalog) return base::forward_error(catalog);
  const auto lock = FolderLock::take(catalog->data_folder() / "soakd.lock", "soakd");
  if (!lock) return base::forward_error(lock);
  config->data = catalog->data_folder();
  const auto listen = parse_host_port(config->listen);
  if (!listen) return base::forward_error(listen);
  std::optional<CertificateFiles> certificate;
  if (is_for_others(*config, *listen)) {
    const auto files = certificate_for_others(*config, *listen);
    if (!files) return base::forward_error(files);
    certificate = *files;
  }
  auto deliveries = deliveries_of(config->alarms);
  if (!deliveries) return base::forward_error(deliveries);
  const auto engine = Engine::make(*config, *catalog);
  if (!engine) return base::forward_error(engine);
  AlarmSender alarms(**engine, *std::move(deliveries));
  HttpServer server(**engine, config->listen, config->data, config->allowed_hosts, certificate, &alarms);
  const auto port = server.start();
  if (!port) return base::forward_error(port);
  const std::string address = (certificate ? "https://" : "http://") + to_text({listen->host, *port});
  lock->note_address(address);
  const std::string page = address + "/";
  const std::string serving =
      fmt::format("serving {} from {}, {} slots", page, config->data.string(), config->slots.size());
  log_line(serving);
  std::cout << page << std::endl;
  signals.stop_with(**engine, manager);
  manager.ready(serving);
  auto ended = (*engine)->run([&manager] { manager.still_alive(); });
  signals.release();
  alarms.stop();  // before the server waits for a test that is being sent
  server.stop();
  return ended;
}

}  // namespace soak::station
