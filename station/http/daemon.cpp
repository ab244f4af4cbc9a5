// SPDX-License-Identifier: Apache-2.0
#include "station/http/daemon.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <optional>
#include <string_view>
#include <utility>

#include "settings/reader.h"
#include "station/access/accounts.h"
#include "station/alarms/alarm_sender.h"
#include "station/config/config_place.h"
#include "station/config/station_config.h"
#include "station/config/unit_type_file.h"
#include "station/http/address.h"
#include "station/http/server.h"
#include "station/http/settings_desk.h"
#include "station/http/setup_server.h"
#include "station/http/stop_signals.h"
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

/// What serve() needs of the program around it.
struct Surroundings {
  OwnFolder& own;
  ServiceManager& manager;
  StopSignals& signals;
  SettingsDesk& desk;
};

/// A configuration, and the text of its file.
struct Settings {
  StationConfig config;
  std::string text;
};

/// `soakd` with a configuration, until it is asked to stop, or to begin anew with other settings; whether it is the
/// latter. `listen` becomes the address that is served.
base::Result<bool> serve(const Settings& served, std::string& listen, const Surroundings& around) {
  const StationConfig& config = served.config;
  const auto address = parse_host_port(config.listen);
  if (!address) return base::forward_error(address);
  std::optional<CertificateFiles> certificate;
  if (is_for_others(config, *address)) {
    const auto files = certificate_for_others(config, *address);
    if (!files) return base::forward_error(files);
    certificate = *files;
  }
  auto deliveries = deliveries_of(config.alarms);
  if (!deliveries) return base::forward_error(deliveries);
  const auto engine = Engine::make(config, around.own.catalog);
  if (!engine) return base::forward_error(engine);
  AlarmSender alarms(**engine, *std::move(deliveries));
  HttpServer server(**engine, config.listen, config.data, config.allowed_hosts, certificate, &alarms, &around.desk);
  around.desk.open(
      {[&] { return (*engine)->hold_for_settings(); }, [&] { (*engine)->end_hold(); }, [&] { (*engine)->stop(); },
       [&](const std::string& text, const std::string& user) {
         (*engine)->note("station_changed", config.file, text, user);
       }},
      served.text);
  const auto port = server.start();
  if (!port) return base::forward_error(port);
  listen = to_text({address->host, *port});
  const std::string url = (certificate ? "https://" : "http://") + listen;
  around.own.lock.note_address(url);
  const std::string page = url + "/";
  const std::string serving =
      fmt::format("serving {} from {}, {} slots", page, config.data.string(), config.slots.size());
  log_line(serving);
  std::cout << page << std::endl;
  around.desk.serves();
  std::atomic<bool> is_ended = false;
  around.signals.stop_with([&] {
    const std::string text = "asked to stop: a running campaign is driven to the safe state first";
    log_line(text);
    around.manager.stopping(text);
    is_ended = true;
    (*engine)->stop();
  });
  around.manager.ready(serving);
  const auto ended = (*engine)->run([&] { around.manager.still_alive(); });
  around.signals.release();
  around.desk.close();
  alarms.stop();  // before the server waits for a test that is being sent
  server.stop();
  if (!ended) return base::forward_error(ended);
  return around.desk.is_changing() && !is_ended;
}

/// The folder of unit types that this program and those that it starts know where no file names one.
class TypesVariable {
 public:
  TypesVariable() {
    if (const char* there = std::getenv(kUnitTypesVariable); there != nullptr) at_start_ = there;
  }
  void set(const std::filesystem::path& folder) const {
    ::setenv(kUnitTypesVariable, std::filesystem::absolute(folder).c_str(), 1);
  }
  /// As it was when the program began.
  void put_back() const {
    if (at_start_) ::setenv(kUnitTypesVariable, at_start_->c_str(), 1);
    if (!at_start_) ::unsetenv(kUnitTypesVariable);
  }

 private:
  std::optional<std::string> at_start_;
};

/// The configuration, with what this program was told on its command line in place of what stands there.
base::Result<StationConfig> config_of(const DaemonOptions& options, const std::string& listen,
                                      const TypesVariable& types) {
  types.put_back();
  auto config = find_station_config(options.config, options.data);
  if (!config) return config;
  if (!listen.empty()) config->listen = listen;
  // What the page shows, what judges a unit here and the programs that are started from here have the same types.
  types.set(config->unit_types);
  return config;
}

/// A station does not begin with its new settings: it goes on with those of before, and says so.
base::Status go_back(const base::Error& error, const std::string& file, SettingsDesk& desk, db::Catalog& catalog) {
  const std::string why = error.where.empty() ? error.message : fmt::format("{}: {}", error.where, error.message);
  const auto user = desk.take_back(why);
  if (!user) return base::forward_error(user);
  const std::string text = "the station does not begin with its new settings, and goes on with those of before: " + why;
  log_line(text);
  const auto noted = catalog.log_event({now_utc_s(), "station_change_undone", file, text, *user});
  if (!noted) log_line("the event log does not tell of it: " + noted.error().message);
  return {};
}

/// Serves with the configuration, and anew with each that is written at the page, until somebody ends the program. One
/// with which the station does not begin gives way to the one that it served with last, whatever the file says by now.
base::Status serve_with_settings(const DaemonOptions& options, StationConfig first, std::string listen,
                                 const TypesVariable& types, OwnFolder& own, ServiceManager& manager,
                                 StopSignals& signals) {
  const std::string file = first.file;
  SettingsDesk desk(file);
  std::string text = settings::read_text(file).value_or("");
  base::Result<StationConfig> config = std::move(first);
  std::optional<Settings> served;
  for (;;) {
    if (config) config->data = own.catalog.data_folder();
    const auto begins_anew = config ? serve({*config, text}, listen, {own, manager, signals, desk})
                                    : base::Result<bool>(base::forward_error(config));
    if (begins_anew && !*begins_anew) return {};
    if (!begins_anew && (!desk.is_changing() || !served)) return base::forward_error(begins_anew);
    manager.still_alive();
    if (begins_anew) {
      served = Settings{*std::move(config), text};
      served->config.listen = listen;  // with the port that it got where any would do
      text = settings::read_text(file).value_or("");
      config = config_of(options, listen, types);
    } else {
      if (auto back = go_back(begins_anew.error(), file, desk, own.catalog); !back) return back;
      types.set(served->config.unit_types);
      text = served->text;
      config = served->config;
    }
    log_line(begins_anew ? "begins anew with " + file : "begins anew with the settings of before");
  }
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
  const TypesVariable types;
  auto config = config_of(options, listen, types);
  if (!config) return base::forward_error(config);
  // A file that was there already may name another folder than the one in which it was found.
  std::error_code unknown;
  if (own && !std::filesystem::equivalent(own->catalog.data_folder(), config->data, unknown)) own.reset();
  if (!own) {
    auto taken = OwnFolder::take(config->data.string());
    if (!taken) return base::forward_error(taken);
    own.emplace(*std::move(taken));
  }
  return serve_with_settings(options, *std::move(config), listen, types, *own, manager, signals);
}

}  // namespace soak::station
