// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <chrono>
#include <nlohmann/json.hpp>
#include <thread>

#include "station/commands/campaign_client.h"
#include "station/commands/campaign_text.h"

namespace soak::station {
namespace {

using base::ErrorKind;
using nlohmann::json;

constexpr std::chrono::seconds kReconnectFor{120};
constexpr std::chrono::milliseconds kReconnectEvery{500};

bool is_over(const json& status) {
  const std::string state = status.at("state");
  return state == "finished" || state == "aborted" || state == "failed" || state == "interrupted" || state == "idle";
}

/// Success of the watch: that of the campaign.
base::Status outcome(const json& status) {
  const std::string state = status.at("state");
  if (state == "finished") return {};
  if (state == "idle") return base::bad_input("no campaign is running: 'soak campaign start' begins one", "state");
  const json& campaign = status.at("campaign");
  const std::string name = campaign.is_null() ? "?" : campaign.at("name").get<std::string>();
  std::string message = "campaign " + name + " " + (state == "failed" ? "" : "was ") + state;
  if (status.at("reason").is_string()) message += ": " + status.at("reason").get<std::string>();
  return base::fail(state == "failed" ? ErrorKind::device : ErrorKind::internal, message);
}

/// Prints what is new in each status.
class Narrator {
 public:
  explicit Narrator(Output& output) : output_(output) {}

  /// False once the campaign is over.
  bool take(json status) {
    last_ = std::move(status);
    ++taken_;
    if (!output_.json()) tell();
    return !is_over(last_);
  }

  [[nodiscard]] const json& last() const { return last_; }
  [[nodiscard]] std::size_t taken() const { return taken_; }

 private:
  void tell() {
    const json& campaign = last_.at("campaign");
    if (campaign.is_null()) return;
    say_if_new(step_, step_text(campaign));
    say_if_new(state_, state_line());
    const json& prompt = last_.at("prompt");
    say_if_new(prompt_, prompt.is_null() ? std::string()
                                         : "prompt: " + prompt.at("text").get<std::string>() +
                                               "  ('soak campaign confirm' answers it)");
    if (!bar_) bar_ = output_.progress(campaign.at("name").get<std::string>());
    bar_(campaign.at("progress").get<double>());
  }

  std::string state_line() const {
    const json& reason = last_.at("reason");
    return last_.at("state").get<std::string>() + (reason.is_string() ? ": " + reason.get<std::string>() : "");
  }

  void say_if_new(std::string& known, std::string line) {
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
  std::string state_;
  std::string prompt_;
  std::function<bool(double)> bar_;
};

/// Follows one stream. True once the campaign is over.
base::Result<bool> follow(const Client& client, Narrator& narrator) {
  bool over = false;
  const auto followed = client.follow(
      [&](const ServerEvent& event) {
        if (event.type != "status") return true;
        json status = json::parse(event.data, nullptr, false);
        over = !status.is_discarded() && !narrator.take(std::move(status));
        return !over;
      },
      [] { return !interrupted(); });
  if (!followed) return base::forward_error(followed);
  return over;
}

/// Follows streams until the campaign is over or the user stops watching. Errors: none answers any more.
base::Status follow_to_the_end(const Client& client, Narrator& narrator, Output& output) {
  auto last_heard = std::chrono::steady_clock::now();
  bool broken = false;
  while (!interrupted()) {
    const std::size_t before = narrator.taken();
    const auto over = follow(client, narrator);
    if (over) return {};
    const auto now = std::chrono::steady_clock::now();
    const bool heard = narrator.taken() != before;
    if (heard) last_heard = now;
    if (narrator.taken() == 0 || now - last_heard > kReconnectFor) return base::forward_error(over);
    if (!broken || heard) output.note(over.error().message + ": trying again");
    broken = true;
    std::this_thread::sleep_for(kReconnectEvery);
  }
  return {};
}

}  // namespace

base::Status run_campaign_watch(const StationCommand& command, Output& output) {
  const auto client = station_client(command);
  if (!client) return base::forward_error(client);
  Narrator narrator(output);
  auto followed = follow_to_the_end(*client, narrator, output);
  output.end_progress();
  if (!followed) return followed;
  if (narrator.taken() == 0 || !is_over(narrator.last())) {
    return base::fail(ErrorKind::internal, "stopped watching; the campaign goes on");
  }
  if (output.json()) {
    const auto printed = output.print_json(narrator.last());
    if (!printed) return printed;
  }
  return outcome(narrator.last());
}

}  // namespace soak::station
