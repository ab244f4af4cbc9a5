// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <map>
#include <nlohmann/json.hpp>
#include <string_view>
#include <thread>
#include <vector>

#include "base/text.h"
#include "station/commands/command.h"
#include "station/commands/shared.h"
#include "station/http/client.h"
#include "station/io/host.h"
#include "station/io/output.h"
#include "station/io/text_file.h"

namespace soak::station {
namespace {

using nlohmann::json;

/// What all campaign commands know: where the daemon is and who asks.
struct StationCommand : Command {
  std::string station;      ///< HOST:PORT or https://HOST:PORT; empty = $SOAK_STATION, else 127.0.0.1:8088
  std::string certificate;  ///< empty = $SOAK_CERTIFICATE
  std::string token_file;   ///< empty = $SOAK_TOKEN_FILE
  std::string user;         ///< empty = the user that runs the program

  void declare(OptionList& options) override {
    options.add("--station HOST:PORT", &station,
                "Where soakd listens, https://HOST:PORT where it speaks TLS (default: $SOAK_STATION, else "
                "127.0.0.1:8088)");
    options.add("--certificate FILE", &certificate,
                "Over TLS: the station's own certificate, soakd.crt of its data folder (default: $SOAK_CERTIFICATE, "
                "else one that the system trusts)");
    options.add("--token-file FILE", &token_file,
                "File with a token of 'soak user token', where the station asks who it is (default: $SOAK_TOKEN_FILE)");
  }
  void declare_user(OptionList& options) {
    options.add("--user NAME", name_reader(user), "Name for the log (default: the user that runs the program)");
  }
  /// A client of the daemon. Fails (bad_input) for an address that is not one, and a token that cannot be read.
  [[nodiscard]] base::Result<Client> client() const;
  /// Sends a command and prints the state that it leads to.
  base::Status send(const std::string& name, json body, const std::string& done, Output& output) const;
};

/// What an option says, else the environment, else `otherwise`.
std::string given(const std::string& option, const char* variable, const std::string& otherwise = {}) {
  if (!option.empty()) return option;
  const char* named = std::getenv(variable);
  return named == nullptr ? otherwise : named;
}

base::Result<Client> StationCommand::client() const {
  auto address = parse_station_address(given(station, "SOAK_STATION", "127.0.0.1:8088"));
  if (!address) return base::bad_input(address.error().message, "--station");
  StationEntry entry(*std::move(address));
  entry.certificate = given(certificate, "SOAK_CERTIFICATE");
  const std::string file = given(token_file, "SOAK_TOKEN_FILE");
  if (file.empty()) return Client(std::move(entry));
  if (!entry.tls)
    return base::bad_input("a token is sent over TLS only: the address must begin with https://", "--station");
  auto token = read_text_file(file);
  if (!token) return base::forward_error(token);
  entry.token = token->substr(0, token->find_first_of("\r\n"));
  return Client(std::move(entry));
}

base::Status StationCommand::send(const std::string& name, json body, const std::string& done, Output& output) const {
  const auto daemon = client();
  if (!daemon) return base::forward_error(daemon);
  body["user"] = user_name(user);
  const auto answer = daemon->command(name, body);
  if (!answer) return base::forward_error(answer);
  if (output.json()) return output.print_json(*answer);
  output.print(done + "\n");
  return {};
}

/// A member with so many decimals, "–" where it is not known.
std::string member_number(const json& object, const char* name, int decimals) {
  const json value = object.value(name, json());
  return value.is_number() ? fmt::format("{:.{}f}", value.get<double>(), decimals) : "–";
}

std::string member_text(const json& object, const char* name) {
  const json value = object.value(name, json());
  return value.is_string() ? value.get<std::string>() : "–";
}

/// "35 h 10 min", "4 min 20 s", "12 s".
std::string duration_text(double seconds) {
  const auto whole = static_cast<long long>(std::llround(seconds));
  if (whole >= 3600) return fmt::format("{} h {:02} min", whole / 3600, whole % 3600 / 60);
  if (whole >= 60) return fmt::format("{} min {:02} s", whole / 60, whole % 60);
  return fmt::format("{} s", whole);
}

/// Where a campaign is: "run R02, step 31 of 240: soak at -20 °C". `campaign` is that of a status document. The runs go
/// by their labels: their number counts the pre-flight, too.
std::string step_text(const json& campaign) {
  return fmt::format("run {}, step {} of {}: {}", member_text(campaign, "run_label"),
                     campaign.at("step").get<int>() + 1, campaign.at("steps").get<int>(),
                     member_text(campaign, "step_text"));
}

std::string campaign_lines(const json& status) {
  const json& campaign = status.at("campaign");
  if (campaign.is_null()) return {};
  const double left_s = campaign.at("remaining_s").get<double>();
  const double rate = status.at("clock").at("rate").get<double>();
  std::string lines = fmt::format("campaign   {} ({}, {})\n", member_text(campaign, "name"),
                                  member_text(campaign, "procedure"), member_text(campaign, "purpose"));
  lines += fmt::format("           {}\n", step_text(campaign));
  lines += fmt::format("           {:.0f} % done, {}{} left", 100.0 * campaign.at("progress").get<double>(),
                       duration_text(left_s), rate == 1.0 ? "" : " of simulated time");
  if (rate != 1.0) lines += fmt::format(", {} of real time (rate {})", duration_text(left_s / rate), rate);
  return lines + "\n";
}

/// What happens by itself, and how to stop it.
std::string waiting_lines(const json& status) {
  std::string lines;
  if (const json& suspension = status.at("suspension"); !suspension.is_null()) {
    lines += fmt::format("           goes on by itself once that is over; gives up in {}\n",
                         duration_text(suspension.at("gives_up_in_s").get<double>()));
  }
  if (status.at("resumes_by_itself").get<bool>()) {
    lines += "           GOES ON BY ITSELF, keep the door closed: 'soak campaign abort' stops that\n";
  }
  return lines;
}

/// What becomes of the queue: "begins by itself at 2026-11-26T14:05:00Z".
std::string queue_outlook(const json& status) {
  const json& queue = status.at("queue");
  if (status.at("state") == "stopping") return "waits until the station is safe";
  if (queue.at("waits_for") == "campaign")
    return "the first one begins by itself once the present campaign has finished";
  if (queue.at("waits_for") == "time") {
    return fmt::format("BEGINS BY ITSELF at {}, keep the door closed: 'soak campaign abort' stops that",
                       base::utc_text(queue.at("begins_utc_s").get<double>()));
  }
  return "waits for somebody: 'soak campaign next' begins the first one";
}

std::string queue_lines(const json& status) {
  const json& queue = status.at("queue");
  std::string lines;
  for (const json& campaign : queue.at("campaigns")) {
    lines +=
        fmt::format("{}{} ({}, {})\n", lines.empty() ? "next       " : "           ", member_text(campaign, "name"),
                    member_text(campaign, "procedure"), duration_text(campaign.at("estimate_s").get<double>()));
  }
  if (lines.empty()) return lines;
  if (!queue.at("trouble").is_null()) lines += "           " + member_text(queue, "trouble") + "\n";
  return lines + "           " + queue_outlook(status) + "\n";
}

std::string chamber_lines(const json& status) {
  const json& chamber = status.at("chamber");
  std::string lines =
      fmt::format("chamber    {} °C, set point {} °C, output {} %{}\n", member_number(chamber, "air_c", 2),
                  member_number(chamber, "set_point_c", 2), member_number(chamber, "output_percent", 0),
                  chamber.at("connected").get<bool>() ? "" : ", NOT CONNECTED");
  for (const json& alarm : chamber.at("alarms")) {
    lines += fmt::format("           alarm: {}\n", alarm.get<std::string>());
  }
  const json& fixture = status.at("fixture");
  const bool by_hand = fixture.at("description") == "by hand";
  lines += by_hand ? "fixture    turned by hand\n"
                   : fmt::format("fixture    {}{}\n", member_text(fixture, "position"),
                                 fixture.at("connected").get<bool>() ? "" : ", NOT CONNECTED");
  return lines;
}

/// "+X", or "+Y is up, need +X" of a unit that rests with a wrong face up.
std::string face_text(const json& unit) {
  const json attitude = unit.value("attitude", json());
  if (!attitude.is_object() || attitude.value("right", json()) != json(false)) return member_text(unit, "position");
  return fmt::format("{} is up, need {}", member_text(attitude, "up"), member_text(attitude, "expected"));
}

/// What the unit does; of one that was dropped that does not count.
std::string unit_state_text(const json& unit) {
  const bool dropped = unit.value("dropped", json()).is_string();
  return dropped ? fmt::format("dropped ({})", member_text(unit, "state")) : member_text(unit, "state");
}

/// Why units are not recorded, a line each.
std::string dropped_lines(const json& units) {
  std::string lines;
  for (const json& unit : units) {
    if (!unit.value("dropped", json()).is_string()) continue;
    lines += fmt::format("{} is dropped, not recorded in this run: {}\n", member_text(unit, "serial"),
                         member_text(unit, "dropped"));
  }
  return lines;
}

std::string unit_table(const json& units) {
  if (units.empty()) return {};
  std::vector<std::vector<std::string>> rows = {
      {"slot", "unit", "state", "°C", "K/min", "±", "stable", "position", "samples", "lost"}};
  for (const json& unit : units) {
    rows.push_back({member_text(unit, "slot"), member_text(unit, "serial"), unit_state_text(unit),
                    member_number(unit, "temp_c", 2), member_number(unit, "slope_kpmin", 3),
                    member_number(unit, "slope_half_width_kpmin", 3), unit.at("stable").get<bool>() ? "yes" : "no",
                    face_text(unit), member_number(unit, "samples", 0), member_number(unit, "lost", 0)});
  }
  return "\n" + text_table(rows) + dropped_lines(units);
}

/// What `soak campaign status` prints of a status document.
std::string status_text(const json& status) {
  std::string lines = fmt::format("state      {}{}\n", member_text(status, "state"),
                                  status.at("simulated").get<bool>() ? " (SIMULATED)" : "");
  if (!status.at("reason").is_null()) lines += fmt::format("           {}\n", member_text(status, "reason"));
  lines += waiting_lines(status) + campaign_lines(status) + queue_lines(status);
  if (!status.at("prompt").is_null()) {
    lines += fmt::format("prompt     {}\n           answer it with 'soak campaign confirm'\n",
                         member_text(status.at("prompt"), "text"));
  }
  return lines + chamber_lines(status) + unit_table(status.at("units"));
}

/// soak campaign start PROCEDURE.toml --name NAME [--unit SLOT=SERIAL]... [--queue]
struct CampaignStart final : StationCommand {
  std::string procedure;  ///< path of the file, read here: the daemon need not see it
  std::string name;
  std::map<std::string, std::string> units;  ///< slot → serial number
  bool queue = false;

