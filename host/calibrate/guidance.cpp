// SPDX-License-Identifier: MIT
// Progress of sampling, camera by camera and pair by pair.
#include "host/calibrate/guidance.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include <Eigen/Eigenvalues>

#include "host/base/check.hpp"
#include "host/calibrate/homography.hpp"

namespace glint {
namespace {

// A target that hangs still gives the same sample over and over. Waved at 1 m/s, 3 m from a camera with a
// focal length of 914 px and 90 frames a second, it moves 3.4 px from frame to frame.
constexpr double kMoved = 0.0025;  // of the image's width: 3.2 px of 1280
// Two cameras 5 m apart and 3.5 m from the target see 10 cm of depth as 37 px of parallax. Below 6 px, noise
// and lens leave the pose of a pair uncertain.
constexpr double kFlat = 0.005;               // of the image's width, rms about the best plane
constexpr std::size_t kPairPoints = 200;      // kept per pair
constexpr std::size_t kLeastPairPoints = 50;  // before anything is said about planes
constexpr double kThin = 0.05;                // shortest principal spread over the longest: 5 % is a slab

std::string percent(double share) {
  return std::to_string(static_cast<int>(std::floor(100.0 * share))) + " %";
}

double part(double have, double wanted) { return wanted > 0 ? std::min(have / wanted, 1.0) : 1.0; }

}  // namespace

GuidanceWants wants_for(const Target& target) {
  GuidanceWants wants;
  if (target.kind == TargetKind::Board) {
    wants.ticks = 60;
    wants.common_ticks = 20;
    wants.least_ticks = 10;
    wants.least_common_ticks = 5;
  }
  return wants;
}

Guidance::Guidance(const Target& target, std::vector<SampleCamera> cameras,
                   const std::vector<CameraCalibration>& lenses)
    : Guidance(wants_for(target), std::move(cameras), lenses) {}

Guidance::Guidance(GuidanceWants wants, std::vector<SampleCamera> cameras,
                   const std::vector<CameraCalibration>& lenses)
    : wants_(wants), cameras_(std::move(cameras)), overlap_(cameras_.size()), by_camera_(cameras_.size()) {
  GLINT_CHECK(lenses.empty() || lenses.size() == cameras_.size());
  for (const SampleCamera& camera : cameras_)
    seen_.push_back({CoverageGrid(camera.width_px, camera.height_px), 0, {}});
  for (const CameraCalibration& lens : lenses) lenses_.emplace_back(lens);
  if (!lenses_.empty()) pairs_.resize(cameras_.size() * cameras_.size());
  counted_.reserve(cameras_.size());
}

bool Guidance::moved(const Seen& camera, std::span<const Sighting> now, double least_px) const noexcept {
  bool any_before = false;
  for (const Sighting& sighting : now) {
    for (const Sighting& before : camera.last) {
      if (before.point != sighting.point) continue;
      any_before = true;
      if ((before.pixel - sighting.pixel).squaredNorm() >= least_px * least_px) return true;
    }
  }
  return !any_before;  // other points than before: something new
}

void Guidance::add(std::span<const Sighting> tick) {
  if (tick.empty()) return;
  ++ticks_;
  std::fill(by_camera_.begin(), by_camera_.end(), std::span<const Sighting>());
  for (std::size_t begin = 0, end = 0; begin < tick.size(); begin = end) {
    while (end < tick.size() && tick[end].camera == tick[begin].camera) ++end;
    if (tick[begin].camera < cameras_.size())
      by_camera_[tick[begin].camera] = tick.subspan(begin, end - begin);
  }
  counted_.clear();
  bool news = false;
  for (std::uint32_t camera = 0; camera < cameras_.size(); ++camera) {
    const auto now = by_camera_[camera];
    if (now.empty()) continue;
    counted_.push_back(camera);
    Seen& seen = seen_[camera];
    if (!moved(seen, now, kMoved * cameras_[camera].width_px)) continue;
    news = true;
    ++seen.ticks;
    seen.last.assign(now.begin(), now.end());
    for (const Sighting& sighting : now) seen.coverage.add(sighting.pixel);
  }
  if (!news) return;
  overlap_.add(counted_);
  if (lenses_.empty()) return;
  for (std::size_t i = 0; i < counted_.size(); ++i) {
    for (std::size_t j = i + 1; j < counted_.size(); ++j)
      add_pair(by_camera_[counted_[i]], by_camera_[counted_[j]]);
  }
}

void Guidance::add(const SampleSet& samples) {
  for (const SampleTick& tick : ticks_of(samples)) add(tick.sightings);
}

void Guidance::add_pair(std::span<const Sighting> a, std::span<const Sighting> b) {
  PairPoints& pair = pairs_[a.front().camera * cameras_.size() + b.front().camera];
  if (pair.met++ % pair.every != 0) return;
  // One point of each tick, not always the same: its neighbours on the target say little more.
  const std::size_t first = pair.met / pair.every % a.size();
  for (std::size_t k = 0; k < a.size(); ++k) {
    const Sighting& in_a = a[(first + k) % a.size()];
    const auto in_b =
        std::find_if(b.begin(), b.end(), [&](const Sighting& s) { return s.point == in_a.point; });
    if (in_b == b.end()) continue;
    const auto x = lenses_[in_a.camera].undistort(in_a.pixel),
               y = lenses_[in_b->camera].undistort(in_b->pixel);
    if (!x || !y) return;
    pair.a.push_back(*x);
    pair.b.push_back(*y);
    break;
  }
  if (pair.a.size() < kPairPoints) return;
  for (auto* points : {&pair.a, &pair.b}) {  // every second stays, and from now on half as many come
    for (std::size_t i = 0; 2 * i < points->size(); ++i) (*points)[i] = (*points)[2 * i];
    points->resize(points->size() / 2);
  }
  pair.every *= 2;
}

bool Guidance::flat(std::size_t a, std::size_t b) const {
  const PairPoints& pair = pairs_[a * cameras_.size() + b];
  const auto b_from_a = find_homography(pair.a, pair.b);
  if (!b_from_a) return true;  // all on one line
  const CameraCalibration& lens = lenses_[b].calibration();
  const Eigen::Vector2d focal_px(lens.fx_px, lens.fy_px);
  double squares_px2 = 0.0;
  for (std::size_t i = 0; i < pair.a.size(); ++i) {
    const Eigen::Vector2d off = (*b_from_a * pair.a[i].homogeneous()).hnormalized() - pair.b[i];
    squares_px2 += off.cwiseProduct(focal_px).squaredNorm();
  }
  return std::sqrt(squares_px2 / static_cast<double>(pair.a.size())) < kFlat * cameras_[b].width_px;
}

std::vector<std::string> Guidance::plane_sentences() const {
  std::vector<std::string> names;
  std::size_t judged = 0;
  for (std::size_t a = 0; a < cameras_.size() && !lenses_.empty(); ++a) {
    for (std::size_t b = a + 1; b < cameras_.size(); ++b) {
      const PairPoints& pair = pairs_[a * cameras_.size() + b];
      if (pair.a.size() < kLeastPairPoints) continue;
      ++judged;
      if (flat(a, b)) names.push_back(cameras_[a].name + " and " + cameras_[b].name);
    }
  }
  if (names.empty()) return {};
  const std::string remedy = ": move the target higher and lower, nearer and farther";
  if (names.size() == judged) return {"all samples lie in one plane" + remedy};
  std::vector<std::string> sentences;
  sentences.reserve(names.size());
  for (const std::string& pair : names)
    sentences.push_back("what " + pair + " saw together lies in one plane" + remedy);
  return sentences;
}

GuidanceState Guidance::state() const {
  GuidanceState state;
  std::vector<std::string> names;
  for (const SampleCamera& camera : cameras_) names.push_back(camera.name);
  const auto linked_by = [&](std::size_t camera) {  // its best link to any other camera
    std::uint64_t most = 0;
    for (std::size_t other = 0; other < cameras_.size(); ++other)
      if (other != camera) most = std::max(most, overlap_.ticks(camera, other));
    return most;
  };

  state.progress = 1.0;
  for (std::size_t i = 0; i < cameras_.size(); ++i) {
    const Seen& seen = seen_[i];
    CameraProgress camera;
    camera.name = names[i];
    camera.ticks = seen.ticks;
    camera.covered = seen.coverage.share(wants_.ticks_per_cell);
    // The smallest of three shares: what lacks most decides, and the person sees it grow only by doing that.
    camera.progress = std::min({part(static_cast<double>(seen.ticks), static_cast<double>(wants_.ticks)),
                                part(camera.covered, wants_.covered),
                                cameras_.size() < 2 ? 1.0
                                                    : part(static_cast<double>(linked_by(i)),
                                                           static_cast<double>(wants_.common_ticks))});
    if (camera.covered < wants_.covered) {
      camera.missing = seen.coverage.sentence(wants_.ticks_per_cell);
      if (camera.missing.empty()) camera.missing = "too little yet near the edges of the image";
    }
    state.progress = std::min(state.progress, camera.progress);
    state.cameras.push_back(std::move(camera));
  }

  for (const CameraProgress& camera : state.cameras) {
    if (camera.ticks > 0 && camera.ticks < wants_.least_ticks) {
      state.blocking.push_back(camera.name + " has " + std::to_string(camera.ticks) +
                               (camera.ticks == 1 ? " sample" : " samples") + ", and at least " +
                               std::to_string(wants_.least_ticks) +
                               " are needed: move the target in its view");
    }
  }
  for (std::string& sentence : overlap_.sentences(names, wants_.least_common_ticks))
    state.blocking.push_back(std::move(sentence));
  if (cameras_.size() < 2 && !cameras_.empty() && state.cameras[0].ticks == 0)
    state.blocking.push_back(names[0] + " has not seen the target");
  state.sentences = state.blocking;

  // Those with least first.
  std::vector<std::size_t> order(cameras_.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](auto a, auto b) { return state.cameras[a].progress < state.cameras[b].progress; });
  for (const std::size_t i : order) {
    const CameraProgress& camera = state.cameras[i];
    if (camera.ticks > 0 && !camera.missing.empty())
      state.sentences.push_back(camera.name + ": " + camera.missing);
  }
  if (state.blocking.empty()) {
    for (std::string& sentence : overlap_.sentences(names, wants_.common_ticks))
      state.sentences.push_back(std::move(sentence));
  }
  const std::vector<std::string> planes = plane_sentences();
  state.sentences.insert(state.sentences.end(), planes.begin(), planes.end());
  for (const std::size_t i : order) {
    const CameraProgress& camera = state.cameras[i];
    if (camera.ticks >= wants_.least_ticks && camera.ticks < wants_.ticks) {
      state.sentences.push_back(camera.name + ": " + std::to_string(wants_.ticks - camera.ticks) +
                                " more samples wanted; keep moving");
    }
  }
  state.ready = !cameras_.empty() && state.sentences.empty();
  return state;
}

