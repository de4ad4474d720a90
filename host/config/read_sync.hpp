// SPDX-License-Identifier: MIT
// The sync board in a rig file.
#pragma once

#include "host/config/rig.hpp"
#include "host/config/toml_section.hpp"

namespace glint {

/// Reads [sync] and its [[sync.output]] into `sync`; problems go to both.
void read_sync(TomlSection& section, SyncSettings& sync, FileProblems& problems);

}  // namespace glint
