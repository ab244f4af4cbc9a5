// SPDX-License-Identifier: Apache-2.0
#include "hal/links/detail/modbus_link.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <modbus/modbus.h>
#include <netdb.h>
#include <sys/select.h>
#include <unistd.h>

#include <cerrno>
#include <cmath>
#include <thread>
#include <utility>

namespace soak::hal {
namespace {

constexpr int kBusyTries = 4;
constexpr int kSpoiltTries = 3;
constexpr std::chrono::milliseconds kBusyPause{100};
/// Between connecting and the first request; the F4T needs it (ESPEC's driver).
constexpr std::chrono::milliseconds kSettlingTime{100};
/// On a serial line. The silence of 3.5 characters that the standard asks for is too short for some controllers:
/// ESPEC's driver of the F4T waits so long.
constexpr double kSerialGap_s = 0.03;

modbus_t* new_context(const ControllerAddress& address) {
  constexpr int data_bits = 8;
  if (const auto* tcp = std::get_if<TcpAddress>(&address)) {
    return modbus_new_tcp_pi(tcp->host.c_str(), std::to_string(tcp->port).c_str());
  }
  const auto& line = std::get<SerialAddress>(address);
  return modbus_new_rtu(line.device.c_str(), line.baud, line.parity, data_bits, line.stop_bits);
}

void set_timeouts(modbus_t* context, double response_s) {
  const double whole_s = std::floor(response_s);
  modbus_set_response_timeout(context, static_cast<std::uint32_t>(whole_s),
                              static_cast<std::uint32_t>((response_s - whole_s) * 1e6));
  // Without a time-out between bytes, the one above holds for the whole answer: a peer that trickles cannot block us.
  modbus_set_byte_timeout(context, 0, 0);
}

/// libmodbus puts the descriptor into an fd_set, already while it connects, which aborts the process beyond its size.
bool descriptor_fits() {
  constexpr int spare = 16;  // others may open some in between
  const int lowest_free = ::open("/dev/null", O_RDONLY | O_CLOEXEC);
  if (lowest_free >= 0) ::close(lowest_free);
  return lowest_free >= 0 && lowest_free < FD_SETSIZE - spare;
}

/// libmodbus calls a host that nobody knows "Connection refused".
std::string connect_fault(const ControllerAddress& address, int code) {
  const auto* tcp = std::get_if<TcpAddress>(&address);
  if (tcp && code == ECONNREFUSED) {
    addrinfo* found = nullptr;
    const int failure = ::getaddrinfo(tcp->host.c_str(), nullptr, nullptr, &found);
    if (failure != 0) return fmt::format("unknown host '{}': {}", tcp->host, ::gai_strerror(failure));
    ::freeaddrinfo(found);
  }
  if (code == EINPROGRESS || code == ETIMEDOUT) return "cannot connect: no answer";
  return fmt::format("cannot connect: {}", modbus_strerror(code));
}

/// Number of the Modbus exception behind an errno of libmodbus; 0 = it is none.
int exception_of(int code) {
  const int exception = code - MODBUS_ENOBASE;
  return exception > 0 && exception < MODBUS_EXCEPTION_MAX ? exception : 0;
}

bool is_busy(int exception) {
  return exception == MODBUS_EXCEPTION_ACKNOWLEDGE || exception == MODBUS_EXCEPTION_SLAVE_OR_SERVER_BUSY;
}

/// Whether an answer came that is none to this request, or says that the controller failed: over TCP, where answers
/// carry the number of their request, and for a broken check sum, nothing late can be mistaken for the next answer.
bool is_spoilt(int code, const ControllerAddress& address) {
  if (code == EMBBADCRC || exception_of(code) == MODBUS_EXCEPTION_SLAVE_OR_SERVER_FAILURE) return true;
  const bool wrong =
      code == EMBBADDATA || code == EMBBADEXC || code == EMBUNKEXC || code == EMBMDATA || code == EMBBADSLAVE;
  return wrong && std::holds_alternative<TcpAddress>(address);
}

}  // namespace

double request_gap_s(const LinkSettings& settings) {
  const bool serial = std::holds_alternative<SerialAddress>(settings.address);
  return settings.gap_s.value_or(serial ? kSerialGap_s : 0.0);
}

struct ModbusLink::Port {
  explicit Port(modbus_t* made) : context(made) {}
  Port(const Port&) = delete;
  Port& operator=(const Port&) = delete;
  ~Port() {
    if (!context) return;
    modbus_close(context);
    modbus_free(context);
  }

  modbus_t* context;
};

ModbusLink::ModbusLink(LinkSettings settings) : Link(std::move(settings)) {}

ModbusLink::~ModbusLink() = default;

LinkResult ModbusLink::check_use() {
  if (owner_ == std::thread::id()) owner_ = std::this_thread::get_id();
  if (owner_ == std::this_thread::get_id()) return {};
  return tl::unexpected(LinkFault{"the link belongs to another thread"});
}

LinkResult ModbusLink::open_port() {
  const auto fail = [](std::string reason) { return tl::unexpected(LinkFault{std::move(reason)}); };
  if (!descriptor_fits()) return fail("too many open files: libmodbus cannot use a descriptor beyond 1023");
  auto port = std::make_unique<Port>(new_context(settings().address));
  if (!port->context) return fail(fmt::format("cannot set up the link: {}", modbus_strerror(errno)));
  if (modbus_set_slave(port->context, settings().unit) != 0) {
    return fail(fmt::format("unit {}: {}", settings().unit, modbus_strerror(errno)));
  }
  set_timeouts(port->context, settings().response_timeout_s);
  if (modbus_connect(port->context) != 0) return fail(connect_fault(settings().address, errno));
  port_ = std::move(port);
  std::this_thread::sleep_for(kSettlingTime);
  return {};
}

void ModbusLink::close_port() { port_.reset(); }

LinkFault ModbusLink::fault_of(int code) {
  LinkFault fault{modbus_strerror(code), exception_of(code)};
  if (fault.exception == 0) give_up(fault.text);
  return fault;
}

LinkResult ModbusLink::exchange(int count, const std::function<int()>& request) {
  int spoilt = 0;
  for (int attempt = 1;; ++attempt) {
    if (auto able = may_request(); !able) return able;
    std::this_thread::sleep_until(last_request_ + clock_time(request_gap_s(settings())));
    // What still lies in the buffer answers an earlier request.
    modbus_flush(port_->context);
    errno = 0;
    const int done = request();
    const int code = done < 0 ? errno : EMBBADDATA;
    last_request_ = Clock::now();
    if (done == count) return {};
    if (is_spoilt(code, settings().address) && ++spoilt < kSpoiltTries) continue;
    if (!is_busy(exception_of(code)) || attempt == kBusyTries) return tl::unexpected(fault_of(code));
    std::this_thread::sleep_for(kBusyPause);
  }
}

LinkResult ModbusLink::read(int function, int address, std::span<std::uint16_t> words) {
  const int count = static_cast<int>(words.size());
  auto* const read_registers = function == 4 ? &modbus_read_input_registers : &modbus_read_registers;
  return exchange(count, [&] { return read_registers(port_->context, address, count, words.data()); });
}

LinkResult ModbusLink::write(int function, int address, std::span<const std::uint16_t> words) {
  const int count = static_cast<int>(words.size());
  if (function == 6) {
    return exchange(count, [&] { return modbus_write_register(port_->context, address, words.front()); });
  }
  return exchange(count, [&] { return modbus_write_registers(port_->context, address, count, words.data()); });
}

}  // namespace soak::hal
