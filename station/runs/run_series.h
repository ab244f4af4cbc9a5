// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "db/run/run_file.h"

/// What a page draws of a run file. Documents: docs/http-api.md.
namespace soak::station {

/// The streams that show something of `unit`: its samples, and those of no unit (the chamber's log), with their
/// channels: how many values each has, and how many a second.
[[nodiscard]] base::Result<nlohmann::json> streams_json(const db::RunFileReader& file, const std::string& unit);

/// Index of the stream of that name, of `unit` or of no unit; refuses (bad_input, where == "stream") another one and
/// names those that there are.
[[nodiscard]] base::Result<std::size_t> stream_named(const db::RunFileReader& file, const std::string& name,
                                                     const std::string& unit);

/// Channels of one stream over a span of time.
struct SeriesSpan {
  std::size_t stream = 0;
  std::vector<std::string> channels;
  std::optional<double> from_s;  ///< absent = from the first row on
  std::optional<double> to_s;    ///< absent = to the last row
  std::size_t points = 1000;
};

/// {"stream", "from_s", "to_s", "rows", "kind": "samples" or "buckets", "t_s", "channels"}: see docs/http-api.md.
/// Refuses (bad_input) an unknown channel (where == "channel") and a span that ends before it starts (where ==
/// "to_s").
[[nodiscard]] base::Result<nlohmann::json> series_json(const db::RunFileReader& file, const SeriesSpan& span);

}  // namespace soak::station
