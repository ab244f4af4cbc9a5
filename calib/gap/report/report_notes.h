// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "calib/gap/base/campaign_model.h"
#include "calib/gap/report/gap_report.h"

namespace soak::calib::gap {

/// Adds what limits a conclusion to the notes, and to the end of the reason.
void add_note(GapReport& report, std::string code, std::string text);

/// Names the sensors of the campaign that never scatter, which the search has to pass over.
void note_sensors_without_scatter(const Observations& observations, const CampaignModel& model, GapReport& report);

/// Says how far the bias of each sensor wanders, about its mean over a run: what GapReport::slow_noise holds.
void note_wander(GapReport& report);

/// Says what the order of the positions leaves open about the effects named.
void note_position_order(const Observations& observations, GapReport& report);

/// Says what a thermometer in steps kept from being looked for, or what stands in for it.
void note_thermometer(const LoggedCampaign& campaign, const TemperatureHistory& history, GapReport& report);

}  // namespace soak::calib::gap
