// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "base/result.h"
#include "hal/links/detail/link.h"
#include "hal/maps/device_map.h"

namespace soak::hal {

/// What a controller holds of a quantity, or is to hold.
struct Content {
  double value = 0.0;
  std::string text;                  ///< for people: "23.25", "CONSTANT"
  std::vector<std::uint16_t> words;  ///< Modbus: the registers
  int decimals = 0;                  ///< Modbus: content of the decimals register
};

struct ProbeAnswer {
  bool as_expected = false;
  std::string found;
  std::string expected;
};

struct AlarmAnswer {
  bool active = false;
  std::string found;
};

/// A request that got no usable answer: of what, where that stands, and why.
struct NoAnswer {
  std::string what;
  std::string place;  ///< "register 2820", "'TEMP?'"
  std::string why;
};

template <class T>
using Answer = tl::expected<T, NoAnswer>;

/// What of a controller depends on what it speaks: how quantities, probes and alarms are asked for and written over its
/// link. The link is open when one of the calls that use it begins.
class Codec {
 public:
  Codec() = default;
  Codec(const Codec&) = delete;
  Codec& operator=(const Codec&) = delete;
  virtual ~Codec() = default;

  [[nodiscard]] virtual Link& link() = 0;
  /// The link was opened: what was learnt of the controller's habits may hold no longer.
  virtual void begin_connection() {}

  /// Where the controller keeps it, for messages: "register 2820", "field 2 of 'TEMP?'".
  [[nodiscard]] virtual std::string place(const Quantity& quantity) const = 0;
  [[nodiscard]] virtual std::string place(const Probe& probe) const = 0;
  [[nodiscard]] virtual std::string place(const AlarmRule& rule) const = 0;

  /// Quantities of the map in the order of their names, by as few requests as there may be.
  [[nodiscard]] virtual Answer<std::vector<Content>> read(const std::vector<std::string>& names) = 0;
  [[nodiscard]] virtual Answer<ProbeAnswer> read(const Probe& probe) = 0;
  [[nodiscard]] virtual Answer<std::vector<AlarmAnswer>> read(std::span<const AlarmRule> rules) = 0;

  /// Whether encode() needs what the controller holds at present.
  [[nodiscard]] virtual bool needs_held(const Quantity& /*quantity*/) const { return false; }
  /// The content that stands for a value. Refuses (bad_input) one that the controller's form cannot hold.
  [[nodiscard]] virtual base::Result<Content> encode(const Quantity& quantity, double value,
                                                     const Content& held) const = 0;
  /// Whether what the controller holds is what was or would be written.
  [[nodiscard]] virtual bool is_same(const Quantity& quantity, const Content& held, const Content& wanted) const = 0;
  /// Writes a quantity of the map; the controller must accept it.
  [[nodiscard]] virtual Answer<void> write(const std::string& name, const Content& content) = 0;
};

/// The codec of the map's protocol. The map must live as long as the codec.
[[nodiscard]] std::unique_ptr<Codec> make_codec(const DeviceMap& map);
[[nodiscard]] std::unique_ptr<Codec> make_modbus_codec(const DeviceMap& map);
[[nodiscard]] std::unique_ptr<Codec> make_text_codec(const DeviceMap& map);

}  // namespace soak::hal
