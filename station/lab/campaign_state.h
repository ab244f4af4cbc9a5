// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

namespace soak::station {

/// What the station is doing.
enum class CampaignState : std::uint8_t {
  idle,
  running,
  suspended,    ///< by a condition that the station watches; it goes on by itself once that is over. Shown as "waiting"
  paused,       ///< by the operator: the chamber holds its set point, units are recorded outside of segments
  stopping,     ///< on the way to the safe state
  interrupted,  ///< soakd ended during the campaign; resume goes on with the run that was cut short
  finished,
  aborted,
  failed,
};

/// What may be asked of a campaign, or befall it.
enum class CampaignEvent : std::uint8_t {
  start,    ///< a new campaign
  suspend,  ///< a condition is not met any more
  go_on,    ///< it is met again
  pause,
  resume,
  abort,
  fail,     ///< a device, an alarm, the limit of a suspension
  stop,     ///< soakd shall end
  restart,  ///< soakd finds a campaign that its predecessor did not end
  finish,   ///< all steps are done
  safe,     ///< the safe state is reached
};

/// The one table of states. `from`: where the event may happen; `to`: where it leads. Of `safe` the end is the reason
/// for which the campaign was stopped: one of the three rows. Of `resume` it is running, too, for a campaign that was
/// cut short; of `abort` it is aborted at once where nothing moves any more. An abort on the way to the safe state
/// changes the end, of a campaign that was interrupted: it would have been resumed.
struct CampaignTransition {
  CampaignState from;
  CampaignEvent event;
  CampaignState to;
};
[[nodiscard]] const std::vector<CampaignTransition>& campaign_transitions();

/// Whether the event may happen in that state.
[[nodiscard]] bool can(CampaignState state, CampaignEvent event);
/// Whether a row of the table leads from one state to the other.
[[nodiscard]] bool may_follow(CampaignState from, CampaignState to);

/// A campaign is carried out: its devices are watched, its chamber holds a set point.
[[nodiscard]] bool is_under_way(CampaignState state);
/// A campaign that was cut short and can go on.
[[nodiscard]] bool is_resumable(CampaignState state);

/// As it is shown.
[[nodiscard]] std::string_view name_of(CampaignState state);
/// As it stands in the journal, where it is kept: a campaign that is suspended or on the way to the safe state is open
/// there, so that a successor of soakd takes it over.
[[nodiscard]] std::string_view journal_name_of(CampaignState state);

}  // namespace soak::station
