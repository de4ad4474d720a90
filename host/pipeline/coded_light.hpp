// SPDX-License-Identifier: MIT
// Coded pulses in the pipeline: from a frame set and its blobs to what the tick says of its cameras.
#pragma once

#include "host/assemble/code_alignment.hpp"
#include "host/frames/frame_pool.hpp"
#include "host/pipeline/tick_input.hpp"

namespace glint {

/// After detection, for every set in order: fills tick.unproven, tick.dark and tick.events, which last until
/// the next call. The caller asks its source for what alignment.wanted_shift() then says.
void check_light(CodeAlignment& alignment, const FrameSet& set, TickBlobs& tick) noexcept;

}  // namespace glint