  void declare(OptionList& options) override;
  base::Status run(Output& output) override;
};

void CampaignStart::declare(OptionList& options) {
  options.add("procedure PROCEDURE.toml", &procedure, "Procedure file").required();
  options.add("--name NAME", &name, "Name of the campaign").required();
  const OptionReader read_unit = [this](const std::string& text) -> base::Status {
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos || equals == 0 || equals + 1 == text.size()) {
      return base::bad_input("'" + text + "' is not SLOT=SERIAL");
    }
    if (units.emplace(text.substr(0, equals), text.substr(equals + 1)).second) return {};
    return base::bad_input("slot '" + text.substr(0, equals) + "' is given twice");
  };
  options
      .add("--unit SLOT=SERIAL", read_unit,
           "Unit in a slot; repeat for each unit (default: those of the station's configuration)")
      .one_each();
  options.add(
      "--queue", &queue,
      "Begin by itself, five minutes after the campaign before it has finished; 'soak campaign next' begins it now");
  StationCommand::declare(options);
  declare_user(options);
}

base::Status CampaignStart::run(Output& output) {
  const auto daemon = client();
  if (!daemon) return base::forward_error(daemon);
  const auto text = read_text_file(procedure);
  if (!text) return base::forward_error(text);
  const json request = {{"procedure_text", *text},
                        {"procedure_file", procedure},
                        {"campaign", name},
                        {"units", units},
                        {"user", user_name(user)}};
  const auto answer = daemon->command(queue ? "queue" : "start", request);
  if (!answer) return base::forward_error(answer);
  if (output.json()) return output.print_json(*answer);
  for (const json& note : answer->value("notes", json::array())) output.note("note: " + note.get<std::string>());
  output.print(fmt::format("campaign {} {}: {} runs, {} steps, about {} of process time\n", name,
                           queue ? fmt::format("queued, {} before it", answer->value("before", 0)) : "started",
                           answer->value("runs", 0), answer->value("steps", 0),
                           duration_text(answer->value("estimate_s", 0.0))));
  output.print(queue ? "'soak campaign queue' shows what waits, and for what\n" : "'soak campaign watch' follows it\n");
  return {};
}

/// soak campaign queue
struct CampaignQueueShow final : StationCommand {
  base::Status run(Output& output) override {
    const auto daemon = client();
    if (!daemon) return base::forward_error(daemon);
    const auto status = daemon->get("status");
    if (!status) return base::forward_error(status);
    if (output.json()) return output.print_json(status->at("queue"));
    const std::string lines = queue_lines(*status);
    output.print(lines.empty() ? "no campaign waits\n" : lines);
    return {};
  }
};

/// soak campaign unqueue NAME
struct CampaignUnqueue final : StationCommand {
  std::string name;

