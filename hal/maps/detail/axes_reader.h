// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "hal/maps/detail/vocabulary.h"
#include "hal/maps/device_map.h"
#include "settings/reader.h"

namespace soak::hal {

/// What a fixture of two axes asks its map for.
[[nodiscard]] Vocabulary two_axis_vocabulary();

/// The section [axes] of a fixture's map into `map`, whose quantities have been read: axes, positions, azimuths.
/// Refuses what such a fixture needs of its quantities and the map does not have, angles beyond the limits of their
/// requests and angles at which another direction than that of the label points up.
void read_axes(const SettingsTable& root, RegisterMap& map);

}  // namespace soak::hal
