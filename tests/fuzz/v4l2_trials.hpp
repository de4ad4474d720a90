// SPDX-License-Identifier: MIT
// What fuzz_v4l2 does with drivers whose answers its bytes decide on. Each aborts when something is broken.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "host/frames/frame_pool.hpp"
#include "tests/fuzz/byte_choices.hpp"

namespace glint::test {

/// Of 256 answers so many are spoilt, while there are bytes.
inline constexpr std::uint32_t kSpoilt = 48;

/// Cameras as sysfs and their drivers describe them: nothing of it may reach a terminal as it is.
void try_list(ByteChoices& choices);
/// Up to three cameras in this thread, their frames held or paired: no call takes longer or asks the driver
/// more often than it may; frames handed over stay as they are; the ledger balances; all slots and buffers
/// come back.
void try_streams(ByteChoices& choices);
/// One camera with its own thread, started twice: it goes on whatever the driver does, and ends when told to.
void try_feed(ByteChoices& choices);

/// A file to be a camera's node where there is no sysfs; the same for the whole run.
const std::string& node_path(std::size_t camera);
/// No slot of the camera is lent.
bool all_slots_free(FramePool& pool, CameraId camera, std::uint32_t slots);

}  // namespace glint::test
