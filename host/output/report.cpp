// SPDX-License-Identifier: MIT
// Puts the page together and the file in place.
#include "host/output/report.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <system_error>
#include <utility>

#include "host/base/error.hpp"
#include "host/output/report_chart.hpp"
#include "host/output/report_page.hpp"
#include "host/output/report_scene.hpp"
#include "host/page/page.hpp"
#include "host/page/page_text.hpp"

namespace glint {

namespace {

constexpr std::size_t kMostKeys = 48;  // more colours than that help nobody

std::string note_of(const ReportRow& row) {
  return row.note.empty() ? "" : "<span class=\"small\">" + escape_html(row.note) + "</span>";
}

void append_summary(std::string& page, const ReportData& data) {
  std::string heads, rows;
  for (const ReportRow& row : data.summary) {
    const std::string name = escape_html(row.name), value = escape_html(row.value);
    if (row.headline) {
      heads += "<div class=\"card\"><div class=\"small\">" + name + "</div><div class=\"value\">" + value +
               "</div>" + note_of(row) + "</div>";
    } else {
      rows += "<div class=\"row\"><span class=\"soft\">" + name + "</span><b>" + value + note_of(row) +
              "</b></div>";
    }
  }
  if (!heads.empty()) page += "<section class=\"heads\">" + heads + "</section>";
  if (!rows.empty()) page += "<section class=\"card rows\">" + rows + "</section>";
}

void append_scenes(std::string& page, const ReportData& data) {
  const std::size_t tracks = data.trajectories.size();
  std::string span;
  if (data.history_s > 0) span = " in the last " + short_number(data.history_s, 1) + " s";
  page +=
      "<section class=\"scenes\"><div class=\"card\"><h2>Cameras and trajectories</h2><p class=\"small\">" +
      std::to_string(tracks) + (tracks == 1 ? " track" : " tracks") + span +
      "; a dot marks where each was seen last.<span class=\"live-only\"> Drag to turn, wheel to zoom, "
      "double-click to go back.</span></p>" +
      oblique_scene_svg(data) + "<div class=\"keys\">";
  for (std::size_t i = 0; i < tracks && i < kMostKeys; ++i) {
    page += "<span><i style=\"background:" + track_colour(i) + "\"></i>" +
            std::to_string(number(data.trajectories[i].id)) + "</span>";
  }
  if (tracks > kMostKeys) page += "<span>and " + std::to_string(tracks - kMostKeys) + " more</span>";
  page +=
      "</div></div><div class=\"card\"><h2>From above</h2><p class=\"small\">The same, looking down.</p>" +
      top_scene_svg(data) + "</div></section>";
}

void append_chart(std::string& page, const char* title, const char* explanation, const std::string& svg) {
  page += std::string("<div class=\"card\"><h2>") + title + "</h2><p class=\"small\">" + explanation +
          "</p>" + svg + "</div>";
}

}  // namespace

std::string report_html(const ReportData& data) {
  std::string page = "<header><h1>" + escape_html(data.title) + "</h1><p class=\"soft\">" +
                     escape_html(data.subtitle) + "</p></header>";
  append_summary(page, data);
  append_scenes(page, data);

  page += "<section class=\"two\">";
  if (data.stamp_to_output.count() > 0) {
    append_chart(page, "Latency from the driver's stamp",
                 "From the stamp of a tick's last frame to its output.",
                 latency_chart_svg(data.stamp_to_output));
  }
  append_chart(page, "End-to-end latency", "From the last byte of a frame set in memory to its points.",
               latency_chart_svg(data.end_to_end));
  append_chart(page, "Detection latency", "Pixels in, blobs out.", latency_chart_svg(data.detection));
  StepChart rate{"ticks per second", {}, {}, data.nominal_rate_hz}, points{"points per tick", {}, {}, 0.0};
  for (const ReportRate& bin : data.rates) {
    rate.start_s.push_back(bin.start_s);
    rate.value.push_back(bin.ticks_per_s);
    points.start_s.push_back(bin.start_s);
    points.value.push_back(bin.points_per_tick);
  }
  append_chart(page, "Rate", "Ticks that gave a result, by time of exposure.", step_chart_svg(rate));
  append_chart(page, "Points", "Markers published per tick, on average.", step_chart_svg(points));
  page += "</section>";
  return page_html(data.title, kReportStyle, page, kReportScript);
}

ReportFile::ReportFile(std::string path, bool force)
    : path_(std::move(path)), unfinished_path_(path_ + ".unfinished"), force_(force) {
  struct stat info {};
  if (path_.empty()) throw Error("--report: the file's name is empty");
  if (::stat(path_.c_str(), &info) == 0) {
    if (S_ISDIR(info.st_mode))
      throw Error(path_ + ": cannot write the report: it is a folder; name a file in it");
    if (!force_) {
      throw Error(path_ + ": the file exists already; choose another name or add --force to replace it");
    }
  }
  const int fd = ::open(unfinished_path_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (fd < 0) {
    const int why = errno;
    throw Error(path_ + ": cannot write the report: " + std::generic_category().message(why) +
                (why == ENOENT ? "; make its folder first" : ""));
  }
  ::close(fd);
}

ReportFile::~ReportFile() {
  if (!written_) ::unlink(unfinished_path_.c_str());
}

void ReportFile::write(const ReportData& data) {
  const std::string page = report_html(data);
  const auto refuse = [&](int why) {
    throw Error(path_ + ": cannot write the report: " + std::generic_category().message(why));
  };
  const int fd = ::open(unfinished_path_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (fd < 0) refuse(errno);
  std::size_t done = 0;
  int why = 0;
  while (done < page.size() && why == 0) {
    const ssize_t n = ::write(fd, page.data() + done, page.size() - done);
    if (n > 0) {
      done += static_cast<std::size_t>(n);
    } else if (n == 0 || errno != EINTR) {
      why = n == 0 ? ENOSPC : errno;
    }
  }
  if (::close(fd) != 0 && why == 0 && errno != EINTR) why = errno;
  if (why != 0) refuse(why);
  // The file may have appeared during the run.
  if (!force_ && ::access(path_.c_str(), F_OK) == 0) refuse(EEXIST);
  if (std::rename(unfinished_path_.c_str(), path_.c_str()) != 0) refuse(errno);
  written_ = true;
}

void write_report(const std::string& path, const ReportData& data, bool force) {
  ReportFile(path, force).write(data);
}

}  // namespace glint
