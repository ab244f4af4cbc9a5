// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace soak::station {

/// Why a campaign cannot be carried on for the moment.
enum class SuspensionCause : std::uint8_t {
  chamber,  ///< the chamber does not answer
  air,      ///< the air is not at the plateau: an open door, a chamber that cannot hold it
  disk,     ///< little room is left where runs are recorded
  storage,  ///< what is measured cannot be written
  supply,   ///< a unit's supply voltage is out of range
  catalog,  ///< the end of a step cannot be entered
};

/// "chamber", "air", "disk", "storage", "supply", "catalog".
[[nodiscard]] std::string_view name_of(SuspensionCause cause);

/// What is known of the station now. What is not known neither suspends nor ends a suspension.
struct StationConditions {
  double chamber_silent_s = 0.0;  ///< for how long it has not answered, host time as for all links; 0 = it answers
  std::string chamber_trouble;    ///< what its link says
  /// Distance of the air from the set point; nothing where it is not known, or the campaign not at a plateau.
  std::optional<double> air_off_k;
  std::optional<double> disk_free_bytes;
  std::string storage_error;  ///< of the last try to write; empty = none
  std::string catalog_error;  ///< of the last try to enter the end of a step; empty = none
  struct Supply {
    std::string unit;
    double set_v = 0.0;
    std::optional<double> read_v;  ///< nothing where it does not answer
  };
  std::vector<Supply> supplies;  ///< of the units that are measured and switched on
};

/// Decides when a campaign waits and when it goes on. Each cause has a threshold at which it suspends, another at which
/// it is over, and a time for which it must be seen; between the thresholds things stay as they are.
///
/// | cause | suspends | is over |
/// | chamber | silent for 60 s of host time | it answers |
/// | air | more than 3 K from the set point for 600 s | within 1 K |
/// | disk | less than 50 MB free | 100 MB free |
/// | storage | a write failed | a write succeeded |
/// | supply | more than 10 % from the set voltage for 10 s | within 5 % |
/// | catalog | the end of a step could not be entered | it is entered |
///
/// The campaign goes on once every cause has been over for kSettle_s. All other times are process time. It knows no
/// device and no clock.
class Suspenders {
 public:
  static constexpr double kSettle_s = 60.0;
  static constexpr int kMostSuspensions = 10;  ///< without progress between them
  static constexpr double kDiskLow_bytes = 50e6;
  static constexpr double kDiskEnough_bytes = 100e6;

  /// `give_up_s`: for which it waits at most without progress, over one suspension or many.
  explicit Suspenders(double give_up_s = 0.0) : give_up_s_(give_up_s) {}

  enum class Advice : std::uint8_t {
    carry_on,  ///< all is well
    suspend,   ///< wait, now or still
    give_up,   ///< it has waited for too long, or too often
  };

  /// `now_s` must not fall from one call to the next.
  Advice look(double now_s, const StationConditions& conditions);

  /// The campaign has come further than ever before: what it has waited for so far does not count any more.
  void note_progress();

  /// What the station waits for; none where nothing suspends. A cause that is over, but not for kSettle_s, is among
  /// them.
  [[nodiscard]] std::vector<SuspensionCause> causes() const;
  [[nodiscard]] bool has(SuspensionCause cause) const { return watches_[index(cause)].suspends; }
  /// Whether what was measured and judged at the present visit does not count any more. While the end of a step waits
  /// for the catalog nothing has happened to chamber and units.
  [[nodiscard]] bool spoil_visit() const;
  /// The same for people; empty where nothing suspends.
  [[nodiscard]] std::string text() const;
  [[nodiscard]] std::optional<double> suspended_since_s() const { return since_s_; }
  /// How much longer it may wait.
  [[nodiscard]] double left_s(double now_s) const { return give_up_s_ - waited_s(now_s); }

 private:
  enum class Level : std::uint8_t { good, between, bad };
  struct Finding {
    Level level = Level::good;
    double delay_s = 0.0;  ///< for which it must be bad
    std::string text;      ///< what is bad
  };
  struct Watch {
    std::optional<double> bad_since_s;
    std::optional<double> good_since_s;
    bool suspends = false;
    std::string text;
    void follow(double now_s, const Finding& finding);
  };
  static constexpr std::size_t kCauses = 6;

  static std::size_t index(SuspensionCause cause) { return static_cast<std::size_t>(cause); }
  [[nodiscard]] static Finding judge(SuspensionCause cause, const StationConditions& conditions);
  [[nodiscard]] static Finding judge_supplies(const std::vector<StationConditions::Supply>& supplies);

  [[nodiscard]] double waited_s(double now_s) const;

  double give_up_s_;
  std::array<Watch, kCauses> watches_;
  std::optional<double> since_s_;
  double waited_before_s_ = 0.0;  ///< in suspensions that are over, since there was progress
  int suspensions_ = 0;           ///< since then
};

}  // namespace soak::station
