// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/result.h"
#include "hal/sim/wires/detail/file_descriptor.h"

namespace soak::hal::sim {

/// A TCP port of 127.0.0.1. What it accepts does not block and does not delay small packets.
class TcpListener {
 public:
  /// `port` 0 takes any free one. `send_buffer` limits what the system keeps of unsent bytes; 0 leaves its default.
  /// Errors: a port that cannot be had (bad_input).
  [[nodiscard]] static base::Result<TcpListener> open(int port, int send_buffer = 0);

  [[nodiscard]] int fd() const { return fd_.get(); }
  [[nodiscard]] int port() const { return port_; }
  /// The next connection, not open where there is none.
  [[nodiscard]] FileDescriptor accept() const;

 private:
  FileDescriptor fd_;
  int port_ = 0;
};

}  // namespace soak::hal::sim
