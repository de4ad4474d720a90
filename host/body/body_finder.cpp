// SPDX-License-Identifier: MIT
// Pair distances, triples, verification, joint choice.
#include "host/body/body_finder.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "host/base/check.hpp"
#include "host/body/point_pose.hpp"
#include "host/geometry/rotation.hpp"

namespace glint {
namespace {

constexpr double kBin_m = 0.001;
constexpr double kPairSigmas = 3.5;    // a true pair's distance is off by more once in 2,000
constexpr double kReachSigmas = 10.0;  // a pose from three markers carries a far marker off by some of these
constexpr double kMarkerChi2 = 21.1;   // three degrees of freedom, once in 10,000
constexpr double kMirroredLogOdds = -3.0;  // somebody else's body happens to be a mirror image, 1 : 20
constexpr std::size_t kMostCandidates = 4096;
constexpr std::size_t kReserved = 256;

double point_sd(const Eigen::Matrix3d& covariance, double floor_m) noexcept {
  return std::sqrt(covariance.trace() + floor_m * floor_m);
}

}  // namespace

void FinderOptions::check(std::vector<std::string>& problems) const {
  if (min_markers < 3) problems.emplace_back("body_finder.min_markers must be >= 3");
  if (!(max_missing_share > 0.0 && max_missing_share <= 1.0))
    problems.emplace_back("body_finder.max_missing_share must be > 0 and <= 1");
  if (!(point_floor_m > 0.0)) problems.emplace_back("body_finder.point_floor_m must be > 0");
  if (!(detected > 0.0 && detected < 1.0))
    problems.emplace_back("body_finder.detected must be between 0 and 1");
}

BodyFinder::BodyFinder(std::vector<WantedShape> shapes, const FinderOptions& options)
    : real_(shapes.size()), shapes_(std::move(shapes)), options_(options) {
  for (std::size_t s = 0; s < real_; ++s) {
    WantedShape mirrored = shapes_[s];
    for (Eigen::Vector3d& marker : mirrored.markers_in_shape) marker.z() = -marker.z();
    shapes_.push_back(std::move(mirrored));
  }
  for (std::uint32_t s = 0; s < shapes_.size(); ++s) {
    const auto& markers = shapes_[s].markers_in_shape;
    GLINT_CHECK(markers.size() >= 3 && markers.size() <= kBodyMarkers);
    largest_sd_m_ = std::max(largest_sd_m_, shapes_[s].marker_sd_m);
    double diameter = 0.0;
    for (std::uint32_t i = 0; i < markers.size(); ++i)
      for (std::uint32_t j = i + 1; j < markers.size(); ++j) {
        const double distance = (markers[i] - markers[j]).norm();
        table_.push_back({distance, s, i, j});
        diameter = std::max(diameter, distance);
      }
    diameter_m_.push_back(diameter);
  }
  std::sort(table_.begin(), table_.end(), [](const TableEntry& a, const TableEntry& b) {
    return a.distance_m != b.distance_m ? a.distance_m < b.distance_m : a.shape < b.shape;
  });
  const double longest = table_.empty() ? 0.0 : table_.back().distance_m;
  first_entry_.resize(static_cast<std::size_t>(longest / kBin_m) + 2);
  std::uint32_t entry = 0;
  for (std::size_t bin = 0; bin < first_entry_.size(); ++bin) {
    while (entry < table_.size() && table_[entry].distance_m < static_cast<double>(bin) * kBin_m) ++entry;
    first_entry_[bin] = entry;
  }
  candidates_.reserve(kReserved);
}

unsigned BodyFinder::least_markers(std::uint32_t shape) const noexcept {
  const auto n = static_cast<double>(shapes_[shape].markers_in_shape.size());
  // Fewer than n * share may be missing.
  const auto missing = static_cast<unsigned>(std::ceil(n * options_.max_missing_share) - 1.0);
  return std::max(options_.min_markers, static_cast<unsigned>(n) - missing);
}

void BodyFinder::find(std::span<const FinderPoint> points, std::span<const std::uint32_t> wanted,
                      std::vector<FoundBody>& found, FinderCounters& counters) {
  GLINT_CHECK(wanted.size() == real_);
  found.clear();
  candidates_.clear();
  link_next_.clear();
  link_candidate_.clear();
  double reach = 0.0;
  for (std::size_t s = 0; s < real_; ++s)
    if (wanted[s] > 0) reach = std::max(reach, diameter_m_[s]);
  if (points.size() < options_.min_markers || reach == 0.0) return;
  head_.assign(shapes_.size() * points.size(), kMarkerNotSeen);
  sd_m_.clear();
  Eigen::Vector3d low = points[0].position_in_world, high = low;
  for (const FinderPoint& p : points) {
    sd_m_.push_back(point_sd(p.covariance_m2, options_.point_floor_m));
    low = low.cwiseMin(p.position_in_world);
    high = high.cwiseMax(p.position_in_world);
  }
  // At least a cubic metre: points of one body alone are not dense because the room is small.
  const double volume = std::max(1.0, (high - low).prod());
  log_volume_ = std::log(volume);
  log_density_ = std::log(static_cast<double>(points.size()) / volume);
  collect_neighbours(points, reach + 0.02);

  look_for_.assign(shapes_.size(), 0);
  std::transform(wanted.begin(), wanted.end(), look_for_.begin(),
                 [](std::uint32_t count) { return static_cast<std::uint8_t>(count > 0 ? 1 : 0); });
  collect_candidates(points, counters);
  choose(points, wanted, counters);
  // What lacks markers may be the mirror image of a body, some of whose markers lie as the body's own do.
  look_for_.assign(shapes_.size(), 0);
  bool doubtful = false;
  for (const std::uint32_t number : chosen_) {
    const FoundBody& body = candidates_[number].body;
    if (body.markers == shapes_[body.shape].markers_in_shape.size()) continue;
    look_for_[real_ + body.shape] = 1;
    doubtful = true;
  }
  if (doubtful) {
    collect_candidates(points, counters);
    choose(points, wanted, counters);
  }
  hand_over(wanted, found, counters);
}

void BodyFinder::collect_candidates(std::span<const FinderPoint> points, FinderCounters& counters) {
  for (std::uint32_t a = 0; a < points.size(); ++a)
    for (std::uint32_t k = first_neighbour_[a]; k < first_neighbour_[a + 1]; ++k) {
      const Neighbour& b = neighbours_[k];
      if (b.point < a) continue;
      const double sd = std::sqrt(sd_m_[a] * sd_m_[a] + sd_m_[b.point] * sd_m_[b.point] +
                                  2.0 * largest_sd_m_ * largest_sd_m_);
      const double tolerance = kPairSigmas * sd;
      const double from = std::max(0.0, b.distance_m - tolerance);
      const auto bin = static_cast<std::size_t>(from / kBin_m);
      if (bin >= first_entry_.size()) continue;
      for (std::uint32_t e = first_entry_[bin]; e < table_.size(); ++e) {
        if (table_[e].distance_m > b.distance_m + tolerance) break;
        if (table_[e].distance_m < from || look_for_[table_[e].shape] == 0) continue;
        extend_pair(points, a, b, table_[e], false, counters);
        extend_pair(points, a, b, table_[e], true, counters);
      }
    }
}

void BodyFinder::collect_neighbours(std::span<const FinderPoint> points, double reach_m) {
  const auto n = static_cast<std::uint32_t>(points.size());
  by_x_.resize(n);
  for (std::uint32_t k = 0; k < n; ++k) by_x_[k] = k;
  std::sort(by_x_.begin(), by_x_.end(), [points](std::uint32_t a, std::uint32_t b) {
    const double xa = points[a].position_in_world.x(), xb = points[b].position_in_world.x();
    return xa != xb ? xa < xb : a < b;
  });
  const auto each_pair = [&](auto&& visit) {
    for (std::uint32_t i = 0; i < n; ++i)
      for (std::uint32_t j = i + 1; j < n; ++j) {
        const Eigen::Vector3d d = points[by_x_[j]].position_in_world - points[by_x_[i]].position_in_world;
        if (d.x() > reach_m) break;
        if (const double square = d.squaredNorm(); square <= reach_m * reach_m)
          visit(by_x_[i], by_x_[j], std::sqrt(square));
      }
  };
  first_neighbour_.assign(n + 2, 0);
  each_pair([&](std::uint32_t a, std::uint32_t b, double) {
    ++first_neighbour_[a + 2];
    ++first_neighbour_[b + 2];
  });
  for (std::size_t k = 2; k < first_neighbour_.size(); ++k) first_neighbour_[k] += first_neighbour_[k - 1];
  neighbours_.resize(first_neighbour_[n + 1]);
  each_pair([&](std::uint32_t a, std::uint32_t b, double distance) {
    neighbours_[first_neighbour_[a + 1]++] = {distance, b};
    neighbours_[first_neighbour_[b + 1]++] = {distance, a};
  });
  for (std::uint32_t k = 0; k < n; ++k)
    std::sort(neighbours_.begin() + first_neighbour_[k], neighbours_.begin() + first_neighbour_[k + 1],
              [](const Neighbour& a, const Neighbour& b) {
                return a.distance_m != b.distance_m ? a.distance_m < b.distance_m : a.point < b.point;
              });
}

// Points a < b < c, so that each triple is met once per labelling.
void BodyFinder::extend_pair(std::span<const FinderPoint> points, std::uint32_t a, const Neighbour& b,
                             const TableEntry& entry, bool turned, FinderCounters& counters) {
  const std::uint32_t i = turned ? entry.j : entry.i, j = turned ? entry.i : entry.j;
  const auto& markers = shapes_[entry.shape].markers_in_shape;
  const double sd = shapes_[entry.shape].marker_sd_m;
  const auto begin = neighbours_.begin() + first_neighbour_[a],
             end = neighbours_.begin() + first_neighbour_[a + 1];
  for (std::uint32_t k = 0; k < markers.size(); ++k) {
    if (k == i || k == j) continue;
    const double ik = (markers[i] - markers[k]).norm(), jk = (markers[j] - markers[k]).norm();
    // Wide enough for any third point; each is then judged by its own uncertainty.
    const double widest = kPairSigmas * std::sqrt(2.0) * std::max(sd_m_[a] + sd, 2e-3);
    for (auto c = std::lower_bound(begin, end, ik - widest,
                                   [](const Neighbour&n, double d) { return n.distance_m < d; });
         c != end && c->distance_m <= ik + widest; ++c) {
      if (c->point <= b.point) continue;
      const double own = sd_m_[c->point] * sd_m_[c->point] + 2.0 * sd * sd;
      const double off_a = c->distance_m - ik;
      if (off_a * off_a > kPairSigmas * kPairSigmas * (own + sd_m_[a] * sd_m_[a])) continue;
      const double off_b =
          (points[c->point].position_in_world - points[b.point].position_in_world).norm() - jk;
      if (off_b * off_b > kPairSigmas * kPairSigmas * (own + sd_m_[b.point] * sd_m_[b.point])) continue;
      consider(points, entry.shape, {i, j, k}, {a, b.point, c->point}, counters);
    }
  }
}

bool BodyFinder::covered(std::uint32_t shape, const std::array<std::uint32_t, 3>& markers,
                         const std::array<std::uint32_t, 3>& at) const noexcept {
  for (std::uint32_t link = head_[shape * sd_m_.size() + at[0]]; link != kMarkerNotSeen;
       link = link_next_[link]) {
    const auto& points = candidates_[link_candidate_[link]].body.point_of_marker;
    if (points[markers[0]] == at[0] && points[markers[1]] == at[1] && points[markers[2]] == at[2])
      return true;
  }
  return false;
}

std::uint32_t BodyFinder::nearest(std::span<const FinderPoint> points, std::uint32_t from, double distance_m,
                                  const Eigen::Vector3d& at, double reach_m) const noexcept {
  const auto begin = neighbours_.begin() + first_neighbour_[from],
             end = neighbours_.begin() + first_neighbour_[from + 1];
  std::uint32_t best = kMarkerNotSeen;
  double best_square = reach_m * reach_m;
  for (auto c = std::lower_bound(begin, end, distance_m - reach_m,
                                 [](const Neighbour&n, double d) { return n.distance_m < d; });
       c != end && c->distance_m <= distance_m + reach_m; ++c) {
    const double square = (points[c->point].position_in_world - at).squaredNorm();
    if (square > best_square) continue;
    best_square = square;
    best = c->point;
  }
  return best;
}

void BodyFinder::consider(std::span<const FinderPoint> points, std::uint32_t shape,
                          const std::array<std::uint32_t, 3>& markers, const std::array<std::uint32_t, 3>& at,
                          FinderCounters& counters) {
  if (covered(shape, markers, at)) return;
  if (candidates_.size() >= kMostCandidates) {
    ++counters.candidates_cut;
    return;
  }
  const auto& model = shapes_[shape].markers_in_shape;
  const auto start = pose_from_triple(
      {model[markers[0]], model[markers[1]], model[markers[2]]},
      {points[at[0]].position_in_world, points[at[1]].position_in_world, points[at[2]].position_in_world});
  if (!start) return;
  FoundBody body;
  body.shape = shape;
  body.world_from_shape = *start;
  body.point_of_marker.fill(kMarkerNotSeen);
  for (std::size_t k = 0; k < 3; ++k) body.point_of_marker[markers[k]] = at[k];
  body.markers = 3;
  const double reach = kReachSigmas * std::max(sd_m_[at[0]], shapes_[shape].marker_sd_m);
  for (std::uint32_t m = 0; m < model.size(); ++m) {
    if (body.point_of_marker[m] != kMarkerNotSeen) continue;
    const std::uint32_t point =
        nearest(points, at[0], (model[m] - model[markers[0]]).norm(), *start * model[m], reach);
    const auto taken = body.point_of_marker.begin();
    if (point == kMarkerNotSeen || std::find(taken, taken + static_cast<std::ptrdiff_t>(model.size()),
                                             point) != taken + static_cast<std::ptrdiff_t>(model.size()))
      continue;
    body.point_of_marker[m] = point;
    ++body.markers;
  }
  if (body.markers < least_markers(shape) || !refine(points, body)) return;
  ++counters.candidates;
  body.score = score_of(points, body) + (shape < real_ ? 0.0 : kMirroredLogOdds);
  if (!(body.score > options_.min_score)) return;
  const auto number = static_cast<std::uint32_t>(candidates_.size());
  for (std::uint32_t m = 0; m < model.size(); ++m) {
    if (body.point_of_marker[m] == kMarkerNotSeen) continue;
    std::uint32_t& head = head_[shape * points.size() + body.point_of_marker[m]];
    link_candidate_.push_back(number);
    link_next_.push_back(head);
    head = static_cast<std::uint32_t>(link_next_.size() - 1);
  }
  candidates_.push_back({body});
}

// The pose of all its points; those that do not fit are let go, worst first.
bool BodyFinder::refine(std::span<const FinderPoint> points, FoundBody& body) const noexcept {
  const auto& model = shapes_[body.shape].markers_in_shape;
  const double sd = shapes_[body.shape].marker_sd_m;
  for (;;) {
    std::array<Eigen::Vector3d, kBodyMarkers> in_world, in_shape;
    std::array<double, kBodyMarkers> weights;
    std::array<std::uint32_t, kBodyMarkers> marker;
    std::size_t n = 0;
    for (std::uint32_t m = 0; m < model.size(); ++m) {
      const std::uint32_t point = body.point_of_marker[m];
      if (point == kMarkerNotSeen) continue;
      in_world[n] = points[point].position_in_world;
      in_shape[n] = model[m];
      weights[n] = 1.0 / (sd_m_[point] * sd_m_[point] + 3.0 * sd * sd);
      marker[n++] = m;
    }
    const auto pose = pose_from_points({in_shape.data(), n}, {in_world.data(), n}, {weights.data(), n});
    if (!pose) return false;
    body.world_from_shape = *pose;
    double worst = kMarkerChi2;
    std::size_t drop = n;
    for (std::size_t k = 0; k < n; ++k) {
      const Eigen::Vector3d r = in_world[k] - *pose * in_shape[k];
      const double variance = options_.point_floor_m * options_.point_floor_m + sd * sd;
      const Eigen::Matrix3d spread =
          points[body.point_of_marker[marker[k]]].covariance_m2 + variance * Eigen::Matrix3d::Identity();
      if (const double chi2 = r.dot(spread.inverse() * r); chi2 > worst) {
        worst = chi2;
        drop = k;
      }
    }
    if (drop == n) return true;
    body.point_of_marker[marker[drop]] = kMarkerNotSeen;
    if (--body.markers < least_markers(body.shape)) return false;
  }
}

// Points of nobody come with a uniform density, bodies with a uniform pose; what the pose explains is
// integrated over it (Laplace's method, which is exact here but for the turn's curvature).
double BodyFinder::score_of(std::span<const FinderPoint> points, FoundBody& body) const noexcept {
  const auto& model = shapes_[body.shape].markers_in_shape;
  const double variance = options_.point_floor_m * options_.point_floor_m +
                          shapes_[body.shape].marker_sd_m * shapes_[body.shape].marker_sd_m;
  double score = -log_volume_ - std::log(8.0 * M_PI * M_PI);
  Matrix6 information = Matrix6::Zero();
  for (std::uint32_t m = 0; m < model.size(); ++m) {
    if (body.point_of_marker[m] == kMarkerNotSeen) {
      score += std::log(1.0 - options_.detected);
      continue;
    }
    const FinderPoint& point = points[body.point_of_marker[m]];
    const Eigen::Matrix3d spread = point.covariance_m2 + variance * Eigen::Matrix3d::Identity();
    const Eigen::Matrix3d inverse = spread.inverse();
    const Eigen::Vector3d r = point.position_in_world - body.world_from_shape * model[m];
    score += -0.5 * r.dot(inverse * r) - 0.5 * std::log(spread.determinant()) - 1.5 * std::log(2.0 * M_PI) -
             log_density_ + std::log(options_.detected);
    Eigen::Matrix<double, 3, 6> by_pose;
    by_pose.leftCols<3>() = -cross_matrix(body.world_from_shape.rotation * model[m]);
    by_pose.rightCols<3>().setIdentity();
    information.noalias() += by_pose.transpose() * inverse * by_pose;
  }
  const Eigen::LDLT<Matrix6> factor(information);
  if (factor.info() != Eigen::Success || !factor.isPositive()) return -1.0;
  body.covariance = factor.solve(Matrix6::Identity());
  body.covariance = 0.5 * (body.covariance + body.covariance.transpose()).eval();
  return score + 3.0 * std::log(2.0 * M_PI) - 0.5 * factor.vectorD().array().log().sum();
}

void BodyFinder::choose(std::span<const FinderPoint> points, std::span<const std::uint32_t> wanted,
                        FinderCounters& counters) {
  // A shape wanted once is an element of its own, which only one set may use. Several of one shape are all
  // chosen first, and the best kept.
  packing_.reset(points.size() + shapes_.size());
  for (const Candidate& candidate : candidates_) {
    elements_.clear();
    for (std::size_t m = 0; m < shapes_[candidate.body.shape].markers_in_shape.size(); ++m)
      if (candidate.body.point_of_marker[m] != kMarkerNotSeen)
        elements_.push_back(candidate.body.point_of_marker[m]);
    if (candidate.body.shape < real_ && wanted[candidate.body.shape] == 1)
      elements_.push_back(static_cast<std::uint32_t>(points.size()) + candidate.body.shape);
    packing_.add(elements_, candidate.body.score);
  }
  packing_.solve(chosen_, counters.packing);
}

void BodyFinder::hand_over(std::span<const std::uint32_t> wanted, std::vector<FoundBody>& found,
                           FinderCounters& counters) {
  std::sort(chosen_.begin(), chosen_.end(), [this](std::uint32_t a, std::uint32_t b) {
    const double sa = candidates_[a].body.score, sb = candidates_[b].body.score;
    return sa != sb ? sa > sb : a < b;
  });
  left_.assign(wanted.begin(), wanted.end());
  for (const std::uint32_t number : chosen_) {
    FoundBody body = candidates_[number].body;
    if (body.shape >= real_) {
      ++counters.mirrored;
      continue;
    }
    if (left_[body.shape] == 0) continue;
    --left_[body.shape];
    for (std::uint32_t other = 0; other < candidates_.size(); ++other) {
      const FoundBody& rival = candidates_[other].body;
      if (other == number || rival.shape >= real_ || !(rival.score > body.runner_up)) continue;
      // Of the same labelling but with fewer points it is no rival.
      bool shares = false, differs = rival.shape != body.shape;
      for (std::size_t m = 0; m < shapes_[rival.shape].markers_in_shape.size(); ++m) {
        const std::uint32_t point = rival.point_of_marker[m];
        if (point == kMarkerNotSeen) continue;
        const auto end = body.point_of_marker.begin() +
                         static_cast<std::ptrdiff_t>(shapes_[body.shape].markers_in_shape.size());
        const bool shared = std::find(body.point_of_marker.begin(), end, point) != end;
        shares = shares || shared;
        differs = differs || (shared && body.point_of_marker[m] != point);
      }
      if (!shares || !differs) continue;
      body.runner_up = rival.score;
      body.relabelled = rival.shape == body.shape;
    }
    found.push_back(body);
  }
}

}  // namespace glint