std::string Guidance::status_line(std::size_t columns) const {
  const GuidanceState now = state();
  std::string line;
  for (const CameraProgress& camera : now.cameras)
    line += (line.empty() ? "" : "  ") + camera.name + " " + percent(camera.progress);
  if (line.size() > columns / 2) {  // the sentence matters more than the list
    const auto done = std::count_if(now.cameras.begin(), now.cameras.end(),
                                    [](const CameraProgress& camera) { return camera.progress >= 1.0; });
    const auto least = std::min_element(now.cameras.begin(), now.cameras.end(),
                                        [](const auto& a, const auto& b) { return a.progress < b.progress; });
    line = std::to_string(done) + " of " + std::to_string(now.cameras.size()) + " cameras ready";
    if (least->progress < 1.0) line += ", least " + least->name + " " + percent(least->progress);
  }
  line += "  |  " + (now.ready               ? std::string("enough: stop when you like")
                     : now.sentences.empty() ? std::string()
                                             : now.sentences.front());
  if (line.size() > columns) line = line.substr(0, columns > 3 ? columns - 3 : 0) + "...";
  return line;
}

Eigen::Vector3d principal_spread_m(std::span<const Eigen::Vector3d> points_in_world) {
  if (points_in_world.empty()) return Eigen::Vector3d::Zero();
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p : points_in_world) mean += p;
  mean /= static_cast<double>(points_in_world.size());
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d& p : points_in_world) covariance += (p - mean) * (p - mean).transpose();
  covariance /= static_cast<double>(points_in_world.size());
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance, Eigen::EigenvaluesOnly);
  return solver.eigenvalues().reverse().cwiseMax(0.0).cwiseSqrt();
}

std::string spread_sentence(std::span<const Eigen::Vector3d> points_in_world) {
  const Eigen::Vector3d sd = principal_spread_m(points_in_world);
  if (!(sd[0] > 0)) return "all samples are at one place: move the target through the whole volume";
  if (sd[1] < kThin * sd[0]) return "all samples lie on one line: move the target through the whole volume";
  if (sd[2] < kThin * sd[0])
    return "all samples lie in one plane: move the target higher and lower, nearer and farther";
  return {};
}

}  // namespace glint
