// SPDX-License-Identifier: MIT
// Opens the source, finds the board, keeps what is new.
#include "host/apps/calibrate/board_samples.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>

#include "host/apps/progress_line.hpp"
#include "host/apps/stop_signal.hpp"
#include "host/base/error.hpp"
#include "host/calibrate/board_session.hpp"
#include "host/capture/image_source.hpp"
#include "host/capture/v4l2/v4l2_source.hpp"
#include "host/sim/board_source.hpp"

namespace glint::apps {
namespace {

namespace fs = std::filesystem;

/// One camera's pictures so far.
class BoardCamera {
 public:
  BoardCamera(const SourceCamera& camera, const BoardSource& source, const Target& target)
      : name_(camera.name),
        finder_(make_board_finder(source.board, source.finder)),
        session_(target, camera.size.width_px, camera.size.height_px),
        most_views_(source.most_views),
        still_(source.still) {}

  /// Empty points: no board that can be used.
  BoardPoints look(const gpu::ImageView& image) {
    const BoardView view = finder_->find({image.pixels, image.width_px, image.height_px, image.stride_bytes});
    ++pictures_;
    found_ += view.finding == BoardFinding::Found;
    mirrored_ += view.finding == BoardFinding::Mirrored;
    other_layout_ += view.finding == BoardFinding::OtherLayout;
    inverted_ += view.finding == BoardFinding::Found && view.inverted;
    BoardPoints points;
    for (const BoardCorner& corner : view.corners) {
      points.points.push_back(corner.point);
      points.pixels.push_back(corner.pixel);
    }
    return points;
  }

  bool is_new(const BoardPoints& view) const { return session_.is_new(view); }
  bool full() const noexcept { return session_.views().size() >= most_views_; }
  void keep(std::uint64_t tick, const BoardPoints& view) {
    session_.add_always(view);
    if (session_.views().size() > ticks_.size()) ticks_.push_back(tick);
  }

  bool enough() const { return full() || (!still_ && session_.missing().empty()); }
  const std::string& name() const noexcept { return name_; }
  std::size_t views() const noexcept { return ticks_.size(); }

  std::string progress() const {
    std::string text = name_ + " " + std::to_string(views()) + " views";
    if (found_ == 0 && mirrored_ > 0) return text + ": the board is seen as in a mirror";
    if (found_ == 0 && other_layout_ > 0) return text + ": the board's markers are arranged otherwise";
    if (still_) return text;
    const std::vector<std::string> missing = session_.missing();
    return text + (missing.empty() ? ", enough" : ": " + missing.front());
  }

  std::string note(const BoardSpec& board) const {
    const std::string of = " of " + std::to_string(pictures_) + " pictures";
    std::string text = name_ + ": the board is in " + std::to_string(found_) + of + ", " +
                       std::to_string(views()) + (still_ ? " kept" : " kept that differ");
    if (inverted_ > 0) text += "; it is white on black, which does no harm";
    if (mirrored_ > 0) {
      text += "; in " + std::to_string(mirrored_) +
              " it is seen as in a mirror: either the camera mirrors its pictures (switch that off: no lens "
              "does so), or "
              "it looks at the back of the board";
    }
    if (other_layout_ > 0) {
      BoardSpec other = board;
      other.legacy = !board.legacy;
      text += "; in " + std::to_string(other_layout_) + " its markers are arranged as those of --board " +
              to_text(other);
    }
    if (found_ + mirrored_ + other_layout_ == 0) {
      text += "; is it " + to_text(board) + ", sharp, evenly lit, with a white edge" +
              (board.kind == BoardKind::Chessboard ? ", and all of it in the picture?" : "?");
    }
    return text;
  }

  void append_to(SampleSet& samples, std::uint32_t camera) const {
    for (std::size_t v = 0; v < ticks_.size(); ++v) {
      const BoardPoints& view = session_.views()[v];
      for (std::size_t i = 0; i < view.points.size(); ++i)
        samples.sightings.push_back({ticks_[v], camera, view.points[i], view.pixels[i]});
    }
  }

 private:
  std::string name_;
  std::unique_ptr<BoardFinder> finder_;
  BoardSession session_;
  std::size_t most_views_;
  bool still_;
  std::vector<std::uint64_t> ticks_;  // of the session's views
  std::uint64_t pictures_ = 0, found_ = 0, mirrored_ = 0, other_layout_ = 0, inverted_ = 0;
};

/// Looks for the board in all pictures of one tick and keeps what is wanted of it.
void take(const FrameSet& set, const BoardSource& source, std::vector<BoardCamera>& cameras) {
  std::vector<BoardPoints> views(cameras.size());
  std::size_t seen = 0;
  bool any_new = false;
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    if (!set.frames[c] || set.frames[c]->damaged) continue;
    views[c] = cameras[c].look(set.frames[c]->image());
    if (views[c].points.empty()) continue;
    ++seen;
    any_new = any_new || source.still || cameras[c].is_new(views[c]);
  }
  if (source.together && (seen < 2 || !any_new)) return;
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    if (views[c].points.empty() || cameras[c].full()) continue;
    if (source.together || source.still || cameras[c].is_new(views[c]))
      cameras[c].keep(number(set.trigger), views[c]);
  }
}

