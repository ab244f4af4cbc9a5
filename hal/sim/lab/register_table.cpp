// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/lab/register_table.h"

#include <bit>
#include <cmath>
#include <cstddef>
#include <utility>

namespace soak::hal::sim {
namespace {

std::uint32_t raw_of(double value) { return std::bit_cast<std::uint32_t>(static_cast<float>(value)); }

double value_of(std::uint32_t raw) { return static_cast<double>(std::bit_cast<float>(raw)); }

std::uint32_t swapped(std::uint32_t raw) { return raw << 16 | raw >> 16; }

std::uint16_t word_of(std::uint32_t raw, int index) { return static_cast<std::uint16_t>(raw >> (16 * index)); }

}  // namespace

void RegisterTable::add_number(int address, int span, ReadNumber read, NumberWriter write) {
  Entry entry;
  entry.span = span;
  entry.writable = static_cast<bool>(write.takes);
  entry.read = [read = std::move(read)] { return static_cast<std::uint32_t>(read()) & 0xFFFFU; };
  entry.takes = [takes = std::move(write.takes)](std::uint32_t raw) { return takes(static_cast<int>(raw & 0xFFFFU)); };
  entry.store = [store = std::move(write.store)](std::uint32_t raw) { store(static_cast<int>(raw & 0xFFFFU)); };
  entries_[address] = std::move(entry);
}

void RegisterTable::add_value(int address, ReadValue read, ValueWriter write, FirstWord first) {
  const auto ordered = [first](std::uint32_t raw) { return first == FirstWord::low ? raw : swapped(raw); };
  Entry entry;
  entry.span = 2;
  entry.whole_only = true;
  entry.writable = static_cast<bool>(write.takes);
  entry.read = [ordered, read = std::move(read)] { return ordered(raw_of(read())); };
  entry.takes = [ordered, takes = std::move(write.takes)](std::uint32_t raw) {
    const double value = value_of(ordered(raw));
    return std::isfinite(value) && takes(value);
  };
  entry.store = [ordered, store = std::move(write.store)](std::uint32_t raw) { store(value_of(ordered(raw))); };
  entries_[address] = std::move(entry);
}

RegisterTable::Entries::const_iterator RegisterTable::entry_at(int address) const {
  auto after = entries_.upper_bound(address);
  if (after == entries_.begin()) return entries_.end();
  const auto entry = std::prev(after);
  return address < entry->first + entry->second.span ? entry : entries_.end();
}

ModbusAnswer RegisterTable::read(int address, std::span<std::uint16_t> words) const {
  for (std::size_t i = 0; i < words.size();) {
    const int place = address + static_cast<int>(i);
    const auto entry = entry_at(place);
    if (entry == entries_.end() && elsewhere_) {
      words[i++] = *elsewhere_;
      continue;
    }
    if (entry == entries_.end()) return ModbusAnswer::illegal_address;
    // Read once, so that both words of a value are of the same moment.
    const std::uint32_t raw = entry->second.read();
    for (int part = place - entry->first; part < entry->second.span && i < words.size(); ++part) {
      words[i++] = word_of(raw, part);
    }
  }
  return ModbusAnswer::done;
}

ModbusAnswer RegisterTable::walk_write(int address, std::span<const std::uint16_t> words, bool store) const {
  for (std::size_t i = 0; i < words.size();) {
    const int place = address + static_cast<int>(i);
    const auto found = entry_at(place);
    if (found == entries_.end() && elsewhere_) {
      ++i;
      continue;
    }
    if (found == entries_.end() || !found->second.writable) return ModbusAnswer::illegal_address;
    const Entry& entry = found->second;
    const std::size_t rest = words.size() - i;
    const bool whole = place == found->first && rest >= static_cast<std::size_t>(entry.span);
    if (place != found->first || (entry.whole_only && !whole)) return ModbusAnswer::illegal_value;
    std::uint32_t raw = words[i++];
    if (whole && entry.span == 2) raw |= static_cast<std::uint32_t>(words[i++]) << 16;
    if (!entry.whole_only && raw > 0xFFFF) return ModbusAnswer::illegal_value;
    if (!store && !entry.takes(raw)) return ModbusAnswer::illegal_value;
    if (store) entry.store(raw);
  }
  return ModbusAnswer::done;
}

ModbusAnswer RegisterTable::write(int address, std::span<const std::uint16_t> words) {
  const ModbusAnswer checked = walk_write(address, words, false);
  return checked == ModbusAnswer::done ? walk_write(address, words, true) : checked;
}

}  // namespace soak::hal::sim
