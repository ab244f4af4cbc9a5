// SPDX-License-Identifier: Apache-2.0
#include "station/lab/campaign_queue.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <system_error>
#include <utility>

#include "station/io/text_file.h"

namespace soak::station {
namespace {

using nlohmann::json;

json file_part(const QueuedCampaign& queued) {
  return {{"campaign", queued.request.campaign},
          {"procedure", queued.procedure},
          {"procedure_file", queued.request.procedure_file},
          {"procedure_text", queued.request.procedure_text},
          {"units", queued.request.units},
          {"user", queued.request.user},
          {"estimate_s", queued.estimate_s},
          {"queued_utc_s", queued.queued_utc_s}};
}

/// Throws what the JSON library throws where a member is missing or of another type.
QueuedCampaign campaign_of(const json& part) {
  return {
      {part.at("procedure_text"), part.at("procedure_file"), part.at("campaign"), part.at("units"), part.at("user")},
      part.at("procedure"),
      part.at("estimate_s"),
      part.at("queued_utc_s")};
}

/// What the text of the file holds; nothing where it is no queue.
std::optional<std::vector<QueuedCampaign>> campaigns_of(const std::string& text) {
  const json document = json::parse(text, nullptr, false);
  try {
    if (!document.at("campaigns").is_array()) return std::nullopt;
    std::vector<QueuedCampaign> campaigns;
    for (const json& part : document.at("campaigns")) campaigns.push_back(campaign_of(part));
    return campaigns;
  } catch (const json::exception&) {
    return std::nullopt;
  }
}

}  // namespace

CampaignQueue::CampaignQueue(std::filesystem::path path) : path_(std::move(path)) {
  std::error_code error;
  if (!std::filesystem::exists(path_, error)) return;
  const auto text = read_text_file(path_);
  if (auto campaigns = text ? campaigns_of(*text) : std::nullopt) {
    waiting_ = *std::move(campaigns);
    return;
  }
  const std::filesystem::path aside = path_.string() + ".damaged";
  std::filesystem::rename(path_, aside, error);
  trouble_ = fmt::format("the queue of campaigns cannot be read{}{}; it begins empty{}", text ? "" : ": ",
                         text ? "" : text.error().message, error ? "" : ", the old one is " + aside.string());
}

std::vector<QueuedCampaign> CampaignQueue::waiting() const {
  const std::lock_guard lock(waiting_mutex_);
  return waiting_;
}

void CampaignQueue::set(std::vector<QueuedCampaign> campaigns) {
  const std::lock_guard lock(waiting_mutex_);
  waiting_ = std::move(campaigns);
}

bool CampaignQueue::empty() const { return size() == 0; }

std::size_t CampaignQueue::size() const {
  const std::lock_guard lock(waiting_mutex_);
  return waiting_.size();
}

std::optional<QueuedCampaign> CampaignQueue::front() const {
  const std::lock_guard lock(waiting_mutex_);
  return waiting_.empty() ? std::nullopt : std::optional(waiting_.front());
}

bool CampaignQueue::holds(const std::string& campaign) const {
  const std::lock_guard lock(waiting_mutex_);
  return std::ranges::any_of(waiting_, [&](const auto& queued) { return queued.request.campaign == campaign; });
}

double CampaignQueue::estimate_s() const {
  const std::lock_guard lock(waiting_mutex_);
  double sum_s = 0.0;
  for (const QueuedCampaign& queued : waiting_) sum_s += queued.estimate_s;
  return sum_s;
}

base::Status CampaignQueue::add(QueuedCampaign campaign) {
  const std::lock_guard change(change_);
  if (holds(campaign.request.campaign)) {
    return base::bad_input(fmt::format("campaign '{}' is in the queue already", campaign.request.campaign), "campaign");
  }
  std::vector<QueuedCampaign> campaigns = waiting();
  if (campaigns.size() >= kMost) {
    return base::bad_input(fmt::format("the queue holds {} campaigns, it takes no more", campaigns.size()), "state");
  }
  campaigns.push_back(std::move(campaign));
  if (auto written = write(campaigns); !written) return written;
  set(std::move(campaigns));
  return {};
}

base::Status CampaignQueue::remove(const std::string& campaign) {
  const std::lock_guard change(change_);
  if (!holds(campaign)) {
    return base::bad_input(fmt::format("no campaign '{}' is in the queue: see 'soak campaign queue'", campaign),
                           "state");
  }
  std::vector<QueuedCampaign> campaigns = waiting();
  std::erase_if(campaigns, [&](const QueuedCampaign& queued) { return queued.request.campaign == campaign; });
  if (auto written = write(campaigns); !written) return written;
  set(std::move(campaigns));
  return {};
}

base::Status CampaignQueue::take_out(const std::string& campaign) {
  const std::lock_guard change(change_);
  std::vector<QueuedCampaign> campaigns = waiting();
  std::erase_if(campaigns, [&](const QueuedCampaign& queued) { return queued.request.campaign == campaign; });
  set(campaigns);
  return write(campaigns);
}

base::Status CampaignQueue::write(const std::vector<QueuedCampaign>& campaigns) const {
  json parts = json::array();
  for (const QueuedCampaign& queued : campaigns) parts.push_back(file_part(queued));
  const json document = {{"campaigns", std::move(parts)}};
  const std::string text = document.dump(1, ' ', false, json::error_handler_t::replace) + "\n";
  const auto written = write_text_file(path_, text);
  return written ? base::Status{} : base::fail(base::ErrorKind::internal, written.error().message, path_.string());
}

json CampaignQueue::document() const {
  const std::lock_guard lock(waiting_mutex_);
  json list = json::array();
  for (const QueuedCampaign& queued : waiting_) {
    list.push_back({{"name", queued.request.campaign},
                    {"procedure", queued.procedure},
                    {"user", queued.request.user},
                    {"queued_utc_s", queued.queued_utc_s},
                    {"estimate_s", queued.estimate_s}});
  }
  return list;
}

}  // namespace soak::station
