// SPDX-License-Identifier: Apache-2.0
// Quantities, probes and alarms of a register map as registers.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <tuple>
#include <utility>

#include "hal/devices/detail/codec.h"
#include "hal/links/detail/modbus_link.h"
#include "hal/maps/detail/registers.h"

namespace soak::hal {
namespace {

constexpr int kReadHolding = 3;

/// Registers that belong together and are read by one request, or one request for several of them.
struct RegisterSpan {
  int function = kReadHolding;
  int address = 0;
  int count = 1;
  std::string name;        ///< of what they carry, for messages
  bool has_holes = false;  ///< of a request: it covers registers that nobody asked for
};

/// Takes `span` into `block` if one request of at most `max_block` registers can cover both.
bool extend_block(RegisterSpan& block, const RegisterSpan& span, int max_block, bool over_holes) {
  const int end = block.address + block.count;
  const int new_end = std::max(end, span.address + span.count);
  if (block.function != span.function || new_end - block.address > max_block) return false;
  if (span.address > end && !over_holes) return false;
  block.has_holes = block.has_holes || span.address > end;
  block.count = new_end - block.address;
  block.name += ", " + span.name;
  return true;
}

/// Groups spans into as few requests as their order allows; no span is torn apart. Without `over_holes` a request
/// covers only registers that were asked for.
std::vector<RegisterSpan> plan_blocks(std::vector<RegisterSpan> spans, int max_block, bool over_holes) {
  std::sort(spans.begin(), spans.end(), [](const RegisterSpan& a, const RegisterSpan& b) {
    return std::tie(a.function, a.address) < std::tie(b.function, b.address);
  });
  std::vector<RegisterSpan> blocks;
  for (const RegisterSpan& span : spans) {
    if (blocks.empty() || !extend_block(blocks.back(), span, max_block, over_holes)) blocks.push_back(span);
  }
  return blocks;
}

class ModbusCodec final : public Codec {
 public:
  explicit ModbusCodec(const DeviceMap& map) : map_(map), link_(map.link) {}

  Link& link() override { return link_; }
  void begin_connection() override { over_holes_ = true; }

  std::string place(const Quantity& quantity) const override {
    return registers_text(quantity.modbus.address, word_count(quantity.modbus.type));
  }
  std::string place(const Probe& probe) const override { return registers_text(probe.modbus.address, 1); }
  std::string place(const AlarmRule& rule) const override {
    const auto& addresses = rule.modbus.addresses;
    return fmt::format("register{} {}", addresses.size() == 1 ? "" : "s", fmt::join(addresses, ", "));
  }

  Answer<std::vector<Content>> read(const std::vector<std::string>& names) override {
    std::vector<RegisterSpan> spans;
    for (const std::string& name : names) append_spans(name, spans);
    const auto image = fetch(spans);
    if (!image) return tl::unexpected(image.error());
    std::vector<Content> contents;
    for (const std::string& name : names) {
      auto held = content(name, *image);
      if (!held) return tl::unexpected(std::move(held.error()));
      contents.push_back(*std::move(held));
    }
    return contents;
  }

  Answer<ProbeAnswer> read(const Probe& probe) override {
    const RegisterProbe& asked = probe.modbus;
    const auto image = fetch({{kReadHolding, asked.address, word_count(asked.type), probe.name}});
    if (!image) return tl::unexpected(image.error());
    RegisterPlace place;
    place.type = asked.type;
    const std::uint16_t word = image->at({kReadHolding, asked.address});
    const int found = static_cast<int>(decode_value(place, {&word, 1}, 0));
    const bool known = std::find(asked.expected.begin(), asked.expected.end(), found) != asked.expected.end();
    return ProbeAnswer{known, fmt::format("{}", found), fmt::format("{}", fmt::join(asked.expected, " or "))};
  }

