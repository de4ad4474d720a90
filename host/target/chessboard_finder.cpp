// SPDX-License-Identifier: MIT
// Plain chessboards: all corners or none.
#include <algorithm>
#include <cmath>

#include <opencv2/calib3d.hpp>

#include "host/base/error.hpp"
#include "host/target/opencv_finders.hpp"
#include "host/target/saddle_points.hpp"

namespace glint {
namespace {

class ChessboardFinder final : public BoardFinder {
 public:
  ChessboardFinder(const BoardSpec& board, const BoardFinderOptions& options)
      : board_(board), options_(options), across_(board.corners_across()), down_(board.corners_down()) {}

  BoardView find(const GreyPicture& picture) override try {
    const cv::Mat image = as_matrix(picture);
    std::vector<cv::Point2f> corners;
    BoardView view;
    if (!find_all(image, corners)) return view;
    put_in_order(image, corners);
    // Not so far that the next corner is in the window, nor farther than helps.
    const int reach_px = options_.reach_px > 0
                             ? options_.reach_px
                             : std::clamp(static_cast<int>(0.4f * least_spacing(corners)), 2, 11);
    for (std::uint32_t i = 0; i < corners.size(); ++i) {
      if (refine_saddle_point(image, reach_px, corners[i]))
        view.corners.push_back({i, {static_cast<double>(corners[i].x), static_cast<double>(corners[i].y)}});
    }
    if (view.corners.size() < kFewestCorners) {
      view.corners.clear();
    } else {
      view.finding = BoardFinding::Found;
    }
    return view;
  } catch (const cv::Exception& e) {
    throw Error("chessboard: OpenCV: " + std::string(e.what()));
  }

 private:
  bool find_all(const cv::Mat& image, std::vector<cv::Point2f>& corners) const {
    const cv::Size size(static_cast<int>(across_), static_cast<int>(down_));
    // Without the fast check a picture of noise takes seconds. Where there seems to be a board after all, the
    // slower method finds some more of those that are blurred.
    constexpr int kFlags =
        cv::CALIB_CB_ADAPTIVE_THRESH | cv::CALIB_CB_NORMALIZE_IMAGE | cv::CALIB_CB_FAST_CHECK;
    const bool found = cv::findChessboardCorners(image, size, corners, kFlags) ||
                       (cv::checkChessboard(image, size) &&
                        cv::findChessboardCornersSB(image, size, corners, cv::CALIB_CB_NORMALIZE_IMAGE));
    return found && corners.size() == board_.corners();
  }

  const cv::Point2f& at(const std::vector<cv::Point2f>& corners, std::uint32_t x, std::uint32_t y) const {
    return corners[y * across_ + x];
  }

  float least_spacing(const std::vector<cv::Point2f>& corners) const {
    float least = 1e6f;
    for (std::uint32_t y = 0; y < down_; ++y) {
      for (std::uint32_t x = 0; x < across_; ++x) {
        const cv::Point2f& p = at(corners, x, y);
        for (const auto& [dx, dy] : {std::pair{1u, 0u}, std::pair{0u, 1u}}) {
          if (x + dx >= across_ || y + dy >= down_) continue;
          const cv::Point2f& q = at(corners, x + dx, y + dy);
          least = std::min(least, std::hypot(q.x - p.x, q.y - p.y));
        }
      }
    }
    return least;
  }

  /// Row by row as board_target() counts them: not mirrored, and from the corner whose squares have the right
  /// colours, where colours tell.
  void put_in_order(const cv::Mat& image, std::vector<cv::Point2f>& corners) const {
    const cv::Point2f along = at(corners, across_ - 1, 0) - at(corners, 0, 0),
                      down = at(corners, 0, down_ - 1) - at(corners, 0, 0);
    if (along.cross(down) < 0.0) {
      for (std::uint32_t y = 0; y < down_; ++y)
        std::reverse(corners.begin() + y * across_, corners.begin() + (y + 1) * across_);
    }
    double white_minus_black = 0.0;
    for (std::uint32_t y = 0; y + 1 < down_; ++y) {
      for (std::uint32_t x = 0; x + 1 < across_; ++x) {
        const cv::Point2f middle = 0.25f * (at(corners, x, y) + at(corners, x + 1, y) +
                                            at(corners, x, y + 1) + at(corners, x + 1, y + 1));
        const int column = std::clamp(cvRound(middle.x), 0, image.cols - 1),
                  row = std::clamp(cvRound(middle.y), 0, image.rows - 1);
        const double grey = image.at<unsigned char>(row, column);
        white_minus_black += board_.black(x + 1, y + 1) ? -grey : grey;
      }
    }
    if (white_minus_black < 0.0 && board_.orientation_known()) std::reverse(corners.begin(), corners.end());
  }

  BoardSpec board_;
  BoardFinderOptions options_;
  std::uint32_t across_, down_;
};

}  // namespace

std::unique_ptr<BoardFinder> make_chessboard_finder(const BoardSpec& board,
                                                    const BoardFinderOptions& options) {
  return std::make_unique<ChessboardFinder>(board, options);
}

}  // namespace glint
