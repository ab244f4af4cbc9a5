// SPDX-License-Identifier: Apache-2.0
#include "station/http/daemon.h"

#include <fmt/format.h>
#include <signal.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <iostream>
#include <optional>
#include <string_view>
#include <thread>
#include <utility>

#include "station/access/accounts.h"
#include "station/alarms/alarm_sender.h"
#include "station/config/config_place.h"
#include "station/config/station_config.h"
#include "station/config/unit_type_file.h"
#include "station/http/address.h"
#include "station/http/server.h"
#include "station/http/setup_server.h"
#include "station/http/tls.h"
#include "station/io/data_folder.h"
#include "station/io/host.h"
#include "station/io/service_manager.h"
#include "station/lab/campaign_state.h"
#include "station/lab/engine.h"

namespace soak::station {
namespace {

/// How often a manager that watches is told that the set-up is alive, and an end asked for.
constexpr std::chrono::milliseconds kSetupTurn{200};

/// From its making on, SIGTERM and SIGINT reach no thread but the one that waits for them.
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

  /// No signal reaches what stop_with() was given any more: before that is destroyed.
  void release() {
    if (!waiter_.joinable()) return;
    pthread_kill(waiter_.native_handle(), kQuit);
    waiter_.join();
  }

  /// `stop` is called, by another thread, whenever one of them comes; until release().
  void stop_with(std::function<void()> stop) {
    waiter_ = std::thread([this, stop = std::move(stop)] {
      for (int signal = 0; sigwait(&signals_, &signal) == 0 && signal != kQuit;) stop();
    });
  }

 private:
  static constexpr int kQuit = SIGUSR1;  ///< ends the waiting thread
  sigset_t signals_{};
  std::thread waiter_;
};

/// A data folder that this program has for itself.
struct OwnFolder {
  db::Catalog catalog;
  FolderLock lock;

