// SPDX-License-Identifier: Apache-2.0
#include "hal/usb/detail/bulk_stream.h"

#include <fmt/format.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <utility>

namespace soak::hal::usb {

// --- chips of FTDI

namespace {

constexpr std::size_t kStatusSize = 2;
constexpr double kClock_hz = 3e6;
constexpr double kMostDeviation = 0.03;
/// Codes of 0/8 … 7/8.
constexpr std::array<unsigned, 8> kFractionCodes = {0, 3, 2, 4, 1, 5, 6, 7};
constexpr unsigned kMostDivisor = 0x3FFF;

/// Requests of the chip, with values in the order in which they are sent.
struct Ft232Request {
  std::uint8_t request;
  std::uint16_t value;
};
constexpr std::uint8_t kBaud = 3;
constexpr std::array kRequests = {
    Ft232Request{0, 0},       // reset
    Ft232Request{0, 2},       // drop stale input
    Ft232Request{0, 1},       // drop stale output
    Ft232Request{4, 0x0008},  // 8 bits, no parity, 1 stop bit
    Ft232Request{2, 0},       // no flow control
    Ft232Request{9, 8},       // ms until a packet that is not full is sent
    Ft232Request{1, 0x0101},  // DTR on
    Ft232Request{1, 0x0202},  // RTS on
};

}  // namespace

std::optional<Ft232Divisor> ft232_divisor(int baud) {
  if (baud <= 0) return std::nullopt;
  const auto eighths = static_cast<unsigned>(std::lround(std::min(8.0 * kClock_hz / baud, 1e9)));
  if (eighths < 8 || eighths / 8 > kMostDivisor) return std::nullopt;
  if (std::abs(8.0 * kClock_hz / eighths - baud) > kMostDeviation * baud) return std::nullopt;
  // Between 3 and 1.5 megabaud the chip knows 2 only, and writes both ends in its own way.
  if (eighths == 8) return Ft232Divisor{0, 0};
  if (eighths == 12) return Ft232Divisor{1, 0};
  if (eighths < 16) return std::nullopt;
  const unsigned code = kFractionCodes[eighths % 8];
  return Ft232Divisor{static_cast<std::uint16_t>(eighths / 8 | (code & 3U) << 14U),
                      static_cast<std::uint16_t>(code >> 2U)};
}

void append_without_status(std::span<const std::uint8_t> transfer, std::size_t packet_size, base::Bytes& bytes) {
  while (transfer.size() > kStatusSize) {
    const auto packet = transfer.first(std::min(transfer.size(), packet_size));
    bytes.insert(bytes.end(), packet.begin() + kStatusSize, packet.end());
    transfer = transfer.subspan(packet.size());
  }
}

base::Status set_up_ft232(UsbHandle& handle, int baud) {
  const auto divisor = ft232_divisor(baud);
  if (!divisor)
    return base::bad_input(
        fmt::format("the chip does not support {} baud: use 184 to 3000000 (docs/hardware.md)", baud));
  for (const Ft232Request& request : kRequests) {
    if (auto done = handle.vendor_request(request.request, request.value, 0); !done) return done;
  }
  return handle.vendor_request(kBaud, divisor->value, divisor->index);
}

// --- the bytes of a device

namespace {

constexpr std::size_t kTransferSize = 4096;
constexpr std::size_t kMostToSend = 1024;
constexpr unsigned kSendTimeout_ms = 1000;
constexpr std::size_t kMostBuffered = 1U << 20U;
constexpr int kMostErrors = 3;
constexpr auto kLongestStop = std::chrono::seconds(2);
constexpr auto kCancelAgain = std::chrono::milliseconds(50);
constexpr const char* kGone = "the unit was unplugged";

std::string text_of_status(libusb_transfer_status status) {
  switch (status) {
    case LIBUSB_TRANSFER_STALL:
      return "an endpoint of the unit has stalled";
    case LIBUSB_TRANSFER_OVERFLOW:
      return "the unit sent more than was asked for";
    case LIBUSB_TRANSFER_TIMED_OUT:
      return "the unit does not take what is sent to it";
    case LIBUSB_TRANSFER_NO_DEVICE:
      return kGone;
    default:
      return "transfers end with errors: the unit was unplugged, or its cable is bad";
  }
}

}  // namespace

BulkStream::BulkStream(UsbContext& context, std::unique_ptr<UsbHandle> handle, const UsbDevice& device, Framing framing)
    : context_(context),
      handle_(std::move(handle)),
      device_(device),
      framing_(framing),
      event_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
  const BulkPair& pair = handle_->pair();
  const std::size_t size = std::max(kTransferSize - kTransferSize % pair.packet_size, pair.packet_size);
  for (Transfer& transfer : in_) transfer = make_transfer(pair.in, size, 0, on_in);
  out_ = make_transfer(pair.out, kMostToSend, kSendTimeout_ms, on_out);
  context_.add(this);
}

BulkStream::~BulkStream() { context_.remove(this); }

BulkStream::Transfer BulkStream::make_transfer(std::uint8_t endpoint, std::size_t size, unsigned timeout_ms,
                                               libusb_transfer_cb_fn callback) {
  Transfer transfer;
  transfer.raw.reset(libusb_alloc_transfer(0));
  transfer.buffer.resize(size);
  libusb_fill_bulk_transfer(transfer.raw.get(), handle_->raw(), endpoint, transfer.buffer.data(),
                            static_cast<int>(size), callback, this, timeout_ms);
  return transfer;
}

base::Status BulkStream::start() {
  for (Transfer& transfer : in_) {
    if (auto submitted = submit(transfer.raw.get()); !submitted) return submitted;
  }
  return {};
}

