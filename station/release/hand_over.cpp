// SPDX-License-Identifier: Apache-2.0
#include "station/release/hand_over.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <string_view>
#include <system_error>
#include <utility>

#include "base/hash.h"
#include "base/text.h"
#include "station/io/host.h"
#include "station/io/text.h"
#include "station/io/text_file.h"
#include "station/records/key_file.h"
#include "station/release/exported_file.h"
#include "station/release/manifest.h"
#include "station/release/release_rule.h"
#include "station/release/tar_archive.h"

namespace soak::station {
namespace {

using nlohmann::json;

constexpr std::size_t kLongestName = 60;  // of a file's name; no system has less room
constexpr std::size_t kNameDigits = 16;

/// A file that is to be written, with its entry in the manifest.
struct ReleasedFile {
  std::string name;
  std::string content;
  json entry;
};

base::Status check_folder(const std::filesystem::path& folder) {
  std::error_code error;
  const bool exists = std::filesystem::exists(folder, error);
  if (!error &&
      (!exists || (std::filesystem::is_directory(folder, error) && std::filesystem::is_empty(folder, error)))) {
    return {};
  }
  return base::bad_input("must be a new or an empty folder: what is handed over must not mix with other files",
                         folder.string());
}

/// Who released a model, and when.
base::Result<db::ModelStateRow> release_of(const db::Catalog& catalog, const db::ModelHead& head) {
  auto history = catalog.model_history(head.unit, head.version);
  if (!history) return base::forward_error(history);
  const auto row = std::find_if(history->rbegin(), history->rend(),
                                [](const db::ModelStateRow& one) { return one.state == "released"; });
  if (row != history->rend()) return *row;
  return base::corrupt(
      fmt::format("model {} of unit {} is released, and its history does not say by whom", head.version, head.unit),
      catalog.data_folder().string());
}

/// The temperatures that all sensors are valid at.
std::pair<double, double> common_range_c(const calib::Calibration& calibration) {
  double low = calibration.sensors.front().temp_min_c;
  double high = calibration.sensors.front().temp_max_c;
  for (const calib::SensorCalibration& sensor : calibration.sensors) {
    low = std::max(low, sensor.temp_min_c);
    high = std::min(high, sensor.temp_max_c);
  }
  return {low, high};
}

json entry_of(const ReleaseCase& release, const db::ModelStateRow& state, const ReleasedFile& file) {
  const auto [low_c, high_c] = common_range_c(release.calibration);
  const auto& [row, campaign, limits, runs] = *release.verification;
  return {{"unit", release.head.unit},
          {"unit_type", release.calibration.unit_type},
          {"epoch", release.head.epoch},
          {"model", release.head.version},
          {"bytes", file.content.size()},
          {"sha256", content_sha256(file.content)},
          {"simulated", release.calibration.simulated},
          {"temp_min_c", low_c},
          {"temp_max_c", high_c},
          {"verdict", row.verdict},
          {"verified_utc", base::utc_text(row.utc_s)},
          {"campaign", campaign},
          {"limits", limits},
          {"released_by", state.user},
          {"released_utc", base::utc_text(state.utc_s)},
          {"expires", release.expires_utc_s ? json(iso_date(*release.expires_utc_s)) : json()}};
}

/// The file of a unit, or why it is left out.
base::Result<ReleasedFile> released_file(const db::Catalog& catalog, const HandOverRequest& request,
                                         const ReleaseCase& release) {
  ExportRequest wanted;
  wanted.unit = release.head.unit;
  wanted.format = request.format;
  wanted.model = release.head.version;
  wanted.simulated = request.simulated;
  if (request.format == "blob") wanted.sign = request.key_file;
  auto made = export_model(catalog, wanted);
  if (!made) return base::forward_error(made);
  const auto state = release_of(catalog, release.head);
  if (!state) return base::forward_error(state);
  ReleasedFile file{{}, std::move(made->content), {}};
  file.entry = entry_of(release, *state, file);
  return file;
}

/// All files and all that is left out.
base::Status collect(const db::Catalog& catalog, const HandOverRequest& request, std::vector<ReleasedFile>& files,
                     std::vector<LeftOut>& left_out) {
  const auto heads = catalog.models();
  if (!heads) return base::forward_error(heads);
  std::map<std::string, db::ModelHead> chosen;  // of each unit the newest released version, else the newest
  for (const db::ModelHead& head : *heads) {
    const auto [entry, is_new] = chosen.try_emplace(head.unit, head);
    if (is_new || head.state == "released" || entry->second.state != "released") entry->second = head;
  }
  const double now = now_utc_s();
  for (const auto& [unit, head] : chosen) {
    if (head.state != "released") {
      left_out.push_back(
          {unit, head.version, {fmt::format("no model of it is released; the newest is {}", head.state)}});
      continue;
    }
    const auto release = judge_release(catalog, head, now);
    if (!release && release.error().kind == base::ErrorKind::corrupt) {
      left_out.push_back({unit, head.version, {release.error().message}});
      continue;
    }
    if (!release) return base::forward_error(release);
    if (!release->obstacles.empty()) {
      left_out.push_back({unit, head.version, release->obstacles});
      continue;
    }
    auto file = released_file(catalog, request, *release);
    if (file) {
      files.push_back(*std::move(file));
    } else if (file.error().kind == base::ErrorKind::bad_input) {
      const bool is_held_back = release->calibration.simulated && !request.simulated;
      left_out.push_back({unit, head.version, {file.error().message}, is_held_back});
    } else {
      return base::forward_error(file);
    }
  }
  return {};
}

/// Serial numbers may differ in what no file name can have, or in case alone, may be too long for one, and one may be
/// "manifest". Such files carry the beginning of the serial number's SHA-256, and all of it where even that is taken.
void name_files(std::vector<ReleasedFile>& files, std::string_view ending) {
  std::map<std::string, int> uses;
  std::set<std::string> taken = {std::string(kManifestName), signature_path_of(kManifestName).string()};
  const auto unit_of = [](const ReleasedFile& file) { return file.entry["unit"].get<std::string>(); };
  const auto plain_stem = [](const std::string& unit) { return plain_file_name(unit.substr(0, kLongestName)); };
  for (const ReleasedFile& file : files) ++uses[lower_case(plain_stem(unit_of(file)))];
  for (ReleasedFile& file : files) {
    const std::string unit = unit_of(file);
    const std::string stem = plain_stem(unit);
    const std::string digest = content_sha256(unit);
    const bool is_enough = uses[lower_case(stem)] == 1 && unit.size() <= kLongestName;
    for (const std::size_t digits : {std::size_t{0}, kNameDigits, digest.size()}) {
      if (digits == 0 && !is_enough) continue;
      file.name = fmt::format("{}{}{}{}", stem, digits == 0 ? "" : "-", digest.substr(0, digits), ending);
      if (taken.insert(lower_case(file.name)).second) break;
    }
    file.entry["file"] = file.name;
  }
}

base::Error nothing_to_hand_over(const std::vector<LeftOut>& left_out) {
  std::string message =
      std::ranges::any_of(left_out, &LeftOut::is_held_back)
          ? "nothing is handed over: released models are left out as they are of SIMULATED data; --simulated takes them"
          : "no unit has a released model that keeps the rule of release: 'soak release --all' releases those that do";
  for (const LeftOut& unit : left_out) {
    message += fmt::format("\n  {}: {}", unit.unit, fmt::join(unit.reasons, "; "));
  }
  return {base::ErrorKind::bad_input, std::move(message), ""};
}

/// A folder in the making, of which nothing is left unless all of it is wanted.
class FolderInTheMaking {
 public:
  explicit FolderInTheMaking(std::filesystem::path folder) : folder_(std::move(folder)) {}
  FolderInTheMaking(const FolderInTheMaking&) = delete;
  FolderInTheMaking& operator=(const FolderInTheMaking&) = delete;
  ~FolderInTheMaking() {
    std::error_code ignored;
    for (const std::string& name : written_) std::filesystem::remove(folder_ / name, ignored);
    if (is_new_) std::filesystem::remove(folder_, ignored);
  }

