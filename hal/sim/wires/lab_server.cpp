// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/wires/lab_server.h"

#include <algorithm>
#include <csignal>
#include <cstddef>

namespace soak::hal::sim {
namespace {

// Offsets from the base port.
constexpr int kFixturePort = 1;
constexpr int kRelayPort = 2;
constexpr int kTextPort = 3;
constexpr int kFirstUnitPort = 11;

/// Bytes of a unit that are handed on together.
constexpr std::size_t kBatch = 2048;
/// Host time after which commands are looked for, however much there is to simulate.
constexpr std::int64_t kSlice_ns = 5'000'000;
/// Shortest wait: at high rates what is due meanwhile is done together.
constexpr std::int64_t kShortestWait_ns = 1'000'000;
constexpr std::int64_t kWatch_ns = 20'000'000;
constexpr std::int64_t kForever_ns = -1;

int port_at(const std::optional<int>& base_port, int offset) { return base_port ? *base_port + offset : 0; }

}  // namespace

base::Result<std::unique_ptr<LabServer>> LabServer::open(const CampaignConfig& config,
                                                         const LabServerOptions& options) {
  std::unique_ptr<LabServer> server(new LabServer(config, options));
  if (const auto opened = server->open_servers(options.base_port); !opened) return base::forward_error(opened);
  if (const auto opened = server->open_wire(options); !opened) return base::forward_error(opened);
  for (std::size_t i = 0; i < server->lab_.unit_count(); ++i) {
    if (const auto opened = server->open_unit_port(i, options); !opened) return base::forward_error(opened);
  }
  return server;
}

base::Status LabServer::open_servers(const std::optional<int>& base_port) {
  const auto open = [&](int offset, RegisterTable& registers, std::unique_ptr<ModbusServer>& target) -> base::Status {
    auto server = ModbusServer::open(port_at(base_port, offset), registers);
    if (!server) return base::forward_error(server);
    target = *std::move(server);
    return {};
  };
  return open(0, lab_.chamber().registers(), chamber_)
      .and_then([&] { return open(kFixturePort, lab_.fixture().registers(), fixture_); })
      .and_then([&] { return open(kRelayPort, lab_.relay().registers(), relay_); });
}

base::Status LabServer::open_wire(const LabServerOptions& options) {
  SimulatedChamber& chamber = lab_.chamber();
  wire_address_ = chamber_->port();
  if (options.chamber == ChamberKind::f4t) return {};
  if (options.chamber == ChamberKind::espec_p300) {
    auto wire = TextWire::open(port_at(options.base_port, kTextPort), chamber);
    if (!wire) return base::forward_error(wire);
    wire_address_ = (*wire)->tcp_port();
    wire_ = *std::move(wire);
    return {};
  }
  const bool f4t = options.chamber == ChamberKind::f4t_rtu;
  auto wire = RtuWire::open(f4t ? chamber.registers() : eurotherm_registers(chamber));
  if (!wire) return base::forward_error(wire);
  wire_address_ = (*wire)->path();
  wire_ = *std::move(wire);
  return {};
}

base::Status LabServer::open_unit_port(std::size_t index, const LabServerOptions& options) {
  const auto receive = [this, index](std::span<const std::uint8_t> bytes) {
    lab_.device(index).receive(bytes, lab_.now());
  };
  const int slot = static_cast<int>(index) + 1;
  if (options.pty_slots.contains(slot)) {
    auto port = PtyUnitPort::open(receive);
    if (!port) return base::forward_error(port);
    unit_addresses_.emplace_back((*port)->path());
    ports_.push_back(*std::move(port));
    return {};
  }
  auto port = TcpUnitPort::open(port_at(options.base_port, kFirstUnitPort + static_cast<int>(index)), receive);
  if (!port) return base::forward_error(port);
  unit_addresses_.emplace_back((*port)->port());
  ports_.push_back(*std::move(port));
  return {};
}

LabAddresses LabServer::addresses() const {
  return {chamber_->port(), wire_address_, fixture_->port(), relay_->port(), unit_addresses_};
}

bool LabServer::reader_lags() const {
  for (std::size_t i = 0; i < ports_.size(); ++i) {
    if (ports_[i]->has_backlog() && lab_.device(i).streams()) return true;
  }
  return false;
}

bool LabServer::batch_is_full() const {
  for (std::size_t i = 0; i < ports_.size(); ++i) {
    if (lab_.device(i).output_size() >= kBatch) return true;
  }
  return false;
}

void LabServer::hand_on_output() {
  for (std::size_t i = 0; i < ports_.size(); ++i) {
    ports_[i]->queue(lab_.device(i).take_output());
    ports_[i]->flush();
  }
}

void LabServer::advance() {
  hand_on_output();
  const std::int64_t start_ns = host_now_ns();
  const Tick target = clock_.allowed(start_ns, lab_.now());
  const auto slice_lasts = [start_ns] { return host_now_ns() - start_ns < kSlice_ns; };
  while (!reader_lags() && slice_lasts()) {
    Tick next = lab_.next_due();
    while (next <= target && !batch_is_full() && slice_lasts()) {
      lab_.advance_to(next);
      next = lab_.next_due();
    }
    hand_on_output();
    if (next > target) return;
  }
  if (reader_lags()) clock_.hold(host_now_ns(), lab_.now());
}

std::int64_t LabServer::idle_ns() const {
  const bool watches =
      (wire_ && wire_->port().needs_watching()) ||
      std::any_of(ports_.begin(), ports_.end(), [](const auto& port) { return port->needs_watching(); });
  const std::int64_t longest = watches ? kWatch_ns : kForever_ns;
  if (reader_lags()) return longest;
  const std::int64_t due_ns = std::max(clock_.ns_until(lab_.next_due(), host_now_ns()), kShortestWait_ns);
  return watches ? std::min(due_ns, longest) : due_ns;
}

void LabServer::run_until_readable(int stop_fd) {
  std::signal(SIGPIPE, SIG_IGN);
  bool stopped = false;
  while (!stopped) {
    for (const auto& port : ports_) port->watch();
    if (wire_) wire_->port().watch();
    advance();
    PollSet polls;
    polls.add(stop_fd, POLLIN, [&stopped](short) { stopped = true; });
    for (const auto& server : {chamber_.get(), fixture_.get(), relay_.get()}) server->add_to(polls);
    for (const auto& port : ports_) port->add_to(polls);
    if (wire_) wire_->port().add_to(polls);
    polls.wait(idle_ns());
  }
}

}  // namespace soak::hal::sim
