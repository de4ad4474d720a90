// SPDX-License-Identifier: MIT
// Chessboards with markers: any part of the board will do. OpenCV finds the markers; the corners between them
// are found here, since OpenCV's own way differs by half a pixel and in the layout from release to release.
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "host/base/error.hpp"
#include "host/target/aruco.hpp"
#include "host/target/opencv_finders.hpp"
#include "host/target/saddle_points.hpp"

namespace glint {
namespace {

using Quad = std::array<cv::Point2f, 4>;  // clockwise from the marker's upper left corner

/// A marker in the picture.
struct SeenMarker {
  std::uint32_t id = 0;
  Quad pixels;
};

/// Where the board's markers are, for one layout.
class Layout {
 public:
  explicit Layout(const BoardSpec& board) : board_(board), markers_(board_markers(board)) {}

  std::size_t markers() const noexcept { return markers_.size(); }

  /// Corners of a marker in units of a square, the board's first inner corner at 0,0.
  Quad on_board(std::uint32_t id) const {
    const auto margin = static_cast<float>(0.5 * (1.0 - board_.marker_m / board_.square_m));
    const float x = static_cast<float>(markers_[id].column) - 1.0f + margin,
                y = static_cast<float>(markers_[id].row) - 1.0f + margin;
    const float side = 1.0f - 2.0f * margin;
    return {{{x, y}, {x + side, y}, {x + side, y + side}, {x, y + side}}};
  }

  /// The markers in the two white squares that meet in an inner corner.
  std::vector<std::uint32_t> beside(std::uint32_t corner_x, std::uint32_t corner_y) const {
    std::vector<std::uint32_t> ids;
    for (const BoardMarker& marker : markers_) {
      if ((marker.column == corner_x || marker.column == corner_x + 1) &&
          (marker.row == corner_y || marker.row == corner_y + 1))
        ids.push_back(marker.id);
    }
    return ids;
  }

  /// Those markers that lie as this layout says. Wrongly read ones do not, nor do any under the wrong layout.
  std::vector<SeenMarker> consistent(const std::vector<SeenMarker>& seen) const {
    std::vector<cv::Point2f> board, image;
    std::vector<float> sides;
    for (const SeenMarker& marker : seen) {
      const Quad where = on_board(marker.id);
      board.insert(board.end(), where.begin(), where.end());
      image.insert(image.end(), marker.pixels.begin(), marker.pixels.end());
      const cv::Point2f side = marker.pixels[1] - marker.pixels[0];
      sides.push_back(std::hypot(side.x, side.y));
    }
    if (seen.size() < 2) return {};
    std::nth_element(sides.begin(), sides.begin() + static_cast<std::ptrdiff_t>(sides.size() / 2),
                     sides.end());
    // Lenses bend the board by less than this, and a marker in the wrong place is off by a square at least.
    const double tolerance_px = 0.4 * static_cast<double>(sides[sides.size() / 2]);
    const cv::Mat h = cv::findHomography(board, image, cv::RANSAC, tolerance_px);
    if (h.empty()) return {};
    std::vector<cv::Point2f> expected;
    cv::perspectiveTransform(board, expected, h);
    std::vector<SeenMarker> good;
    for (std::size_t i = 0; i < seen.size(); ++i) {
      bool fits = true;
      for (std::size_t c = 4 * i; c < 4 * i + 4; ++c) {
        const cv::Point2f off = expected[c] - image[c];
        fits = fits && cv::norm(off) < tolerance_px;
      }
      if (fits) good.push_back(seen[i]);
    }
    // Under the wrong layout every other row fits, which is half of them.
    if (good.size() < 2 || 3 * good.size() < 2 * seen.size()) return {};
    return good;
  }

 private:
  BoardSpec board_;
  std::vector<BoardMarker> markers_;
};

BoardSpec with_legacy(BoardSpec board, bool legacy) {
  board.legacy = legacy;
  return board;
}

class CharucoFinder final : public BoardFinder {
 public:
  CharucoFinder(const BoardSpec& board, const BoardFinderOptions& options)
      : board_(board),
        options_(options),
        layout_(board),
        other_layout_(with_legacy(board, !board.legacy)),
        layouts_differ_(board.squares_down % 2 == 0),
        dictionary_(open_dictionary(board.dictionary)),
        parameters_(cv::makePtr<cv::aruco::DetectorParameters>()) {
    for (std::uint32_t y = 0; y < board.corners_down(); ++y)
      for (std::uint32_t x = 0; x < board.corners_across(); ++x) beside_.push_back(layout_.beside(x, y));
  }

