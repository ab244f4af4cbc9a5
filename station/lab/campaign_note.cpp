// SPDX-License-Identifier: Apache-2.0
#include "station/lab/campaign_note.h"

#include <nlohmann/json.hpp>
#include <system_error>

#include "station/io/host.h"
#include "station/io/text_file.h"

namespace soak::station {

CampaignNote CampaignNoteFile::read() const {
  const auto text = read_text_file(path_);
  if (!text) return {};
  const auto document = nlohmann::json::parse(*text, nullptr, false);
  try {
    return {document.at("campaign"), document.at("goes_on"), document.at("outcome"), document.at("reason"),
            document.at("user")};
  } catch (const nlohmann::json::exception&) {
    return {};
  }
}

void CampaignNoteFile::keep(const CampaignNote& note) const {
  const nlohmann::json document = {{"campaign", note.campaign},
                                   {"goes_on", note.goes_on},
                                   {"outcome", note.outcome},
                                   {"reason", note.reason},
                                   {"user", note.user}};
  const auto kept =
      write_text_file(path_, document.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
  if (kept) return;
  log_line("what the campaign is about to be cannot be noted: " + kept.error().message);
  std::error_code error;
  std::filesystem::remove(path_, error);
}

}  // namespace soak::station
