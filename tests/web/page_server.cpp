// SPDX-License-Identifier: Apache-2.0
// The pages and the HTTP interface before a scripted laboratory, for tests of the page and of `soak campaign`:
// prints its port, then obeys lines on standard input until that ends:
//   set POINTER JSON   sets a member of the status ("/campaign/step 31")
//   status JSON        replaces the status
//   history JSON       replaces the history
//   plan JSON          replaces the plan
//   stored JSON        replaces what /api/v1/stored answers
//   types JSON         the types of units that there are
//   noise JSON         what /api/v1/noise answers of the unit in it
//   noise-calls        prints how often it was asked
//   log TEXT           adds a log entry
//   fail CODE WHERE    makes the next command fail
//   commands           prints the commands that came, as one JSON array
//   routes             prints what the server answers to, as a JSON array
//   stop / start       stops and starts the server, on the same port
#include <cstdio>
#include <iostream>
#include <memory>
#include <sstream>
#include <string>

#include "station/http/server.h"
#include "tests/station/http_scripted_station.h"

namespace {

using soak::station::HttpServer;
using soak::station::ScriptedStation;

struct Stage {
  ScriptedStation lab;
  int port = 0;
  std::unique_ptr<HttpServer> server;

  bool start() {
    server = std::make_unique<HttpServer>(lab, "127.0.0.1:" + std::to_string(port));
    const auto started = server->start();
    if (!started) std::cerr << started.error().message << '\n';
    if (started) port = *started;
    return started.has_value();
  }
};

void obey(Stage& stage, const std::string& line) {
  std::istringstream words(line);
  std::string command;
  words >> command >> std::ws;
  std::string rest;
  if (command == "set") {
    std::string pointer;
    words >> pointer >> std::ws;
    std::getline(words, rest);
    stage.lab.set(pointer, nlohmann::json::parse(rest));
    return;
  }
  std::getline(words, rest);
  if (command == "status") stage.lab.set_status(nlohmann::json::parse(rest));
  if (command == "history") stage.lab.set_history(nlohmann::json::parse(rest));
  if (command == "plan") stage.lab.set_plan(nlohmann::json::parse(rest));
  if (command == "stored") stage.lab.set_stored(nlohmann::json::parse(rest));
  if (command == "types") stage.lab.set_types(nlohmann::json::parse(rest));
  if (command == "noise") stage.lab.set_noise(nlohmann::json::parse(rest));
  if (command == "noise-calls") std::cout << stage.lab.noise_calls() << std::endl;
  if (command == "log") stage.lab.add_log(rest);
  if (command == "routes") std::cout << nlohmann::json(stage.server->routes()).dump() << std::endl;
  if (command == "stop") stage.server.reset();
  if (command == "start") stage.start();
  if (command == "commands") std::cout << nlohmann::json(stage.lab.commands()).dump() << std::endl;
  if (command == "fail") {
    const int code = std::stoi(rest.substr(0, 1));
    stage.lab.fail_next({static_cast<soak::base::ErrorKind>(code), "scripted failure", rest.substr(2)});
  }
}

}  // namespace

int main() {
  Stage stage;
  if (!stage.start()) return 1;
  std::cout << stage.port << std::endl;
  for (std::string line; std::getline(std::cin, line);) {
    obey(stage, line);
    std::cout << "done" << std::endl;
  }
  return 0;
}