  BoardView find(const GreyPicture& picture) override try {
    const cv::Mat image = as_matrix(picture);
    // What was found last is looked for first: a board does not change within a recording.
    if (BoardView view = find_as(image, last_inverted_, false); view.finding != BoardFinding::None)
      return view;
    for (const auto& [inverted, mirrored] :
         {std::pair{!last_inverted_, false}, std::pair{last_inverted_, true},
          std::pair{!last_inverted_, true}}) {
      BoardView view = find_as(image, inverted, mirrored);
      if (view.finding == BoardFinding::None) continue;
      last_inverted_ = inverted;
      return view;
    }
    return {};
  } catch (const cv::Exception& e) {
    throw Error("charuco: OpenCV: " + std::string(e.what()));
  }

 private:
  BoardView find_as(const cv::Mat& original, bool inverted, bool mirrored) {
    cv::Mat image = original;
    if (inverted) cv::bitwise_not(image, turned_), image = turned_;
    if (mirrored) cv::flip(image, flipped_, 1), image = flipped_;
    BoardView view;
    view.inverted = inverted;
    const std::vector<SeenMarker> seen = markers_in_picture(image);
    const std::vector<SeenMarker> markers = layout_.consistent(seen);
    if (markers.empty()) {
      if (layouts_differ_ && seen.size() >= 4 && !other_layout_.consistent(seen).empty())
        view.finding = mirrored ? BoardFinding::Mirrored : BoardFinding::OtherLayout;
      return view;
    }
    add_corners(image, markers, view.corners);
    if (view.corners.size() < kFewestCorners) {
      view.corners.clear();
    } else if (mirrored) {
      view.corners.clear();
      view.finding = BoardFinding::Mirrored;
    } else {
      view.finding = BoardFinding::Found;
    }
    return view;
  }

  std::vector<SeenMarker> markers_in_picture(const cv::Mat& image) const {
    std::vector<std::vector<cv::Point2f>> quads;
    std::vector<int> ids;
    cv::aruco::detectMarkers(image, dictionary_, quads, ids, parameters_);
    std::vector<SeenMarker> seen;
    for (std::size_t i = 0; i < ids.size(); ++i) {
      if (ids[i] < 0 || static_cast<std::size_t>(ids[i]) >= layout_.markers()) continue;
      const auto& q = quads[i];
      seen.push_back({static_cast<std::uint32_t>(ids[i]), {{q[0], q[1], q[2], q[3]}}});
    }
    return seen;
  }

  /// Each corner is expected where the markers beside it put it, then looked for.
  void add_corners(const cv::Mat& image, const std::vector<SeenMarker>& markers,
                   std::vector<BoardCorner>& corners) const {
    for (std::uint32_t point = 0; point < board_.corners(); ++point) {
      const cv::Point2f on_board(static_cast<float>(point % board_.corners_across()),
                                 static_cast<float>(point / board_.corners_across()));
      cv::Point2f expected(0.0f, 0.0f);
      float nearest_px = 1e6f;  // to a marker, across or down: it must not be in the window
      int views = 0;
      for (const std::uint32_t id : beside_[point]) {
        const auto marker =
            std::find_if(markers.begin(), markers.end(), [id](const SeenMarker& m) { return m.id == id; });
        if (marker == markers.end()) continue;
        const Quad from = layout_.on_board(id);
        const cv::Mat h = cv::getPerspectiveTransform(from.data(), marker->pixels.data());
        std::vector<cv::Point2f> at{on_board};
        cv::perspectiveTransform(at, at, h);
        expected += at[0];
        ++views;
        for (const cv::Point2f& p : marker->pixels)
          nearest_px = std::min(nearest_px, std::max(std::abs(p.x - at[0].x), std::abs(p.y - at[0].y)));
      }
      if (views < kMarkersBeside || nearest_px < 3.0f) continue;
      expected *= 1.0f / static_cast<float>(views);
      // The window, and the pixel around it that slopes are taken from, stay clear of the markers.
      const int reach_px =
          options_.reach_px > 0 ? options_.reach_px : std::clamp(static_cast<int>(nearest_px) - 1, 2, 10);
      if (refine_saddle_point(image, reach_px, expected))
        corners.push_back({point, {static_cast<double>(expected.x), static_cast<double>(expected.y)}});
    }
  }

  static constexpr int kMarkersBeside = 2;  // a corner with one marker beside it may be half hidden

  BoardSpec board_;
  BoardFinderOptions options_;
  Layout layout_, other_layout_;
  bool layouts_differ_;
  cv::Ptr<cv::aruco::Dictionary> dictionary_;
  cv::Ptr<cv::aruco::DetectorParameters> parameters_;
  std::vector<std::vector<std::uint32_t>> beside_;  // by point
  cv::Mat turned_, flipped_;
  bool last_inverted_ = false;
};

}  // namespace

std::unique_ptr<BoardFinder> make_charuco_finder(const BoardSpec& board, const BoardFinderOptions& options) {
  return std::make_unique<CharucoFinder>(board, options);
}

}  // namespace glint
