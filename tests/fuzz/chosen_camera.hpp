// SPDX-License-Identifier: MIT
// Fake cameras of every kind.
#pragma once

#include "host/capture/v4l2/camera_stream.hpp"
#include "tests/unit/capture/choices.hpp"
#include "tests/unit/capture/fake_v4l2.hpp"

namespace glint::test {

/// Decides on what the camera offers and, while it streams, on each frame: damaged, late, twice, none, and
/// the cable pulled. Both arguments must live as long as the driver.
void choose_camera(Choices& choices, FakeCamera& camera);

/// What somebody might want of it. `path`: its node.
CameraRequest choose_request(Choices& choices, const std::string& path);

}  // namespace glint::test
