// SPDX-License-Identifier: Apache-2.0
#include "modbus_peer.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cstdlib>
#include <stdexcept>
#include <thread>

extern char** environ;

namespace soak::hal::test {
namespace {

struct Pipe {
  Pipe() {
    if (::pipe2(ends.data(), O_CLOEXEC) != 0) std::abort();
  }
  std::array<int, 2> ends{};
};

const char* const kPython = "/usr/bin/python3";

std::vector<std::string> mbpoll_command(int port, int address, const std::string& type) {
  return {"mbpoll", "-m", "tcp", "-p", std::to_string(port), "-a", "1", "-0", "-r", std::to_string(address),
          "-t",     type, "-1",  "-q"};
}

}  // namespace

Process::Process(const std::vector<std::string>& command) {
  const Pipe to_child;
  const Pipe from_child;
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, to_child.ends[0], STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&actions, from_child.ends[1], STDOUT_FILENO);
  std::vector<char*> arguments;
  for (const std::string& argument : command) arguments.push_back(const_cast<char*>(argument.c_str()));
  arguments.push_back(nullptr);
  if (posix_spawnp(&pid_, arguments[0], &actions, nullptr, arguments.data(), environ) != 0) pid_ = -1;
  posix_spawn_file_actions_destroy(&actions);
  ::close(to_child.ends[0]);
  ::close(from_child.ends[1]);
  input_ = to_child.ends[1];
  output_ = from_child.ends[0];
}

Process::~Process() {
  ::close(input_);
  ::close(output_);
  if (pid_ <= 0) return;
  ::kill(pid_, SIGTERM);
  ::waitpid(pid_, nullptr, 0);
}

std::optional<std::string> Process::line() {
  std::string text;
  for (char next = 0; ::read(output_, &next, 1) == 1;) {
    if (next == '\n') return text;
    text += next;
  }
  if (text.empty()) return std::nullopt;
  return text;
}

void Process::tell(const std::string& line) const {
  const std::string text = line + "\n";
  if (::write(input_, text.data(), text.size()) != static_cast<ssize_t>(text.size())) std::abort();
}

int Process::wait() {
  int status = -1;
  if (pid_ > 0) ::waitpid(pid_, &status, 0);
  pid_ = -1;
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

SerialLine::SerialLine(int port)
    : path_(fmt::format("/tmp/soak-rtu-{}-{}", ::getpid(), port)),
      // In this order the link stands once the line leads to the peer.
      socat_({"socat", fmt::format("tcp:127.0.0.1:{}", port), fmt::format("pty,raw,echo=0,link={}", path_)}) {
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(10);
  while (::access(path_.c_str(), F_OK) != 0 && std::chrono::steady_clock::now() < deadline) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
}

bool have_program(const std::string& name) {
  Process process({"sh", "-c", "command -v " + name});
  return process.line().has_value();
}

std::unique_ptr<PymodbusServer> PymodbusServer::start(const std::string& framing, const std::vector<std::string>& specs,
                                                      int port) {
  Process probe({kPython, "-c", "import pymodbus; print('yes')"});
  if (!probe.line()) return nullptr;
  std::vector<std::string> command = {kPython, SOAK_TEST_FOLDER "/hal/pymodbus_server.py", framing,
                                      std::to_string(port)};
  command.insert(command.end(), specs.begin(), specs.end());
  std::unique_ptr<PymodbusServer> server(new PymodbusServer(std::move(command)));
  const std::string greeting = server->process_.line().value_or("");
  if (!greeting.starts_with("PORT ")) throw std::runtime_error("pymodbus_server.py did not start");
  std::size_t end = 0;
  server->port_ = std::stoi(greeting.substr(5), &end);
  server->look_port_ = std::stoi(greeting.substr(5 + end));
  return server;
}

int PymodbusServer::writes() const { return std::stoi(mbpoll_read(look_port_, 60000, "4")); }

std::string mbpoll_read(int port, int address, const std::string& type) {
  std::vector<std::string> command = mbpoll_command(port, address, type);
  command.insert(command.end(), {"-c", "1", "127.0.0.1"});
  Process process(command);
  while (const auto line = process.line()) {
    const std::size_t tab = line->find('\t');
    if (line->starts_with('[') && tab != std::string::npos) return line->substr(tab + 1);
  }
  return "";
}

bool mbpoll_write(int port, int address, const std::string& type, const std::string& value) {
  std::vector<std::string> command = mbpoll_command(port, address, type);
  command.insert(command.end(), {"127.0.0.1", "--", value});
  Process process(command);
  while (process.line()) continue;
  return process.wait() == 0;
}

DeviceMap repository_map(const std::string& path, int port) {
  auto map = read_device_map(SOAK_TEST_FOLDER "/../procedures/" + path);
  if (!map) throw std::runtime_error(map.error().message);
  map->link.address = TcpAddress{"127.0.0.1", port};
  map->link.response_timeout_s = 0.3;
  return *std::move(map);
}

DeviceMap parsed_map(const std::string& text) {
  auto map = parse_device_map(text, "test.toml");
  if (!map) throw std::runtime_error(map.error().message);
  return *std::move(map);
}

std::vector<std::string> f4t_registers() {
  std::vector<std::string> specs = {
      "f32lo:2820:23.25", "f32lo:2782:25", "f32lo:2810:24.5", "f32lo:2808:-12.5", "f32lo:2774:-68", "f32lo:2776:150",
      "u16:2730:62",      "u16:2814:62",   "copy:2730:2814",  "u16:2794:62",      "u16:2796:39",    "f32lo:2798:1",
      "u16:6730:15",      "u16:90:138",    "u16:11250:61",    "u16:11264:138",    "u16:11288:61",
  };
  for (int alarm = 0; alarm < 6; ++alarm) specs.push_back(fmt::format("u16:{}:61", 1356 + 100 * alarm));
  return specs;
}

}  // namespace soak::hal::test