  /// Makes it where it is new. Refuses (bad_input) one that another soakd has.
  static base::Result<OwnFolder> take(std::string_view data_option) {
    auto catalog = open_catalog(data_option);
    if (!catalog) return base::forward_error(catalog);
    auto lock = FolderLock::take(catalog->data_folder() / "soakd.lock", "soakd");
    if (!lock) return base::forward_error(lock);
    return OwnFolder{*std::move(catalog), *std::move(lock)};
  }
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

/// Refuses (bad_input) where a campaign is under way or can go on: its station was set up, and has lost its file.
/// Nothing but that file says where the chamber is that may be hot or cold.
base::Status may_be_set_up(const ConfigPlace& place, const db::Catalog& catalog) {
  const auto last = catalog.last_campaign();
  if (!last) return base::forward_error(last);
  constexpr std::array kOver = {CampaignState::finished, CampaignState::aborted};
  const auto is_over = [&](CampaignState state) { return (*last)->state == journal_name_of(state); };
  if (!*last || std::ranges::any_of(kOver, is_over)) return {};
  return base::bad_input(
      fmt::format(
          "the configuration is missing, and campaign '{}' is not over: look at the chamber, then bring the file "
          "back, or write it anew with an editor; 'soakd --write-config' prints one to begin with",
          (*last)->name),
      place.file.string());
}

/// The configuration of a station that has none is to be written in the browser: serves that page until it is, or until
/// somebody ends the program; whether it is. `listen` becomes the address that was served, where its port was any.
base::Result<bool> set_up(const std::filesystem::path& file, db::Catalog& catalog, std::string& listen,
                          ServiceManager& manager, StopSignals& signals) {
  auto address = parse_host_port(listen.empty() ? StationConfig().listen : listen);
  if (!address) return base::forward_error(address);
  if (!is_loopback(*address)) {
    return base::bad_input(
        fmt::format("this station is not set up ({} is missing), which is done at the machine itself: leave out "
                    "--listen, or give it 127.0.0.1",
                    file.string()),
        to_text(*address));
  }
  SetupServer server(*address, file, catalog);
  const auto port = server.start();
  if (!port) return base::forward_error(port);
  address->port = *port;
  listen = to_text(*address);
  const std::string page = fmt::format("http://{}/", listen);
  const std::string waiting = fmt::format("not set up yet: {} does that, into {}", page, file.string());
  log_line(waiting);
  std::cout << page << std::endl;
  std::atomic<bool> is_ended = false;
  signals.stop_with([&] { is_ended = true; });
  manager.ready(waiting);
  bool is_written = false;
  while (!is_written && !is_ended) {
    is_written = server.wait_for(kSetupTurn);
    manager.still_alive();
  }
  signals.release();
  return is_written && !is_ended;
}

/// `soakd` with a configuration, until it is asked to stop.
base::Status serve(const StationConfig& config, db::Catalog& catalog, const FolderLock& lock, ServiceManager& manager,
                   StopSignals& signals) {
  const auto listen = parse_host_port(config.listen);
  if (!listen) return base::forward_error(listen);
  std::optional<CertificateFiles> certificate;
  if (is_for_others(config, *listen)) {
    const auto files = certificate_for_others(config, *listen);
    if (!files) return base::forward_error(files);
    certificate = *files;
  }
  auto deliveries = deliveries_of(config.alarms);
  if (!deliveries) return base::forward_error(deliveries);
  const auto engine = Engine::make(config, catalog);
  if (!engine) return base::forward_error(engine);
  AlarmSender alarms(**engine, *std::move(deliveries));
  HttpServer server(**engine, config.listen, config.data, config.allowed_hosts, certificate, &alarms);
  const auto port = server.start();
  if (!port) return base::forward_error(port);
  const std::string address = (certificate ? "https://" : "http://") + to_text({listen->host, *port});
  lock.note_address(address);
  const std::string page = address + "/";
  const std::string serving =
      fmt::format("serving {} from {}, {} slots", page, config.data.string(), config.slots.size());
  log_line(serving);
  std::cout << page << std::endl;
  signals.stop_with([&] {
    const std::string text = "asked to stop: a running campaign is driven to the safe state first";
    log_line(text);
    manager.stopping(text);
    (*engine)->stop();
  });
  manager.ready(serving);
  auto ended = (*engine)->run([&manager] { manager.still_alive(); });
  signals.release();
  alarms.stop();  // before the server waits for a test that is being sent
  server.stop();
  return ended;
}

}  // namespace

base::Status run_daemon(const DaemonOptions& options) {
  share_one_heap();
  std::string listen = options.listen;
  ServiceManager manager;
  StopSignals signals;
  std::optional<OwnFolder> own;
  const auto place = place_of_config(options.config, options.data);
  if (!place) return base::forward_error(place);
  if (place->is_usual && !place->is_there) {
    auto taken = OwnFolder::take(options.data);
    if (!taken) return base::forward_error(taken);
    own.emplace(*std::move(taken));
    if (auto may = may_be_set_up(*place, own->catalog); !may) return may;
    const auto is_set_up = set_up(place->file, own->catalog, listen, manager, signals);
    if (!is_set_up) return base::forward_error(is_set_up);
    if (!*is_set_up) return {};
  }
  auto config = find_station_config(options.config, options.data);
  if (!config) return base::forward_error(config);
  if (!options.listen.empty()) config->listen = listen;
  // What the page shows, what judges a unit here and the programs that are started from here have the same types.
  ::setenv(kUnitTypesVariable, std::filesystem::absolute(config->unit_types).c_str(), 1);
  // A file that was there already may name another folder than the one in which it was found.
  std::error_code unknown;
  if (own && !std::filesystem::equivalent(own->catalog.data_folder(), config->data, unknown)) own.reset();
  if (!own) {
    auto taken = OwnFolder::take(config->data.string());
    if (!taken) return base::forward_error(taken);
    own.emplace(*std::move(taken));
  }
  config->data = own->catalog.data_folder();
  return serve(*config, own->catalog, own->lock, manager, signals);
}

}  // namespace soak::station
