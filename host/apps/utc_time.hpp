// SPDX-License-Identifier: MIT
// The time of day as files have it.
#pragma once

#include <string>

namespace glint::apps {

/// "2026-11-23T12:34:56Z"
std::string utc_now();

}  // namespace glint::apps