  void declare(OptionList& options) override {
    options.add("name NAME", &name, "Name of the campaign").required();
    StationCommand::declare(options);
    declare_user(options);
  }
  base::Status run(Output& output) override {
    return send("unqueue", {{"campaign", name}}, "campaign " + name + " is out of the queue", output);
  }
};

/// soak campaign status
struct CampaignStatus final : StationCommand {
  base::Status run(Output& output) override {
    const auto daemon = client();
    if (!daemon) return base::forward_error(daemon);
    const auto status = daemon->get("status");
    if (!status) return base::forward_error(status);
    if (output.json()) return output.print_json(*status);
    output.print(status_text(*status));
    return {};
  }
};

/// soak campaign pause, resume, next
struct CampaignChange final : StationCommand {
  CampaignChange(std::string command, std::string done) : command_(std::move(command)), done_(std::move(done)) {}
  void declare(OptionList& options) override {
    StationCommand::declare(options);
    declare_user(options);
  }
  base::Status run(Output& output) override { return send(command_, json::object(), done_, output); }

 private:
  std::string command_;
  std::string done_;
};

/// soak campaign abort --reason TEXT
struct CampaignAbort final : StationCommand {
  std::string reason;

  void declare(OptionList& options) override {
    options.add("--reason TEXT", &reason, "Reason").required();
    StationCommand::declare(options);
    declare_user(options);
  }
  base::Status run(Output& output) override {
    return send("abort", {{"reason", reason}}, "the campaign is being stopped safely", output);
  }
};

/// soak campaign confirm: answers the prompt that is open now, and prints its text.
struct CampaignConfirm final : StationCommand {
  void declare(OptionList& options) override {
    StationCommand::declare(options);
    declare_user(options);
  }
  base::Status run(Output& output) override {
    const auto daemon = client();
    if (!daemon) return base::forward_error(daemon);
    const auto status = daemon->get("status");
    if (!status) return base::forward_error(status);
    const json prompt = status->value("prompt", json());
    if (prompt.is_null()) return base::bad_input("no prompt is waiting for an answer", "state");
    return send("confirm", {{"prompt", prompt.at("id")}}, "confirmed: " + prompt.at("text").get<std::string>(), output);
  }
};

constexpr std::chrono::seconds kReconnectFor{120};
constexpr std::chrono::milliseconds kReconnectEvery{500};

bool campaign_is_over(const json& status) {
  const std::string state = status.at("state");
  return state == "finished" || state == "aborted" || state == "failed" || state == "interrupted" || state == "idle";
}

/// Success or failure of the campaign, which is that of the watch.
base::Status campaign_outcome(const json& status) {
  const std::string state = status.at("state");
  if (state == "finished") return {};
  if (state == "idle") return base::bad_input("no campaign is running: 'soak campaign start' starts one", "state");
  const json& campaign = status.at("campaign");
  const std::string name = campaign.is_null() ? "?" : campaign.at("name").get<std::string>();
  std::string message = "campaign " + name + " " + (state == "failed" ? "" : "was ") + state;
  if (status.at("reason").is_string()) message += ": " + status.at("reason").get<std::string>();
  return base::fail(state == "failed" ? base::ErrorKind::device : base::ErrorKind::internal, message);
}

/// Prints what is new in each status.
class StatusPrinter {
 public:
  explicit StatusPrinter(Output& output) : output_(output) {}

