// SPDX-License-Identifier: MIT
// Words for slips, proofs and the lack of them.
#include "host/apps/alignment_text.hpp"

#include <cstdio>
#include <cstdlib>

namespace glint::apps {
namespace {

std::string seconds_text(double seconds) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f s", seconds);
  return text;
}

std::string pulses_text(int pulses) {
  const int count = std::abs(pulses);
  return std::to_string(count) + (count == 1 ? " pulse " : " pulses ") + (pulses > 0 ? "behind" : "ahead");
}

}  // namespace

std::string event_text(const AlignmentEvent& event, const std::vector<std::string>& cameras) {
  const std::string camera = "camera " + cameras.at(index(event.camera));
  switch (event.kind) {
    case AlignmentEvent::Kind::PhaseFound:
      return "coded pulses are recognised; cameras are proven one by one";
    case AlignmentEvent::Kind::NoPhase:
      return "no coded pulses are recognised: check sync.code_seed and sync.code_group, and that markers are "
             "in "
             "sight; until then no point is marked as aligned";
    case AlignmentEvent::Kind::PhaseLost:
      return "coded pulses are no longer where they were: the board was restarted, or pulses were lost count "
             "of; "
             "they are looked for anew";
    case AlignmentEvent::Kind::SlipFound:
      return camera + " was found " + pulses_text(event.pulses) + " the others; it is being corrected";
    case AlignmentEvent::Kind::SlipCorrected:
      return camera + " is in step again";
  }
  return {};
}

std::vector<ReportRow> alignment_rows(const CodeReport& report, const std::vector<std::string>& cameras) {
  std::vector<ReportRow> rows;
  rows.push_back({"coded pulses",
                  report.phase ? std::to_string(report.dark_pulses) + " dark" : "not recognised",
                  report.phase ? "one in " + std::to_string(report.group) + "; the first pulse is number " +
                                     std::to_string(*report.phase) + " of the code"
                               : "no point is known to be aligned",
                  false});
  for (std::size_t i = 0; i < report.cameras.size(); ++i) {
    const CameraAlignment& camera = report.cameras[i];
    std::string value = "proven for " + seconds_text(camera.proven_s) + " of " +
                        seconds_text(camera.proven_s + camera.unproven_s);
    if (camera.slips_found > 0) {
      value += ", " + std::to_string(camera.slips_found) +
               (camera.slips_found == 1 ? " slip found, " : " slips found, ") +
               std::to_string(camera.slips_corrected) + " corrected";
    }
    rows.push_back({"alignment of camera " + cameras.at(i), std::move(value),
                    "longest unproven " + seconds_text(camera.longest_unproven_s), false});
  }
  return rows;
}

nlohmann::ordered_json alignment_json(const CodeReport& report, const std::vector<std::string>& cameras) {
  nlohmann::ordered_json all = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < report.cameras.size(); ++i) {
    const CameraAlignment& camera = report.cameras[i];
    all.push_back({{"name", cameras.at(i)},
                   {"proven_s", camera.proven_s},
                   {"unproven_s", camera.unproven_s},
                   {"longest_unproven_s", camera.longest_unproven_s},
                   {"slips_found", camera.slips_found},
                   {"slips_corrected", camera.slips_corrected}});
  }
  nlohmann::ordered_json phase;
  if (report.phase) phase = *report.phase;
  return {{"group", report.group},
          {"phase", phase},
          {"dark_pulses", report.dark_pulses},
          {"cameras", std::move(all)}};
}

}  // namespace glint::apps
