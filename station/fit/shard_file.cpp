// SPDX-License-Identifier: Apache-2.0
#include "station/fit/shard_file.h"

#include <fmt/format.h>

#include <array>
#include <cerrno>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <system_error>
#include <utility>

#include "base/text.h"
#include "db/durable.h"
#include "station/io/host.h"

namespace soak::station {
namespace {

using nlohmann::json;

constexpr std::string_view kShardFormat = "soak-shard-1";
constexpr int kMostShards = 100000;
/// A model takes some 100 kB; a file without line ends must not fill the memory.
constexpr std::size_t kLongestLine_bytes = std::size_t{32} << 20;

constexpr std::array kResults = {ShardResult::fitted, ShardResult::up_to_date, ShardResult::waits_for_fleet,
                                 ShardResult::failed};

json head_json(const ShardHead& head) {
  return {{"format", kShardFormat},
          {"shard", head.part.shard},
          {"of", head.part.of},
          {"software", head.software},
          {"user", head.user},
          {"campaign", head.campaign ? json(*head.campaign) : json()},
          {"rules", head.rules ? json(*head.rules) : json()}};
}

/// Throws json::exception.
ShardHead head_of(const json& document) {
  ShardHead head;
  document.at("shard").get_to(head.part.shard);
  document.at("of").get_to(head.part.of);
  document.at("software").get_to(head.software);
  document.at("user").get_to(head.user);
  if (!document.at("campaign").is_null()) head.campaign = document["campaign"].get<std::string>();
  if (!document.at("rules").is_null()) head.rules = document["rules"].get<int>();
  return head;
}

json entry_json(const ShardEntry& entry) {
  json document = {{"unit", entry.unit}, {"result", name_of(entry.result)}};
  if (entry.result == ShardResult::failed) document["failure"] = entry.failure;
  if (entry.result != ShardResult::fitted) return document;
  document["model"] = entry.version;
  document["epoch"] = entry.epoch;
  document["created_utc_s"] = entry.created_utc_s;
  document["inputs_sha256"] = entry.inputs_sha256;
  document["document"] = entry.document;
  return document;
}

/// Throws json::exception.
ShardEntry entry_of(const json& document) {
  ShardEntry entry;
  document.at("unit").get_to(entry.unit);
  const auto named = document.at("result").get<std::string>();
  entry.result = ShardResult::failed;
  for (const ShardResult result : kResults) {
    if (name_of(result) == named) entry.result = result;
  }
  if (entry.result == ShardResult::failed) document.at("failure").get_to(entry.failure);
  if (entry.result != ShardResult::fitted) return entry;
  document.at("model").get_to(entry.version);
  document.at("epoch").get_to(entry.epoch);
  document.at("created_utc_s").get_to(entry.created_utc_s);
  document.at("inputs_sha256").get_to(entry.inputs_sha256);
  document.at("document").get_to(entry.document);
  return entry;
}

/// The next line of a file; nothing at its end. Fails (corrupt) for one that is too long.
base::Result<std::optional<std::string>> next_line(std::ifstream& in, const std::string& where) {
  std::string line;
  for (int c = in.get(); c != std::char_traits<char>::eof(); c = in.get()) {
    if (c == '\n') return line;
    if (line.size() == kLongestLine_bytes) return base::corrupt("a line is too long for a shard", where);
    line.push_back(static_cast<char>(c));
  }
  if (line.empty()) return std::nullopt;
  return line;
}

/// Empty where the document states none.
std::string format_of(const json& document) {
  if (!document.is_object() || !document.contains("format") || !document["format"].is_string()) return {};
  return document["format"];
}

bool is_part(std::int64_t shard, std::int64_t of) { return shard >= 1 && shard <= of && of <= kMostShards; }

base::Result<ShardHead> read_head(const std::optional<std::string>& line, const std::string& where) {
  const json document = line ? json::parse(*line, nullptr, false) : json();
  const std::string format = format_of(document);
  if (!format.starts_with("soak-shard-")) {
    return base::bad_input("is no result shard: give files that 'soak fit --all --shard' wrote", where);
  }
  if (format != kShardFormat) {
    return base::bad_input(
        fmt::format("has the format {}, which a newer version of Soak reads; this one reads {}", format, kShardFormat),
        where);
  }
  try {
    ShardHead head = head_of(document);
    if (!is_part(head.part.shard, head.part.of)) {
      return base::corrupt(
          fmt::format(
              "the first line of the shard says shard {} of {}; I of N can be, with I from 1 to N and N up to {}",
              head.part.shard, head.part.of, kMostShards),
          where);
    }
    // They go into records that nobody can change.
    if (base::is_plain_line(head.user) && base::is_plain_line(head.software)) return head;
    return base::corrupt("the first line of the shard holds a name that is no plain text", where);
  } catch (const json::exception& error) {
    return base::corrupt(fmt::format("the first line of the shard is damaged: {}", error.what()), where);
  }
}

/// A number of the environment.
std::optional<std::int64_t> environment_number(const char* name) {
  const char* value = std::getenv(name);
  return value != nullptr ? base::parse_int(value) : std::nullopt;
}

base::Result<ShardPart> part_of_slurm() {
  const auto id = environment_number("SLURM_ARRAY_TASK_ID");
  const auto count = environment_number("SLURM_ARRAY_TASK_COUNT");
  const auto first = environment_number("SLURM_ARRAY_TASK_MIN");
  const auto last = environment_number("SLURM_ARRAY_TASK_MAX");
  if (!id || !count || !first || !last) {
    return base::bad_input(
        "slurm needs a task of a Slurm job array (sbatch --array=1-8): SLURM_ARRAY_TASK_ID is not set");
  }
  const bool is_whole = *last - *first + 1 == *count && *id >= *first && *id <= *last && *count <= kMostShards;
  if (!is_whole) {
    return base::bad_input(
        "slurm needs an array without gaps, as --array=1-8 is; to run some shards of a larger number again give "
        "them as I/N");
  }
  return ShardPart{static_cast<int>(*id - *first + 1), static_cast<int>(*count)};
}

}  // namespace

base::Result<ShardPart> parse_shard_part(const std::string& text) {
  if (text == "slurm") return part_of_slurm();
  const auto slash = text.find('/');
  const std::int64_t shard = base::parse_int(text.substr(0, slash)).value_or(0);
  const std::int64_t of = slash == std::string::npos ? 0 : base::parse_int(text.substr(slash + 1)).value_or(0);
  if (!is_part(shard, of)) {
    return base::bad_input(fmt::format("must be I/N with I from 1 to N and N up to {}, or slurm", kMostShards));
  }
  return ShardPart{static_cast<int>(shard), static_cast<int>(of)};
}

std::string_view name_of(ShardResult result) {
  switch (result) {
    case ShardResult::fitted:
      return "fitted";
    case ShardResult::up_to_date:
      return "up_to_date";
    case ShardResult::waits_for_fleet:
      return "waits_for_fleet";
    case ShardResult::failed:
      return "failed";
  }
  return "";
}

// Writing.

ShardWriter::ShardWriter(std::filesystem::path file, std::filesystem::path temporary)
    : file_(std::move(file)), temporary_(std::move(temporary)), out_(temporary_, std::ios::binary | std::ios::trunc) {}

ShardWriter::ShardWriter(ShardWriter&& other) noexcept
    : file_(std::move(other.file_)),
      temporary_(std::exchange(other.temporary_, {})),
      out_(std::move(other.out_)),
      hash_(other.hash_),
      entries_(other.entries_) {}

ShardWriter::~ShardWriter() {
  std::error_code ignored;
  if (!temporary_.empty()) std::filesystem::remove(temporary_, ignored);
}

base::Result<ShardWriter> ShardWriter::create(const std::filesystem::path& file, const ShardHead& head) {
  // Process numbers of two machines may be the same: a task that was thought dead must not write into its successor's.
  ShardWriter writer(file, file.string() + ".tmp-" + new_run_id());
  if (!writer.out_) {
    return base::bad_input("cannot create the file: " + std::generic_category().message(errno), file.string());
  }
  if (auto written = writer.write_line(head_json(head).dump()); !written) return base::forward_error(written);
  return writer;
}

base::Status ShardWriter::write_line(const std::string& line) {
  hash_.update(line);
  hash_.update("\n");
  out_ << line << '\n';
  if (out_) return {};
  return base::fail(base::ErrorKind::internal, "cannot write the shard: " + std::generic_category().message(errno),
                    file_.string());
}

base::Status ShardWriter::add(const ShardEntry& entry) {
  ++entries_;
  return write_line(entry_json(entry).dump());
}

base::Result<std::string> ShardWriter::finish() {
  base::Sha256 all_before = hash_;
  std::string sha256 = base::to_hex(all_before.finish());
  if (auto written = write_line(json{{"entries", entries_}, {"sha256", sha256}}.dump()); !written) {
    return base::forward_error(written);
  }
  out_.close();
  if (!out_) {
    return base::fail(base::ErrorKind::internal, "cannot write the shard: " + std::generic_category().message(errno),
                      file_.string());
  }
  if (auto named = db::rename_durably(temporary_, file_); !named) return base::forward_error(named);
  temporary_.clear();
  return sha256;
}

// Reading.

base::Result<ShardReader> ShardReader::open(const std::filesystem::path& file) {
  const std::string where = file.string();
  ShardReader reader(file);
  if (!reader.in_.is_open()) {
    return base::bad_input("cannot open the file: " + std::generic_category().message(errno), where);
  }
  auto line = next_line(reader.in_, where);
  if (!line) return base::forward_error(line);
  auto head = read_head(*line, where);
  if (!head) return base::forward_error(head);
  reader.head_ = *std::move(head);
  base::Sha256 hash;
  std::size_t count = 0;
  std::string last = **line;
  while (true) {
    line = next_line(reader.in_, where);
    if (!line) return base::forward_error(line);
    if (!*line) break;
    hash.update(last);
    hash.update("\n");
    last = **std::move(line);
    ++count;
  }
  reader.sha256_ = base::to_hex(hash.finish());
  const json end = json::parse(last, nullptr, false);
  if (!end.is_object() || !end.contains("entries")) return base::corrupt("the shard is cut short; fit it again", where);
  if (end["entries"] != count - 1 || end.value("sha256", json()) != reader.sha256_) {
    return base::corrupt(fmt::format("the shard is damaged: its SHA-256 is {}, its last line states another one; copy "
                                     "it again, or fit it again",
                                     reader.sha256_),
                         where);
  }
  reader.entries_ = count - 1;
  return reader;
}

base::Status ShardReader::for_each(const std::function<base::Status(const ShardEntry&)>& visit) {
  in_.clear();
  in_.seekg(0);
  if (auto head = next_line(in_, file_.string()); !head) return base::forward_error(head);
  for (std::size_t i = 0; i < entries_; ++i) {
    const auto line = next_line(in_, file_.string());
    if (!line) return base::forward_error(line);
    ShardEntry entry;
    try {
      entry = entry_of(json::parse(line->value_or("")));
    } catch (const json::exception& error) {
      return base::corrupt(fmt::format("line {} of the shard is damaged: {}", i + 2, error.what()), file_.string());
    }
    if (auto visited = visit(entry); !visited) return visited;
  }
  return {};
}

}  // namespace soak::station