/// Whether pictures lie in that folder itself: those of one camera.
bool holds_pictures(const fs::path& folder) {
  bool pictures = false;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    if (entry.is_directory()) return false;
    std::string kind = entry.path().extension().string();
    for (char& c : kind)
      if (c >= 'A' && c <= 'Z') c = static_cast<char>(c + 32);
    for (const char* const known : {".jpg", ".jpeg", ".png", ".pgm", ".ppm", ".tif", ".tiff", ".bmp"})
      pictures = pictures || kind == known;
  }
  return pictures;
}

std::unique_ptr<FrameSource> open_pictures(std::string location) {
  if (location.starts_with("images:")) location.erase(0, 7);
  if (fs::is_directory(location) && holds_pictures(location)) {
    const fs::path folder = fs::absolute(location).lexically_normal();
    const std::string name = (folder.filename().empty() ? folder.parent_path() : folder).filename().string();
    location = (name.find_first_of(",= /") == std::string::npos ? name + "=" : "cam1=") + folder.string();
  }
  return open_image_source(location, {});
}

std::unique_ptr<FrameSource> open_source(const BoardSource& a, Calibration& truth) {
  if (a.source == "sim") {
    const BoardPattern pattern = board_pattern(a.board);
    const Eigen::Vector2d margin = Eigen::Vector2d::Constant(a.board.square_m);
    auto source = std::make_unique<SimBoardSource>(
        checked_sim_options(a.sim),
        sim::PrintedBoard{{pattern.squares.min() - margin, pattern.squares.max() + margin}, pattern.black},
        pattern.squares, a.sim_views);
    truth = source->truth();
    return source;
  }
  if (a.source.starts_with("v4l2:"))
    return std::make_unique<V4l2Source>(live_options(a.source.substr(5), 0.0, a.rig, a.live));
  return open_pictures(a.source);
}

}  // namespace

BoardSamples collect_board_samples(const BoardSource& a) {
  StopSignal stop_signal;
  BoardSamples result;
  result.samples.target = board_target(a.board);
  const std::unique_ptr<FrameSource> source = open_source(a, result.truth);
  std::vector<BoardCamera> cameras;
  std::vector<FrameSize> sizes;
  for (const SourceCamera& camera : source->cameras()) {
    cameras.emplace_back(camera, a, result.samples.target);
    result.samples.cameras.push_back({camera.name, camera.size.width_px, camera.size.height_px});
    sizes.push_back(camera.size);
  }
  result.samples.rate_hz = source->rate_hz();
  if (!a.quiet) {
    std::fprintf(stderr, "glint: %s, %zu camera%s; board %s%s\n", a.source.c_str(), cameras.size(),
                 cameras.size() == 1 ? "" : "s", to_text(a.board).c_str(),
                 !source->live() ? ""
                 : a.still       ? "; let it lie still"
                                 : "; move it slowly, Ctrl-C when you have had enough");
  }

  std::atomic<bool> stopped{false};
  const StopSignal::Handler on_stop(stop_signal, [&stopped] { stopped = true; });
  FramePool pool(sizes, source->frames_ahead() + 2);
  ReadStatus status = ReadStatus::Ok;
  {
    ProgressLine progress(a.quiet);
    auto next_line = std::chrono::steady_clock::now();
    FrameSet set;
    while (!stopped) {
      status = source->read(pool, set);
      if (status == ReadStatus::End || status == ReadStatus::Failed) break;
      take(set, a, cameras);
      const auto enough = [](const BoardCamera& camera) { return camera.enough(); };
      if (source->live() && (a.still ? std::any_of(cameras.begin(), cameras.end(), enough)
                                     : std::all_of(cameras.begin(), cameras.end(), enough)))
        break;
      const auto now = std::chrono::steady_clock::now();
      if (now < next_line) continue;
      next_line = now + std::chrono::seconds(1);
      const BoardCamera* least = &cameras.front();
      for (const BoardCamera& camera : cameras)
        if (least->enough() || (!camera.enough() && camera.views() < least->views())) least = &camera;
      progress.show(least->progress());
    }
  }
  source->let_go();
  if (status == ReadStatus::Failed) throw Error(source->problem());
  if (!source->live() && source->counters().damaged > 0) {
    throw Error("pictures are damaged, or not all of one camera are of the same size:\n" + source->problem());
  }
  for (std::uint32_t c = 0; c < cameras.size(); ++c) {
    cameras[c].append_to(result.samples, c);
    result.notes.push_back(cameras[c].note(a.board));
  }
  put_in_order(result.samples);
  return result;
}

}  // namespace glint::apps
