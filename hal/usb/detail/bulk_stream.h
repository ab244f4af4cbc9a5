// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <libusb-1.0/libusb.h>

#include <array>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/bytes.h"
#include "base/file_descriptor.h"
#include "base/result.h"
#include "hal/links/detail/byte_source.h"
#include "hal/usb/detail/usb_context.h"

namespace soak::hal::usb {

// --- chips of FTDI: a serial line behind bulk endpoints

/// The number for a baud rate: 3 MHz by eighths, whose code stands in the two upper bits of the value and in the index.
struct Ft232Divisor {
  std::uint16_t value = 0;
  std::uint16_t index = 0;
};

/// Nothing for a rate that the chip misses by more than 3 %, the most that a serial line bears.
[[nodiscard]] std::optional<Ft232Divisor> ft232_divisor(int baud);

/// Appends to `bytes` what a transfer brought without the two status bytes at the head of each packet of
/// `packet_size`.
void append_without_status(std::span<const std::uint8_t> transfer, std::size_t packet_size, base::Bytes& bytes);

/// Makes the chip a serial line 8N1 without flow control, with DTR and RTS on, and drops what it still has from before.
/// Errors: bad_input for a baud rate that it does not have, `device`.
[[nodiscard]] base::Status set_up_ft232(UsbHandle& handle, int baud);

// --- the bytes of a device

/// The bytes of a pair of bulk endpoints. Eight transfers wait for what comes; the event thread takes them, puts their
/// bytes into a buffer and submits them again. fd() is readable while there are bytes, or the device has failed.
///
/// The device counts as failed when it has left the bus, an endpoint stalls, or three transfers in a row end with an
/// error (some hosts report nothing else of a device that was unplugged). Of 1 MiB that nobody reads the newest bytes
/// are dropped. All but the callbacks is for one thread.
class BulkStream final : public UsbListener {
 public:
  enum class Framing : std::uint8_t {
    plain,
    ft232,  ///< each packet begins with two status bytes
  };

  BulkStream(UsbContext& context, std::unique_ptr<UsbHandle> handle, const UsbDevice& device, Framing framing);
  ~BulkStream() override;

  /// Submits the transfers. Error `device` if the bus does not take them.
  [[nodiscard]] base::Status start();
  /// Cancels the transfers and waits until they have come back, for two seconds at most; finished() tells whether they
  /// have.
  void stop();

  /// Takes what is there; 0 = nothing now. Error `device` once the device has failed and all was read.
  [[nodiscard]] base::Result<std::size_t> read(std::span<std::uint8_t> buffer);
  /// Sends at most 1 KiB; 0 = the last piece is still on its way.
  [[nodiscard]] base::Result<std::size_t> write(std::span<const std::uint8_t> bytes);
  [[nodiscard]] int fd() const { return event_.get(); }
  /// An endpoint has stalled: it works again after UsbHandle::clear_halt().
  [[nodiscard]] bool stalled() const;

  void device_left(int bus, int number) override;
  [[nodiscard]] bool finished() const override;

 private:
  static constexpr std::size_t kTransfers = 8;

  struct FreeTransfer {
    void operator()(libusb_transfer* transfer) const { libusb_free_transfer(transfer); }
  };
  struct Transfer {
    std::unique_ptr<libusb_transfer, FreeTransfer> raw;
    base::Bytes buffer;
  };

  [[nodiscard]] Transfer make_transfer(std::uint8_t endpoint, std::size_t size, unsigned timeout_ms,
                                       libusb_transfer_cb_fn callback);
  [[nodiscard]] base::Status submit(libusb_transfer* transfer);
  void cancel_all();
  static void LIBUSB_CALL on_in(libusb_transfer* transfer);
  static void LIBUSB_CALL on_out(libusb_transfer* transfer);
  /// Whether the transfer is to be submitted again.
  bool take(const libusb_transfer& transfer);
  void take_bytes(std::span<const std::uint8_t> bytes);
  /// With the lock held.
  void fail(const std::string& why);
  void signal();
  void one_less_in_flight();

  UsbContext& context_;
  std::unique_ptr<UsbHandle> handle_;
  UsbDevice device_;
  Framing framing_;
  base::FileDescriptor event_;
  std::array<Transfer, kTransfers> in_;
  Transfer out_;

  mutable std::mutex mutex_;
  std::condition_variable came_back_;
  std::size_t in_flight_ = 0;
  bool stopping_ = false;
  bool out_busy_ = false;
  bool stalled_ = false;
  int errors_ = 0;  ///< in a row
  std::optional<std::string> failure_;
  base::Bytes buffer_;
  std::size_t begin_ = 0;  ///< of what is not yet read
};

}  // namespace soak::hal::usb