  Answer<std::vector<AlarmAnswer>> read(std::span<const AlarmRule> rules) override {
    std::vector<RegisterSpan> spans;
    for (const AlarmRule& rule : rules) {
      for (const int address : rule.modbus.addresses) spans.push_back({kReadHolding, address, 1, rule.name});
    }
    const auto image = fetch(spans);
    if (!image) return tl::unexpected(image.error());
    std::vector<AlarmAnswer> answers;
    for (const AlarmRule& rule : rules) {
      std::vector<int> contents;
      for (const int address : rule.modbus.addresses) contents.push_back(image->at({kReadHolding, address}));
      const bool active =
          std::any_of(contents.begin(), contents.end(), [&](int content) { return says_alarm(rule.modbus, content); });
      answers.push_back({active, fmt::format("{}", fmt::join(contents, ", "))});
    }
    return answers;
  }

  bool needs_held(const Quantity& quantity) const override { return quantity.modbus.decimals_register.has_value(); }

  base::Result<Content> encode(const Quantity& quantity, double value, const Content& held) const override {
    auto words = encode_value(quantity.modbus, value, held.decimals);
    if (!words) return base::forward_error(words);
    return content_of(quantity.modbus, *std::move(words), held.decimals);
  }

  bool is_same(const Quantity& quantity, const Content& held, const Content& wanted) const override {
    return same_value(quantity.modbus, held.words, wanted.words);
  }

  Answer<void> write(const std::string& name, const Content& content) override {
    const Quantity& quantity = map_.quantities.at(name);
    const auto done = link_.write(*quantity.modbus.write_function, quantity.modbus.address, content.words);
    if (done) return {};
    return tl::unexpected(NoAnswer{"writing " + name, place(quantity), done.error().text});
  }

 private:
  /// Content of registers by function and address.
  using Image = std::map<std::pair<int, int>, std::uint16_t>;

  static Content content_of(const RegisterPlace& place, Words words, int decimals) {
    const double value = decode_value(place, words, decimals);
    return {value, fmt::format("{:.6g}", value), std::move(words), decimals};
  }

  void append_spans(const std::string& name, std::vector<RegisterSpan>& spans) const {
    const RegisterPlace& place = map_.quantities.at(name).modbus;
    spans.push_back({place.read_function, place.address, word_count(place.type), name});
    if (place.decimals_register) {
      spans.push_back({place.read_function, *place.decimals_register, 1, "decimals of " + name});
    }
  }

  Answer<Content> content(const std::string& name, const Image& image) const {
    const RegisterPlace& place = map_.quantities.at(name).modbus;
    Words words;
    for (int i = 0; i < word_count(place.type); ++i)
      words.push_back(image.at({place.read_function, place.address + i}));
    if (!place.decimals_register) return content_of(place, std::move(words), 0);
    const int decimals = image.at({place.read_function, *place.decimals_register});
    if (decimals <= kMaxDecimals) return content_of(place, std::move(words), decimals);
    return tl::unexpected(NoAnswer{name, registers_text(*place.decimals_register, 1),
                                   fmt::format("its decimals are {}, more than {}", decimals, kMaxDecimals)});
  }

  Answer<Image> fetch(const std::vector<RegisterSpan>& spans) {
    Image image;
    for (const RegisterSpan& block : plan_blocks(spans, map_.link.max_block, over_holes_)) {
      Words words(static_cast<std::size_t>(block.count));
      const LinkResult done = link_.read(block.function, block.address, words);
      if (!done && done.error().exception != 0 && block.has_holes) {
        // It refuses registers that it lacks, although nobody needs them.
        over_holes_ = false;
        return fetch(spans);
      }
      if (!done) {
        return tl::unexpected(NoAnswer{block.name, registers_text(block.address, block.count), done.error().text});
      }
      for (int i = 0; i < block.count; ++i) {
        image[{block.function, block.address + i}] = words[static_cast<std::size_t>(i)];
      }
    }
    return image;
  }

  const DeviceMap& map_;
  ModbusLink link_;
  bool over_holes_ = true;  ///< the controller has not yet refused a block with registers that it lacks
};

}  // namespace

std::unique_ptr<Codec> make_modbus_codec(const DeviceMap& map) { return std::make_unique<ModbusCodec>(map); }

}  // namespace soak::hal