  base::Status make() {
    std::error_code error;
    is_new_ = std::filesystem::create_directories(folder_, error);
    if (!error) return {};
    return base::fail(base::ErrorKind::internal, "cannot make the folder: " + error.message(), folder_.string());
  }
  base::Status write(const std::string& name, const std::string& content) {
    auto written = write_text_file(folder_ / name, content);
    if (written) written_.push_back(name);
    return written;
  }
  void keep() {
    written_.clear();
    is_new_ = false;
  }

 private:
  std::filesystem::path folder_;
  std::vector<std::string> written_;
  bool is_new_ = false;
};

base::Status record(db::Catalog& catalog, const HandOverRequest& request, const std::vector<ReleasedFile>& files) {
  const double now = now_utc_s();
  return catalog.all_or_nothing([&]() -> base::Status {
    for (const ReleasedFile& file : files) {
      const std::string path = std::filesystem::absolute(request.folder / file.name).string();
      auto added = catalog.add_calibration(
          {file.entry["unit"], file.entry["model"], now, request.format, file.entry["sha256"], path});
      if (!added) return added;
    }
    return {};
  });
}

/// The last part of a folder's path, however it is written: "hand-over/" and "." name one, too.
std::string name_of_folder(const std::filesystem::path& folder) {
  std::filesystem::path whole = std::filesystem::absolute(folder).lexically_normal();
  if (!whole.has_filename()) whole = whole.parent_path();
  return plain_file_name(whole.filename().string());
}

/// The archive until all is recorded: one that stands in its place is of use as long as this one is not whole.
std::filesystem::path archive_in_the_making(const HandOverRequest& request) {
  return std::filesystem::absolute(request.archive).string() + ".part";
}

/// All of the folder in one file, in a folder of the same name.
base::Status write_archive(FolderInTheMaking& folder, const HandOverRequest& request,
                           const std::vector<ReleasedFile>& files, const std::string& manifest,
                           const std::string& signature) {
  const std::string prefix = name_of_folder(request.folder) + '/';
  TarArchive archive(now_utc_s());
  for (const ReleasedFile& file : files) {
    if (auto added = archive.add(prefix + file.name, file.content); !added) return added;
  }
  const std::string name(kManifestName);
  auto added = archive.add(prefix + signature_path_of(name).string(), signature);
  if (added) added = archive.add(prefix + name, manifest);
  if (!added) return added;
  return folder.write(archive_in_the_making(request).string(), archive.finish());
}

/// Puts the archive into its place once the folder is whole.
base::Status place_archive(const HandOverRequest& request) {
  if (request.archive.empty()) return {};
  std::error_code error;
  std::filesystem::rename(archive_in_the_making(request), std::filesystem::absolute(request.archive), error);
  if (!error) return {};
  std::error_code ignored;
  std::filesystem::remove(archive_in_the_making(request), ignored);
  return base::fail(base::ErrorKind::internal, "the folder is whole, its archive cannot be written: " + error.message(),
                    request.archive);
}

/// The manifest is written last: a folder without one is not whole.
base::Status write_folder(db::Catalog& catalog, const HandOverRequest& request, const std::vector<ReleasedFile>& files,
                          const std::string& manifest, const SecretKey& key) {
  FolderInTheMaking folder(request.folder);
  if (auto made = folder.make(); !made) return made;
  for (const ReleasedFile& file : files) {
    if (auto written = folder.write(file.name, file.content); !written) return written;
  }
  const std::string name(kManifestName);
  const std::string signature = manifest_signature(manifest, key);
  auto written = folder.write(signature_path_of(name).string(), signature);
  if (written && !request.archive.empty()) written = write_archive(folder, request, files, manifest, signature);
  if (written) written = folder.write(name, manifest);
  if (!written) return written;
  if (auto recorded = record(catalog, request, files); !recorded) return recorded;
  folder.keep();
  return place_archive(request);
}

}  // namespace

base::Result<HandOver> hand_over(db::Catalog& catalog, const HandOverRequest& request) {
  if (auto free = check_folder(request.folder); !free) return base::forward_error(free);
  const auto key = read_secret_key(request.key_file);
  if (!key) return base::forward_error(key);
  HandOver result;
  std::vector<ReleasedFile> files;
  if (auto done = collect(catalog, request, files, result.left_out); !done) return base::forward_error(done);
  if (files.empty()) return tl::unexpected<base::Error>(nothing_to_hand_over(result.left_out));
  name_files(files, ending_of(request.format));

  result.manifest = {{"format", "soak-manifest-1"},
                     {"created_utc", base::utc_text(now_utc_s())},
                     {"software", software_version()},
                     {"user", user_name()},
                     {"key_id", base::to_hex(key_id_of(public_key_of(key->key)))},
                     {"file_format", request.format},
                     {"units", json::array()}};
  for (const ReleasedFile& file : files) result.manifest["units"].push_back(file.entry);
  if (auto written = write_folder(catalog, request, files, result.manifest.dump(2) + '\n', key->key); !written) {
    return base::forward_error(written);
  }
  return result;
}

}  // namespace soak::station