/// Counts the transfer in before it is submitted: it may come back at once.
base::Status BulkStream::submit(libusb_transfer* transfer) {
  {
    const std::lock_guard lock(mutex_);
    ++in_flight_;
  }
  const int code = libusb_submit_transfer(transfer);
  if (code == LIBUSB_SUCCESS) return {};
  const std::string why = code == LIBUSB_ERROR_NO_DEVICE ? kGone : "cannot submit a transfer: " + text_of_code(code);
  {
    const std::lock_guard lock(mutex_);
    fail(why);
  }
  one_less_in_flight();
  return base::fail(base::ErrorKind::device, why);
}

void BulkStream::stop() {
  const auto end = std::chrono::steady_clock::now() + kLongestStop;
  std::unique_lock lock(mutex_);
  stopping_ = true;
  while (in_flight_ > 0 && std::chrono::steady_clock::now() < end) {
    lock.unlock();
    // A transfer that was just being submitted again escapes the first time.
    cancel_all();
    lock.lock();
    came_back_.wait_for(lock, kCancelAgain, [this] { return in_flight_ == 0; });
  }
}

void BulkStream::cancel_all() {
  for (Transfer& transfer : in_) libusb_cancel_transfer(transfer.raw.get());
  libusb_cancel_transfer(out_.raw.get());
}

base::Result<std::size_t> BulkStream::read(std::span<std::uint8_t> buffer) {
  const std::lock_guard lock(mutex_);
  const std::size_t count = std::min(buffer.size(), buffer_.size() - begin_);
  std::copy_n(buffer_.begin() + static_cast<std::ptrdiff_t>(begin_), count, buffer.begin());
  begin_ += count;
  if (begin_ < buffer_.size()) return count;
  buffer_.clear();
  begin_ = 0;
  if (failure_) {
    if (count > 0) return count;
    return base::fail(base::ErrorKind::device, *failure_);
  }
  std::uint64_t ignored = 0;
  (void)!::read(event_.get(), &ignored, sizeof ignored);
  return count;
}

base::Result<std::size_t> BulkStream::write(std::span<const std::uint8_t> bytes) {
  const std::size_t count = std::min(bytes.size(), out_.buffer.size());
  {
    const std::lock_guard lock(mutex_);
    if (failure_) return base::fail(base::ErrorKind::device, *failure_);
    if (out_busy_ || count == 0) return 0;
    out_busy_ = true;
    std::copy_n(bytes.begin(), count, out_.buffer.begin());
    out_.raw->length = static_cast<int>(count);
  }
  if (auto submitted = submit(out_.raw.get()); !submitted) return base::forward_error(submitted);
  return count;
}

bool BulkStream::stalled() const {
  const std::lock_guard lock(mutex_);
  return stalled_;
}

void BulkStream::device_left(int bus, int number) {
  if (bus != device_.bus || number != device_.number) return;
  const std::lock_guard lock(mutex_);
  fail(kGone);
}

bool BulkStream::finished() const {
  const std::lock_guard lock(mutex_);
  return in_flight_ == 0;
}

// --- on the event thread

void BulkStream::on_in(libusb_transfer* transfer) {
  auto& own = *static_cast<BulkStream*>(transfer->user_data);
  if (own.take(*transfer)) (void)own.submit(transfer);
  own.one_less_in_flight();
}

void BulkStream::on_out(libusb_transfer* transfer) {
  auto& own = *static_cast<BulkStream*>(transfer->user_data);
  {
    const std::lock_guard lock(own.mutex_);
    own.out_busy_ = false;
    if (transfer->status == LIBUSB_TRANSFER_STALL) own.stalled_ = true;
    if (transfer->status != LIBUSB_TRANSFER_COMPLETED && !own.stopping_) own.fail(text_of_status(transfer->status));
  }
  own.one_less_in_flight();
}

bool BulkStream::take(const libusb_transfer& transfer) {
  const std::lock_guard lock(mutex_);
  if (transfer.status == LIBUSB_TRANSFER_COMPLETED) {
    errors_ = 0;
    take_bytes({transfer.buffer, static_cast<std::size_t>(transfer.actual_length)});
  } else if (!stopping_) {
    if (transfer.status == LIBUSB_TRANSFER_STALL) stalled_ = true;
    const bool may_pass = transfer.status == LIBUSB_TRANSFER_ERROR || transfer.status == LIBUSB_TRANSFER_OVERFLOW;
    if (!may_pass || ++errors_ >= kMostErrors) fail(text_of_status(transfer.status));
  }
  return !stopping_ && !failure_;
}

void BulkStream::take_bytes(std::span<const std::uint8_t> bytes) {
  if (buffer_.size() - begin_ > kMostBuffered) return;
  if (begin_ > buffer_.size() / 2) {
    buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(begin_));
    begin_ = 0;
  }
  const std::size_t before = buffer_.size();
  if (framing_ == Framing::ft232) {
    append_without_status(bytes, handle_->pair().packet_size, buffer_);
  } else {
    buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
  }
  if (before == begin_ && buffer_.size() > before) signal();
}

void BulkStream::fail(const std::string& why) {
  if (failure_) return;
  failure_ = why;
  signal();
}

void BulkStream::signal() {
  const std::uint64_t one = 1;
  (void)!::write(event_.get(), &one, sizeof one);
}

void BulkStream::one_less_in_flight() {
  // Under the lock to the end: whoever waits may destroy the stream as soon as the count is 0.
  const std::lock_guard lock(mutex_);
  --in_flight_;
  came_back_.notify_all();
}

}  // namespace soak::hal::usb
