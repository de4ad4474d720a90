// SPDX-License-Identifier: MIT
// From views of a board to a lens: start, solution, outliers, proof on held-out views, deviations, verdict.
#include "host/calibrate/intrinsics.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "host/base/check.hpp"
#include "host/base/error.hpp"
#include "host/calibrate/homography.hpp"
#include "host/calibrate/intrinsics_solver.hpp"
#include "host/calibrate/pnp.hpp"
#include "host/calibrate/zhang_start.hpp"

namespace glint {
namespace {

constexpr double kFirstHuber_px = 3.0;  // the start is off by some pixels everywhere
constexpr double kLeastHuber_px = 0.1;
constexpr double kNoHuber_px = 1e9;
constexpr double kOutlierTimes = 3.0;              // of the median view's rms
constexpr double kLeastOutlier_px = 0.5;           // a view as good as this is never left out
constexpr std::size_t kHoldOutFrom = 10;           // views
constexpr double kClearSd = 6.0, kWorthK3 = 0.97;  // k3 differs from 0, and the residuals shrink by that

std::string number_text(const char* format, double value) {
  char text[40];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

std::vector<Eigen::Vector3d> points_of(const Target& board, const BoardPoints& view) {
  std::vector<Eigen::Vector3d> points;
  for (const std::uint32_t point : view.points) points.push_back(board.points_in_target[point]);
  return points;
}

double rms_of(std::span<const Eigen::Vector2d> residuals) {
  double squares = 0.0;
  for (const Eigen::Vector2d& r : residuals) squares += r.squaredNorm();
  return residuals.empty() ? 0.0 : std::sqrt(squares / static_cast<double>(residuals.size()));
}

/// Median of |x| and |y| times what makes it the standard deviation of a normal distribution.
double robust_sigma(std::vector<double>& absolute) {
  const auto middle = absolute.begin() + static_cast<std::ptrdiff_t>(absolute.size() / 2);
  std::nth_element(absolute.begin(), middle, absolute.end());
  return 1.4826 * *middle;
}

/// The views of one camera on their way to a solution.
class LensFit {
 public:
  LensFit(const Target& board, const SampleCamera& camera, const std::vector<BoardPoints>& views,
          LensFreedom freedom, bool robust)
      : board_(board), freedom_(freedom), robust_(robust) {
    camera_.name = camera.name;
    camera_.width_px = camera.width_px;
    camera_.height_px = camera.height_px;
    for (const BoardPoints& view : views) views_.push_back({&view, {}, true});
  }

  std::vector<SolverView>& views() noexcept { return views_; }
  const LensSolution& solution() const noexcept { return solution_; }
  const CameraCalibration& camera() const noexcept { return camera_; }

  /// Views that are not in use stay out.
  void solve() {
    start();
    place_views();
    take(solve_lens(board_.points_in_target, views_, intrinsics_of(camera_), {false, false}, kFirstHuber_px));
    place_views();  // under a better lens some views have the other of their two poses
    take(solve_lens(board_.points_in_target, views_, intrinsics_of(camera_), freedom_, kFirstHuber_px));
    finish();
  }

  /// Goes on with k3 as one more unknown.
  void free_k3() {
    freedom_.k3 = true;
    finish();
  }

  /// Again, after views were left out.
  void finish() {
    // Twice, since the loss follows from what is left over.
    for (int i = 0; i < 2; ++i)
      take(solve_lens(board_.points_in_target, views_, intrinsics_of(camera_), freedom_, huber_px()));
  }

  /// Rms of a view with the lens as it is; one that was not used gets its own pose first.
  double view_rms(SolverView& view) {
    if (!view.used && !place(view)) return 1e4;
    return rms_of(residuals_px(board_.points_in_target, view, solution_.intrinsics));
  }

  std::optional<Intrinsics> deviations() {
    return lens_deviations(board_.points_in_target, views_, solution_, freedom_, huber_px());
  }

 private:
  void start() {
    std::vector<Eigen::Matrix3d> homographies;
    for (const SolverView& view : views_) {
      if (!view.used) continue;
      std::vector<Eigen::Vector2d> plane;
      for (const Eigen::Vector3d& p : points_of(board_, *view.seen)) plane.push_back(p.head<2>());
      if (const auto h = find_homography(plane, view.seen->pixels)) homographies.push_back(*h);
    }
    const CameraCalibration guess = zhang_start(homographies, camera_.width_px, camera_.height_px);
    set_intrinsics(camera_, intrinsics_of(guess));
  }

  bool place(SolverView& view) const {
    const auto pose = camera_from_target(camera_, points_of(board_, *view.seen), view.seen->pixels);
    if (pose) view.camera_from_board = *pose;
    return pose.has_value();
  }

  void place_views() {
    for (SolverView& view : views_)
      if (view.used) view.used = place(view);
  }

  double huber_px() const {
    if (!robust_) return kNoHuber_px;
    std::vector<double> absolute;
    for (const SolverView& view : views_) {
      if (!view.used) continue;
      for (const Eigen::Vector2d& r : residuals_px(board_.points_in_target, view, solution_.intrinsics)) {
        absolute.push_back(std::abs(r.x()));
        absolute.push_back(std::abs(r.y()));
      }
    }
    return absolute.empty() ? kFirstHuber_px : std::max(kLeastHuber_px, 3.0 * robust_sigma(absolute));
  }

  void take(const LensSolution& solution) {
    solution_ = solution;
    set_intrinsics(camera_, solution.intrinsics);
  }

  const Target& board_;
  LensFreedom freedom_;
  bool robust_;
  CameraCalibration camera_;
  std::vector<SolverView> views_;
  LensSolution solution_;
};

/// Leaves out what fits far worse than the median, a few times over since the rest then fits better.
std::vector<bool> leave_out_outliers(LensFit& fit) {
  std::vector<bool> outlier(fit.views().size(), false);
  for (int round = 0; round < 5; ++round) {
    std::vector<double> rms;
    for (SolverView& view : fit.views())
      if (view.used) rms.push_back(fit.view_rms(view));
    if (rms.empty()) break;
    std::nth_element(rms.begin(), rms.begin() + static_cast<std::ptrdiff_t>(rms.size() / 2), rms.end());
    const double limit_px = std::max(kLeastOutlier_px, kOutlierTimes * rms[rms.size() / 2]);
    bool any = false;
    for (std::size_t i = 0; i < fit.views().size(); ++i) {
      SolverView& view = fit.views()[i];
      const bool bad = !outlier[i] && (!view.used || fit.view_rms(view) > limit_px);
      if (!bad) continue;
      outlier[i] = any = true;
      view.used = false;
    }
    if (!any) break;
    fit.finish();
  }
  return outlier;
}

/// Every fifth view of those that are left judges a lens that the others gave.
double held_out_rms(const Target& board, const SampleCamera& camera, const std::vector<BoardPoints>& views,
                    LensFreedom freedom, bool robust, std::vector<BoardViewResult>& results) {
  LensFit fit(board, camera, views, freedom, robust);
  std::size_t good = 0;
  for (std::size_t i = 0; i < views.size(); ++i) {
    fit.views()[i].used = !results[i].outlier;
    if (!results[i].outlier) results[i].held_out = good++ % 5 == 4;
  }
  if (good < kHoldOutFrom) {
    for (BoardViewResult& view : results) view.held_out = false;
    return 0.0;
  }
  for (std::size_t i = 0; i < views.size(); ++i)
    if (results[i].held_out) fit.views()[i].used = false;
  fit.solve();
  double squares = 0.0;
  std::size_t corners = 0;
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (!results[i].held_out) continue;
    const double rms = fit.view_rms(fit.views()[i]);
    squares += rms * rms * static_cast<double>(results[i].corners);
    corners += results[i].corners;
  }
  return std::sqrt(squares / static_cast<double>(corners));
}

/// What to say if the lens bends light in a way that k1 and k2 alone do not describe; empty: they do.
std::string k3_advice(LensFit fit, double rms_px) {
  fit.free_k3();
  const auto deviations = fit.deviations();
  if (!deviations || std::abs(fit.solution().intrinsics[8]) < kClearSd * (*deviations)[8] ||
      fit.solution().rms_px > kWorthK3 * rms_px)
    return "";
  return "--k3: this lens needs it (" + number_text("%.3f", fit.solution().rms_px) + " px rms instead of " +
         number_text("%.3f", rms_px) + ")";
}

/// Largest angle between the board's normals in any two views.
double largest_turn(std::span<const BoardViewResult> views) {
  double largest = 0.0;
  for (const BoardViewResult& a : views) {
    for (const BoardViewResult& b : views) {
      if (a.outlier || b.outlier) continue;
      const Eigen::Vector3d z = Eigen::Vector3d::UnitZ();
      const double cosine = (a.camera_from_target.rotation * z).dot(b.camera_from_target.rotation * z);
      largest = std::max(largest, std::acos(std::clamp(cosine, -1.0, 1.0)));
    }
  }
  return largest;
}

/// The word and its rule; every limit must be kept for a word.
void judge(IntrinsicsResult& result) {
  struct Limits {
    Verdict verdict;
    const char* word;
    double focal_sd, covered, rms_px, held_out_times;
  };
  // Held-out views cost six numbers of pose each, and the lens none: they should fit nearly as well.
  constexpr Limits kLimits[] = {{Verdict::Excellent, "excellent", 0.001, 0.8, 0.3, 1.25},
                                {Verdict::Good, "good", 0.003, 0.6, 0.7, 1.5},
                                {Verdict::Poor, "poor", 0.02, 0.0, 1.5, 3.0}};
  const CameraCalibration& c = result.camera;
  const double focal_sd =
      std::max(c.intrinsics_sd[0] / std::abs(c.fx_px), c.intrinsics_sd[1] / std::abs(c.fy_px));
  for (const Limits& limits : kLimits) {
    result.rule = std::string(limits.word) + ": focal length known to " +
                  number_text("%.1f", 100.0 * limits.focal_sd) + " %, corners in " +
                  number_text("%.0f", 100.0 * limits.covered) + " % of the image, at most " +
                  number_text("%.1f", limits.rms_px) + " px rms, held-out views at most " +
                  number_text("%.2f", limits.held_out_times) + " times as bad as the others";
    const bool held_out_good = result.held_out_rms_px <= limits.held_out_times * result.rms_px &&
                               (result.held_out_rms_px > 0.0 || limits.verdict == Verdict::Poor);
    if (focal_sd <= limits.focal_sd && result.covered >= limits.covered && result.rms_px <= limits.rms_px &&
        held_out_good) {
      result.verdict = limits.verdict;
      return;
    }
  }
  result.verdict = Verdict::Refuse;
  result.rule = "refuse: does not even keep the limits of " + result.rule;
}

}  // namespace

IntrinsicsResult calibrate_intrinsics(const SampleSet& samples, std::uint32_t camera,
                                      const IntrinsicsOptions& options) {
  GLINT_CHECK(camera < samples.cameras.size());
  const SampleCamera& about = samples.cameras[camera];
  if (samples.target.kind != TargetKind::Board || samples.target.points_in_target.size() < 4)
    throw Error("the samples are of " + samples.target.name + ": a lens is calibrated with a printed board");
  BoardSession session(samples.target, about.width_px, about.height_px);
  std::vector<std::uint64_t> ticks;
  for (const SampleTick& tick : ticks_of(samples)) {
    BoardPoints view;
    for (const Sighting& s : tick.sightings) {
      if (s.camera != camera) continue;
      view.points.push_back(s.point);
      view.pixels.push_back(s.pixel);
    }
    const std::size_t before = session.views().size();
    if (view.points.size() >= 4) session.add_always(view);
    if (session.views().size() > before) ticks.push_back(tick.tick);
  }
  const auto refuse = [&](const std::string& why) -> void { throw Error(about.name + ": " + why); };
  if (const auto reasons = session.blocking(); !reasons.empty()) {
    std::string text;
    for (const std::string& reason : reasons) text += (text.empty() ? "" : "; ") + reason;
    refuse(text);
  }

  const LensFreedom freedom{true, options.k3};
  LensFit fit(samples.target, about, session.views(), freedom, options.robust);
  fit.solve();
  const std::vector<bool> outlier =
      options.robust ? leave_out_outliers(fit) : std::vector<bool>(fit.views().size(), false);
  const auto left = static_cast<std::size_t>(std::count(outlier.begin(), outlier.end(), false));
  if (!fit.solution().converged || 2 * left < outlier.size() || left < BoardWants{}.least_views) {
    refuse("the views contradict one another: only " + std::to_string(left) + " of " +
           std::to_string(outlier.size()) +
           " fit one lens. Is the board flat, its size as given, the focus fixed, and each picture of the "
           "same camera?");
  }

  IntrinsicsResult result;
  for (std::size_t i = 0; i < outlier.size(); ++i) {
    BoardViewResult view;
    view.tick = ticks[i];
    view.corners = session.views()[i].points.size();
    view.outlier = outlier[i];
    view.rms_px = fit.view_rms(fit.views()[i]);
    view.camera_from_target = fit.views()[i].camera_from_board;
    result.views.push_back(view);
  }
  result.camera = fit.camera();
  result.rms_px = result.camera.rms_px = fit.solution().rms_px;
  result.sigma_px = fit.solution().sigma_px;
  if (const double turn = largest_turn(result.views); turn < BoardWants{}.least_tilt_rad)
    refuse(parallel_sentence(turn));
  const auto deviations = fit.deviations();
  if (!deviations) {
    refuse(
        "the views do not determine all parameters of the lens; tilt the board by 20 to 45 degrees, to all "
        "sides, and show it all over the image");
  }
  result.camera.intrinsics_sd = *deviations;
  result.held_out_rms_px =
      held_out_rms(samples.target, about, session.views(), freedom, options.robust, result.views);
  result.covered = session.coverage().share();
  result.advice = session.missing();
  if (!options.k3) {
    const std::string advice = k3_advice(fit, result.rms_px);
    if (!advice.empty()) result.advice.insert(result.advice.begin(), advice);
  }
  judge(result);
  return result;
}

}  // namespace glint
