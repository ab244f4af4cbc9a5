// SPDX-License-Identifier: Apache-2.0
#include "station/gap/gap_search.h"

#include <fmt/format.h>

#include <utility>

#include "calib/forward/take_off.h"
#include "calib/model/model_document.h"
#include "station/gap/logged_campaign.h"

namespace soak::station {
namespace {

/// The newest model of the unit, if it is one of the unit as it is now.
base::Result<db::ModelRow> present_model(const db::Catalog& catalog, const std::string& serial) {
  const auto unit = catalog.unit(serial);
  if (!unit) return base::forward_error(unit);
  if (!*unit) {
    return base::bad_input(fmt::format("no unit '{}' in this data folder; 'soak unit list' shows them", serial));
  }
  const auto model = catalog.model(serial);
  if (!model) return base::forward_error(model);
  if (!*model) {
    return base::bad_input(fmt::format("unit {} has no model yet; 'soak fit --unit {}' makes one", serial, serial));
  }
  if ((*model)->epoch != (*unit)->epoch) {
    return base::bad_input(
        fmt::format("model {} of unit {} is of epoch {}, the unit is in epoch {}: 'soak fit --unit {}'",
                    (*model)->version, serial, (*model)->epoch, (*unit)->epoch, serial));
  }
  return **model;
}

}  // namespace

base::Result<GapSearch> search_gap(const db::Catalog& catalog, const std::string& unit,
                                   const std::optional<std::string>& campaign) {
  auto model = present_model(catalog, unit);
  if (!model) return base::forward_error(model);
  auto terms = calib::model_terms_of(model->document);
  if (!terms) return base::forward_error(terms);
  auto logged = load_logged_campaign(catalog, unit, campaign);
  if (!logged) return base::forward_error(logged);
  GapSearch search;
  search.model = *std::move(model);
  search.terms = *std::move(terms);
  search.campaign = *std::move(logged);
  search.not_taken_off = calib::forward::take_off(search.terms, search.campaign);
  search.report = calib::gap::find_gap(search.campaign, search.model.version);
  return search;
}

}  // namespace soak::station
