// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "anfis/data/training_data.h"
#include "anfis/model/model.h"

namespace soak::anfis::training {

/// Free offsets (group_variance = +infinity) leave the level of the curve open: it becomes the plain mean of the
/// groups' levels. Does nothing for other data.
void set_level(Model& model, const TrainingData& data);

}  // namespace soak::anfis::training
