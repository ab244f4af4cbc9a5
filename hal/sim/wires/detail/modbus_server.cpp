// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/wires/detail/modbus_server.h"

#include <modbus/modbus.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <utility>

#include "base/bytes.h"

namespace soak::hal::sim {
namespace {

// libmodbus waits with select(), which knows descriptors below 1024 only.
constexpr std::size_t kMaxClients = 16;
constexpr int kRegisterCount = 65536;
constexpr std::uint32_t kByteTimeout_us = 20'000;

constexpr std::size_t kHeaderSize = 7;  // transaction, protocol, length, unit
constexpr std::size_t kCountedFromByte = 6;
constexpr std::size_t kMinFrame = 8;
constexpr std::size_t kMaxFrame = MODBUS_TCP_MAX_ADU_LENGTH;
constexpr std::size_t kTcpFixedRequest = 12;  // functions 3 and 6
constexpr std::size_t kTcpWriteHeader = 13;   // function 16 up to its byte count

/// Size of the frame whose first bytes are given; nothing where it is none.
std::optional<std::size_t> frame_size(std::span<const std::uint8_t> start) {
  const std::size_t size = kCountedFromByte + base::big_endian_u16(start, 4);
  if (base::big_endian_u16(start, 2) != 0 || size < kMinFrame || size > kMaxFrame) return std::nullopt;
  return size;
}

/// Whether the length in the header is that of the request: libmodbus goes by the request alone.
bool is_consistent(std::span<const std::uint8_t> frame) {
  switch (frame[kHeaderSize]) {
    case MODBUS_FC_READ_HOLDING_REGISTERS:
    case MODBUS_FC_WRITE_SINGLE_REGISTER:
      return frame.size() == kTcpFixedRequest;
    case MODBUS_FC_WRITE_MULTIPLE_REGISTERS:
      return frame.size() > kTcpWriteHeader && frame.size() == kTcpWriteHeader + frame[kTcpWriteHeader - 1];
    default:
      return true;
  }
}

bool is_supported(std::uint8_t function) {
  return function == MODBUS_FC_READ_HOLDING_REGISTERS || function == MODBUS_FC_WRITE_SINGLE_REGISTER ||
         function == MODBUS_FC_WRITE_MULTIPLE_REGISTERS;
}

void wake_at(int fd, std::size_t bytes) {
  const int count = static_cast<int>(bytes);
  setsockopt(fd, SOL_SOCKET, SO_RCVLOWAT, &count, sizeof count);
}

}  // namespace

void ModbusServer::ContextDeleter::operator()(_modbus* context) const { modbus_free(context); }

void ModbusServer::MappingDeleter::operator()(_modbus_mapping_t* mapping) const { modbus_mapping_free(mapping); }

base::Result<std::unique_ptr<ModbusServer>> ModbusServer::open(int port, RegisterTable& registers) {
  auto listener = TcpListener::open(port);
  if (!listener) return base::forward_error(listener);
  std::unique_ptr<ModbusServer> server(new ModbusServer(*std::move(listener), registers));
  if (!server->context_ || !server->mapping_) return base::fail(base::ErrorKind::internal, "libmodbus has no memory");
  modbus_set_byte_timeout(server->context_.get(), 0, kByteTimeout_us);
  return server;
}

ModbusServer::ModbusServer(TcpListener listener, RegisterTable& registers)
    : listener_(std::move(listener)),
      registers_(registers),
      context_(modbus_new_tcp("127.0.0.1", listener_.port())),
      mapping_(modbus_mapping_new_start_address(0, 0, 0, 0, 0, kRegisterCount, 0, 0)) {}

ModbusServer::~ModbusServer() = default;

void ModbusServer::add_to(PollSet& polls) {
  polls.add(listener_.fd(), POLLIN, [this](short) { accept_client(); });
  for (const base::FileDescriptor& client : clients_) {
    const int fd = client.get();
    polls.add(fd, POLLIN | POLLRDHUP, [this, fd](short events) { serve_client(fd, events); });
  }
}

void ModbusServer::accept_client() {
  base::FileDescriptor client = listener_.accept();
  if (!client || clients_.size() == kMaxClients) return;
  wake_at(client.get(), kMinFrame);
  clients_.push_back(std::move(client));
}

void ModbusServer::drop_client(int fd) {
  std::erase_if(clients_, [fd](const base::FileDescriptor& client) { return client.get() == fd; });
}

// A request is given to libmodbus when all of it has come: until then nothing is taken from the socket, and the socket
// does not count as readable.
void ModbusServer::serve_client(int fd, short events) {
  std::array<std::uint8_t, kMaxFrame> bytes;
  const ssize_t seen = recv(fd, bytes.data(), bytes.size(), MSG_PEEK | MSG_DONTWAIT);
  const bool ended = (events & (POLLRDHUP | POLLHUP | POLLERR)) != 0;
  const std::size_t count = seen > 0 ? static_cast<std::size_t>(seen) : 0;
  if (count < kMinFrame) {
    if (ended || seen == 0) drop_client(fd);
    return;
  }
  const auto size = frame_size(bytes);
  if (size && count < *size && !ended) {
    wake_at(fd, *size);
    return;
  }
  const bool complete = size && count >= *size && is_consistent(std::span(bytes).first(*size));
  if (!complete || !serve_request(fd, *size)) {
    drop_client(fd);
    return;
  }
  wake_at(fd, kMinFrame);
}

bool ModbusServer::serve_request(int fd, std::size_t size) {
  // libmodbus takes the request in pieces, and waits for each with select().
  wake_at(fd, 1);
  modbus_set_socket(context_.get(), fd);
  std::vector<std::uint8_t> request(kMaxFrame);
  const int received = modbus_receive(context_.get(), request.data());
  if (received < static_cast<int>(kMinFrame)) return false;
  // libmodbus takes one byte only of a function that it does not know.
  std::size_t rest = size - std::min(size, static_cast<std::size_t>(received));
  std::array<std::uint8_t, kMaxFrame> ignored;
  if (rest > 0 && recv(fd, ignored.data(), rest, MSG_DONTWAIT) != static_cast<ssize_t>(rest)) return false;

  const ModbusAnswer answer = carry_out(request);
  if (answer == ModbusAnswer::done) {
    return modbus_reply(context_.get(), request.data(), received, mapping_.get()) >= 0;
  }
  return modbus_reply_exception(context_.get(), request.data(), static_cast<unsigned>(answer)) >= 0;
}

ModbusAnswer ModbusServer::carry_out(const std::vector<std::uint8_t>& request) {
  const std::uint8_t function = request[kHeaderSize];
  if (!is_supported(function)) return ModbusAnswer::illegal_function;
  const int address = base::big_endian_u16(request, 8);
  const std::uint16_t argument = base::big_endian_u16(request, 10);
  if (function == MODBUS_FC_WRITE_SINGLE_REGISTER) return registers_.write(address, std::span(&argument, 1));

  const bool reads = function == MODBUS_FC_READ_HOLDING_REGISTERS;
  const int most = reads ? MODBUS_MAX_READ_REGISTERS : MODBUS_MAX_WRITE_REGISTERS;
  if (argument < 1 || argument > most) return ModbusAnswer::illegal_value;
  if (address + argument > kRegisterCount) return ModbusAnswer::illegal_address;
  if (reads) return registers_.read(address, std::span(mapping_->tab_registers + address, argument));

  if (request[kTcpWriteHeader - 1] != 2 * argument) return ModbusAnswer::illegal_value;
  std::vector<std::uint16_t> words(argument);
  for (std::size_t i = 0; i < words.size(); ++i) words[i] = base::big_endian_u16(request, kTcpWriteHeader + 2 * i);
  return registers_.write(address, words);
}

}  // namespace soak::hal::sim
