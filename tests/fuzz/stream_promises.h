// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "tests/fuzz/targets.h"

namespace soak::fuzz {

/// What all decoders of streams promise. `Decoder` has append(), next(), garbage_bytes(), pending_bytes(); `describe`
/// makes of a message something that can be compared; `size` tells its bytes. Returns how many messages there were.
template <class Decoder, class Describe, class Size>
std::size_t check_stream(Input input, std::size_t most_pending, Describe describe, Size size) {
  using Message = decltype(describe(*Decoder().next()));
  std::vector<Message> whole;
  std::size_t framed = 0;
  const auto drain = [&](Decoder& decoder, std::vector<Message>& messages, bool count) {
    while (const auto message = decoder.next()) {
      messages.push_back(describe(*message));
      if (count) framed += size(*message);
    }
    require(decoder.pending_bytes() <= most_pending, "the memory is bounded");
  };
  Decoder at_once;
  at_once.append(input);
  drain(at_once, whole, true);
  require(framed + at_once.garbage_bytes() + at_once.pending_bytes() == input.size(), "every byte is accounted for");
  // The first byte tells the size of the pieces.
  const std::size_t piece = input.empty() ? 1 : 1 + input[0] % 61;
  Decoder in_pieces;
  std::vector<Message> split;
  for (std::size_t at = 0; at < input.size(); at += piece) {
    in_pieces.append(input.subspan(at, std::min(piece, input.size() - at)));
    drain(in_pieces, split, false);
  }
  require(split == whole, "any split of the stream gives the same messages");
  while (at_once.drop_partial()) drain(at_once, whole, false);
  require(at_once.pending_bytes() == 0, "what does not end can be given up");
  return whole.size();
}

}  // namespace soak::fuzz