  /// False once the campaign is over.
  bool take(json status) {
    last_ = std::move(status);
    ++taken_;
    if (!output_.json()) print_changes();
    return !campaign_is_over(last_);
  }

  [[nodiscard]] const json& last() const { return last_; }
  [[nodiscard]] std::size_t taken() const { return taken_; }

 private:
  void print_changes() {
    const json& campaign = last_.at("campaign");
    if (campaign.is_null()) return;
    print_if_new(step_, step_text(campaign));
    print_if_new(state_, state_line());
    const json& prompt = last_.at("prompt");
    print_if_new(prompt_, prompt.is_null() ? std::string()
                                           : "prompt: " + prompt.at("text").get<std::string>() +
                                                 "  (answer it with 'soak campaign confirm')");
    print_if_new(faces_, prompt.is_null() ? std::string() : faces_line());
    if (!bar_) bar_ = output_.progress(campaign.at("name").get<std::string>());
    bar_(campaign.at("progress").get<double>());
  }

  std::string state_line() const {
    const json& reason = last_.at("reason");
    return last_.at("state").get<std::string>() + (reason.is_string() ? ": " + reason.get<std::string>() : "");
  }

  /// Wrong faces, for whoever turns the units while a prompt is open.
  [[nodiscard]] std::string faces_line() const {
    std::string line;
    for (const json& unit : last_.at("units")) {
      const json attitude = unit.value("attitude", json());
      if (!attitude.is_object() || attitude.value("right", json()) != json(false)) continue;
      line += fmt::format("{}slot {}: {}", line.empty() ? "" : "; ", member_text(unit, "slot"), face_text(unit));
    }
    return line;
  }

