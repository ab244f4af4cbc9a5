// SPDX-License-Identifier: Apache-2.0
#include "station/commands/command.h"
#include "station/config/config_place.h"
#include "station/http/daemon.h"

namespace {

using namespace soak;
using namespace soak::station;

/// soakd
class Daemon final : public Command {
 public:
  void declare(OptionList& options) override {
    options.add("--config FILE", &config_,
                "Station configuration: devices and slots (default: station.toml in the data folder; where that is "
                "missing, the page sets the station up)");
    options.add("--listen HOST:PORT", &listen_,
                "Address of the web page and the HTTP interface, port 0 = any (default: 127.0.0.1:8088)");
    options.add("--write-config", &write_config_,
                "Print a commented configuration to begin with, and end: soakd --write-config > station.toml");
    options.add("--data DIR", &data,
                "Data folder (default: the configuration's, else $SOAK_DATA, else $XDG_DATA_HOME/soak)");
  }
  base::Status run(Output& output) override {
    if (!write_config_) return run_daemon({config_, listen_, data});
    output.print(config_template());
    return {};
  }

 private:
  std::string config_;
  std::string listen_;
  bool write_config_ = false;
};

}  // namespace

int main(int argc, char** argv) {
  const Program soakd{
      "soakd",
      "Soak's station: controls chamber, fixture and units, records, serves the web page",
      "Runs until SIGTERM or Ctrl-C. A campaign is then brought to the safe state first: the chamber returns to room\n"
      "temperature, which can take hours. 'soak campaign' controls it, the page shows it.\n"
      "Example:\n  soakd --config /etc/soak/station.toml\n"
      "Exit status: 0 done, 1 failed, 2 wrong usage or configuration, 3 a device failed, 4 stored data are damaged.",
      {},
      std::make_shared<Daemon>()};
  return run_program(soakd, argc, argv);
}
