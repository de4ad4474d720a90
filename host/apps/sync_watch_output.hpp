// SPDX-License-Identifier: MIT
// What `glint sync watch` prints: a live line with events above it, or lines of JSON.
#pragma once

#include <cstdio>
#include <memory>
#include <string>

#include "host/apps/sync_watch.hpp"

namespace glint::apps {

/// "   12.0 s  running ...", without a line break.
std::string watch_line(const WatchUpdate& update);
/// Several lines.
std::string summary_text(const WatchSummary& summary);

/// Writes to `file`, which it does not own. On a terminal the live line is rewritten, elsewhere each is a
/// line of its own. Throws glint::Error when it cannot be written.
std::unique_ptr<WatchSink> make_text_sink(std::FILE* file);
/// An object a line, with "type": "board", "event", "update", "summary".
std::unique_ptr<WatchSink> make_json_sink(std::FILE* file);

}  // namespace glint::apps