  void print_if_new(std::string& known, std::string line) {
    if (line == known) return;
    known = std::move(line);
    if (known.empty()) return;
    output_.end_progress();
    bar_ = nullptr;
    output_.print(known + "\n");
    output_.flush();
  }

  Output& output_;
  json last_;
  std::size_t taken_ = 0;
  std::string step_;
  std::string faces_;
  std::string state_;
  std::string prompt_;
  std::function<bool(double)> bar_;
};

/// Follows one connection. True once the campaign is over.
base::Result<bool> follow_connection(const Client& client, StatusPrinter& printer) {
  bool over = false;
  const auto followed = client.follow(
      [&](const ServerEvent& event) {
        if (event.type != "status") return true;
        json status = json::parse(event.data, nullptr, false);
        over = !status.is_discarded() && !printer.take(std::move(status));
        return !over;
      },
      [] { return !interrupted(); });
  if (!followed) return base::forward_error(followed);
  return over;
}

/// Reconnects until the campaign is over or the user stops watching. Fails if the daemon no longer answers.
base::Status follow_to_the_end(const Client& client, StatusPrinter& printer, Output& output) {
  auto last_heard = std::chrono::steady_clock::now();
  bool broken = false;
  while (!interrupted()) {
    const std::size_t before = printer.taken();
    const auto over = follow_connection(client, printer);
    if (over) return {};
    const auto now = std::chrono::steady_clock::now();
    const bool heard = printer.taken() != before;
    if (heard) last_heard = now;
    if (printer.taken() == 0 || now - last_heard > kReconnectFor) return base::forward_error(over);
    if (!broken || heard) output.note(over.error().message + ": reconnecting");
    broken = true;
    std::this_thread::sleep_for(kReconnectEvery);
  }
  return {};
}

/// soak campaign watch: follows the campaign to its end. Succeeds if it finished; fails with `device` if it failed,
/// with `internal` if it was aborted or interrupted, or the user stopped watching (the campaign goes on). Reconnects if
/// the connection breaks.
struct CampaignWatch final : StationCommand {
  base::Status run(Output& output) override;
};

base::Status CampaignWatch::run(Output& output) {
  const auto daemon = client();
  if (!daemon) return base::forward_error(daemon);
  StatusPrinter printer(output);
  auto followed = follow_to_the_end(*daemon, printer, output);
  output.end_progress();
  if (!followed) return followed;
  if (printer.taken() == 0 || !campaign_is_over(printer.last())) {
    return base::fail(base::ErrorKind::internal, "stopped watching; the campaign continues");
  }
  if (output.json()) {
    const auto printed = output.print_json(printer.last());
    if (!printed) return printed;
  }
  return campaign_outcome(printer.last());
}

}  // namespace

