// SPDX-License-Identifier: MIT
// Coded pulses in words: what happens while a run goes on, and what it came to.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "host/assemble/code_alignment.hpp"
#include "host/output/report.hpp"

namespace glint::apps {

/// "camera left was 2 pulses behind the others; it is being corrected". `cameras`: names in rig order.
std::string event_text(const AlignmentEvent& event, const std::vector<std::string>& cameras);

/// A row for the code and one for each camera.
std::vector<ReportRow> alignment_rows(const CodeReport& report, const std::vector<std::string>& cameras);
nlohmann::ordered_json alignment_json(const CodeReport& report, const std::vector<std::string>& cameras);

}  // namespace glint::apps
