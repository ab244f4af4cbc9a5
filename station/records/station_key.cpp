// SPDX-License-Identifier: Apache-2.0
#include "station/records/station_key.h"

#include <nlohmann/json.hpp>
#include <system_error>

#include "base/hash.h"
#include "station/io/host.h"
#include "station/io/text_file.h"
#include "station/records/key_file.h"

namespace soak::station {

using nlohmann::json;

std::filesystem::path station_key_file(const std::filesystem::path& data_folder) { return data_folder / "station.key"; }

base::Result<json> station_key(const std::filesystem::path& data_folder) {
  const std::filesystem::path path = station_key_file(data_folder);
  std::error_code failure;
  if (!std::filesystem::exists(path, failure)) return json{{"key", nullptr}};
  const auto secret = read_secret_key(path);
  if (!secret) return base::forward_error(secret);
  auto file = read_text_file(public_path_of(path));
  if (!file) return base::forward_error(file);
  const PublicKey key = public_key_of(secret->key);
  return json{{"key",
               {{"key_id", base::to_hex(key_id_of(key))},
                {"public_key", base::to_hex(key)},
                {"comment", secret->comment},
                {"file", *std::move(file)}}}};
}

base::Result<json> make_station_key(db::Catalog& catalog, const std::string& comment, const std::string& user) {
  const std::filesystem::path path = station_key_file(catalog.data_folder());
  std::error_code failure;
  if (std::filesystem::exists(path, failure)) {
    return base::bad_input("the station has a key already: what was signed with it would not be known any more",
                           "state");
  }
  const auto secret = new_secret_key();
  if (!secret) return base::forward_error(secret);
  if (auto written = write_new_key(path, *secret, comment); !written) return base::forward_error(written);
  const std::string id = base::to_hex(key_id_of(public_key_of(*secret)));
  if (auto noted = catalog.log_event({now_utc_s(), "key_made", id, comment, user}); !noted) {
    for (const auto& file : {path, public_path_of(path)}) std::filesystem::remove(file, failure);
    return base::forward_error(noted);
  }
  return station_key(catalog.data_folder());
}

}  // namespace soak::station
