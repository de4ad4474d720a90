// SPDX-License-Identifier: MIT
// Triples of markers with equal sides, extended to all markers that agree with them.
#include "host/body/confusions.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <optional>

#include "host/body/point_pose.hpp"
#include "host/geometry/rotation.hpp"

namespace glint {
namespace {

using Points = std::span<const Eigen::Vector3d>;
using Pairs = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

// One-to-one by distance, nearest first.
Pairs pairs_within(Points a, Points b, const Pose& a_from_b, double reach_m) {
  struct Near {
    double distance_m;
    std::uint32_t a, b;
  };
  std::vector<Near> near;
  for (std::uint32_t j = 0; j < b.size(); ++j) {
    const Eigen::Vector3d p = a_from_b * b[j];
    for (std::uint32_t i = 0; i < a.size(); ++i)
      if (const double d = (a[i] - p).norm(); d <= reach_m) near.push_back({d, i, j});
  }
  std::sort(near.begin(), near.end(),
            [](const Near& x, const Near& y) { return x.distance_m < y.distance_m; });
  std::vector<bool> a_taken(a.size()), b_taken(b.size());
  Pairs pairs;
  for (const Near& n : near) {
    if (a_taken[n.a] || b_taken[n.b]) continue;
    a_taken[n.a] = b_taken[n.b] = true;
    pairs.emplace_back(n.a, n.b);
  }
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

// The pose that fits these pairs best; the worst pair is dropped until all agree.
std::optional<Agreement> settle(Points a, Points b, Pairs pairs, double tolerance_m) {
  while (pairs.size() >= 3) {
    std::vector<Eigen::Vector3d> in_a, in_b;
    for (const auto& [i, j] : pairs) {
      in_a.push_back(a[i]);
      in_b.push_back(b[j]);
    }
    const auto pose = pose_from_points(in_b, in_a);
    if (!pose) return std::nullopt;
    std::size_t worst = 0;
    double difference_m = 0.0;
    for (std::size_t k = 0; k < pairs.size(); ++k)
      if (const double d = (in_a[k] - *pose * in_b[k]).norm(); d > difference_m) {
        difference_m = d;
        worst = k;
      }
    if (difference_m <= tolerance_m) return Agreement{std::move(pairs), *pose, difference_m};
    pairs.erase(pairs.begin() + static_cast<std::ptrdiff_t>(worst));
  }
  return std::nullopt;
}

bool holds(const Pairs& larger, const Pairs& smaller) {
  return std::includes(larger.begin(), larger.end(), smaller.begin(), smaller.end());
}

void keep(std::vector<Agreement>& found, Agreement agreement) {
  for (const Agreement& other : found)
    if (holds(other.markers, agreement.markers)) return;
  std::erase_if(found, [&](const Agreement& other) { return holds(agreement.markers, other.markers); });
  found.push_back(std::move(agreement));
}

Pairs inverse_of(const Pairs& pairs) {
  Pairs inverse;
  for (const auto& [i, j] : pairs) inverse.emplace_back(j, i);
  std::sort(inverse.begin(), inverse.end());
  return inverse;
}

}  // namespace

std::vector<Agreement> find_agreements(Points a, Points b, double tolerance_m) {
  const double slack_m = 2.0 * tolerance_m;  // a distance differs by what both of its ends do
  const auto agree = [&](std::uint32_t i, std::uint32_t k, std::uint32_t j, std::uint32_t l) {
    return std::abs((a[i] - a[k]).norm() - (b[j] - b[l]).norm()) <= slack_m;
  };
  const auto n = static_cast<std::uint32_t>(a.size()), m = static_cast<std::uint32_t>(b.size());
  std::vector<Agreement> found;
  const auto extend = [&](const std::array<std::uint32_t, 3>& i, const std::array<std::uint32_t, 3>& j) {
    const auto start = pose_from_triple({b[j[0]], b[j[1]], b[j[2]]}, {a[i[0]], a[i[1]], a[i[2]]});
    if (!start) return;
    Pairs pairs{{i[0], j[0]}, {i[1], j[1]}, {i[2], j[2]}};
    // A pose from three markers carries farther ones off; twice settled, it is the pose of all that agree.
    auto agreement = settle(a, b, pairs_within(a, b, *start, 2.0 * slack_m), tolerance_m);
    if (agreement) {
      auto more = settle(a, b, pairs_within(a, b, agreement->a_from_b, slack_m), tolerance_m);
      if (more && more->markers.size() > agreement->markers.size()) agreement = std::move(more);
    }
    if (!agreement) agreement = settle(a, b, std::move(pairs), tolerance_m);
    if (agreement) keep(found, std::move(*agreement));
  };
  const auto known = [&](std::uint32_t i0, std::uint32_t j0, std::uint32_t i1, std::uint32_t j1,
                         std::uint32_t i2, std::uint32_t j2) {
    Pairs pairs{{i0, j0}, {i1, j1}, {i2, j2}};
    return std::any_of(found.begin(), found.end(),
                       [&](const Agreement& other) { return holds(other.markers, pairs); });
  };
  for (std::uint32_t i0 = 0; i0 < n; ++i0)
    for (std::uint32_t i1 = i0 + 1; i1 < n; ++i1)
      for (std::uint32_t j0 = 0; j0 < m; ++j0)
        for (std::uint32_t j1 = 0; j1 < m; ++j1) {
          if (j1 == j0 || !agree(i0, i1, j0, j1)) continue;
          for (std::uint32_t i2 = i1 + 1; i2 < n; ++i2)
            for (std::uint32_t j2 = 0; j2 < m; ++j2) {
              if (j2 == j0 || j2 == j1 || !agree(i0, i2, j0, j2) || !agree(i1, i2, j1, j2)) continue;
              if (!known(i0, j0, i1, j1, i2, j2)) extend({i0, i1, i2}, {j0, j1, j2});
            }
        }
  std::sort(found.begin(), found.end(), [](const Agreement& x, const Agreement& y) {
    if (x.markers.size() != y.markers.size()) return x.markers.size() > y.markers.size();
    return x.difference_m != y.difference_m ? x.difference_m < y.difference_m : x.markers < y.markers;
  });
  return found;
}

std::vector<Confusion> find_confusions(std::span<const BodyModel> models, double tolerance_m) {
  std::vector<Confusion> confusions;
  for (std::uint32_t i = 0; i < models.size(); ++i)
    for (std::uint32_t j = i; j < models.size(); ++j) {
      const Points a = models[i].markers_in_body, b = models[j].markers_in_body;
      std::vector<Pairs> told;
      for (Agreement& agreement : find_agreements(a, b, tolerance_m)) {
        const Pairs& pairs = agreement.markers;
        if (i == j) {
          if (std::all_of(pairs.begin(), pairs.end(), [](const auto& p) { return p.first == p.second; }))
            continue;
          if (std::find(told.begin(), told.end(), inverse_of(pairs)) != told.end()) continue;
          told.push_back(pairs);
        }
        Confusion confusion;
        confusion.body = i;
        confusion.other = j;
        confusion.turn_rad = rotation_vector_of(agreement.a_from_b.rotation).norm();
        confusion.whole = pairs.size() == a.size() && pairs.size() == b.size();
        confusion.nearly = !confusion.whole && pairs.size() + 1 >= std::min(a.size(), b.size());
        confusion.agreement = std::move(agreement);
        confusions.push_back(std::move(confusion));
      }
    }
  return confusions;
}

std::string describe(const Confusion& c, std::span<const BodyModel> models) {
  char number[96];
  const BodyModel &a = models[c.body], &b = models[c.other];
  const std::size_t pairs = c.agreement.markers.size();
  const std::string count = std::to_string(pairs) + " of " +
                            std::to_string(std::min(a.markers_in_body.size(), b.markers_in_body.size())) +
                            " markers";
  std::string text;
  if (c.body == c.other) {
    std::snprintf(number, sizeof number, "turned by %.0f degrees", c.turn_rad * 180.0 / M_PI);
    text = "\"" + a.name + "\" " + number +
           (c.whole ? " looks like itself" : " can be taken for itself by " + count);
  } else if (c.whole) {
    text = "\"" + a.name + "\" and \"" + b.name + "\" are identical";
  } else {
    text = "\"" + a.name + "\" can be taken for \"" + b.name + "\" by " + count;
  }
  std::snprintf(number, sizeof number, ", within %.1f mm: markers ", 1e3 * c.agreement.difference_m);
  text += number;
  for (std::size_t k = 0; k < pairs; ++k)
    text += (k == 0 ? "" : ", ") + std::to_string(c.agreement.markers[k].first + 1) + " as " +
            std::to_string(c.agreement.markers[k].second + 1);
  return text;
}

}  // namespace glint