CommandGroup campaign_commands() {
  return {"campaign",
          "Campaigns of the running soakd: start, status, watch, pause, resume, abort, confirm, queue, unqueue, next",
          {{"start", "Check a procedure and start a campaign with it",
            "soak campaign start procedures/soak.toml --name acceptance --unit A=SN0042",
            std::make_shared<CampaignStart>()},
           {"status", "State of the campaign, the chamber and the units", "soak campaign status",
            std::make_shared<CampaignStatus>()},
           {"watch", "Follow the campaign to its end", "soak campaign watch", std::make_shared<CampaignWatch>(), true,
            "Stops when the campaign ends: exit status 0 if it finished, 1 if it was aborted or interrupted, 3 if a "
            "device failed. Ctrl-C stops watching; the campaign continues."},
           {"pause", "Pause the campaign in a safe state", "soak campaign pause",
            std::make_shared<CampaignChange>("pause", "the campaign pauses: 'soak campaign resume' continues it")},
           {"resume", "Continue a paused campaign", "soak campaign resume",
            std::make_shared<CampaignChange>("resume", "the campaign continues")},
           {"abort", "End the campaign safely", "soak campaign abort --reason 'a cable is loose'",
            std::make_shared<CampaignAbort>()},
           {"confirm", "Answer the prompt that the station is waiting for", "soak campaign confirm",
            std::make_shared<CampaignConfirm>()},
           {"queue", "Campaigns that wait for their turn ('soak campaign start --queue')", "soak campaign queue",
            std::make_shared<CampaignQueueShow>()},
           {"unqueue", "Take a campaign out of the queue", "soak campaign unqueue verification",
            std::make_shared<CampaignUnqueue>()},
           {"next", "Begin the first campaign of the queue now", "soak campaign next",
            std::make_shared<CampaignChange>("next", "the first campaign of the queue has started")}}};
}

}  // namespace soak::station
