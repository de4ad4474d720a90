// SPDX-License-Identifier: MIT
// One assignment over all bodies.
#include "host/body/acquisition.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

namespace glint {
namespace {

constexpr double kReachChi2 = 16.3;  // three degrees of freedom, once in 1,000: a marker can wait a frame
// Samples of nobody per cubic metre, among which a body's own must stand out. Only its logarithm counts.
constexpr double kOtherDensity = 1.0;
constexpr double kContestedLogOdds = 3.0;  // 20 : 1; a marker that waits costs little, a wrong one much

double marker_sd(const ShapedBody& shaped, const BodyState& body, std::size_t marker) noexcept {
  return std::sqrt(
      point_covariance(body.pose(), body.covariance(), shaped.markers_in_shape[marker], shaped.marker_sd_m)
          .trace());
}

}  // namespace

bool sharp(const ShapedBody& shaped, const BodyState& body) noexcept {
  double gap2 = 1e9, worst_sd = 0.0;
  const auto& markers = shaped.markers_in_shape;
  for (std::size_t i = 0; i < markers.size(); ++i) {
    worst_sd = std::max(worst_sd, marker_sd(shaped, body, i));
    for (std::size_t j = i + 1; j < markers.size(); ++j)
      gap2 = std::min(gap2, (markers[i] - markers[j]).squaredNorm());
  }
  return 2.5 * worst_sd < 0.5 * std::sqrt(gap2);
}

void Acquisition::run(std::span<const ShapedBody> shaped, std::span<BodyState> bodies, SampleIndex& index,
                      std::vector<std::uint8_t>& changed, BodyCounters& counters) {
  rows_.clear();
  edges_.clear();
  changed.assign(bodies.size(), 0);
  for (std::uint32_t b = 0; b < bodies.size(); ++b) {
    const BodyState& body = bodies[b];
    if (body.life == BodyLife::Lost || !sharp(shaped[b], body)) continue;
    const Matrix6 covariance = body.covariance();
    for (std::uint32_t m = 0; m < shaped[b].markers_in_shape.size(); ++m) {
      if (body.sample[m] != kNoSample) continue;
      const Eigen::Vector3d at = body.pose() * shaped[b].markers_in_shape[m];
      const Eigen::Matrix3d own =
          point_covariance(body.pose(), covariance, shaped[b].markers_in_shape[m], shaped[b].marker_sd_m);
      const auto row = static_cast<std::uint32_t>(rows_.size());
      rows_.push_back({b, m});
      const double reach = 1.5 * std::sqrt(kReachChi2 * own.trace()) + 0.005;
      index.near(at, reach, [&](std::uint32_t k) {
        const MarkerSample& sample = index.samples()[k];
        const Eigen::Matrix3d spread = own + sample.covariance_m2;
        const Eigen::Vector3d r = sample.position_in_world - at;
        const double chi2 = r.dot(spread.inverse() * r);
        if (!(chi2 <= kReachChi2)) return;
        const double gain = -0.5 * chi2 - 0.5 * std::log(spread.determinant()) - 1.5 * std::log(2.0 * M_PI) -
                            std::log(kOtherDensity);
        if (gain > 0.0) edges_.push_back({row, k, gain});
      });
    }
  }
  if (edges_.empty()) return;
  drop_contested(counters);
  assignment_.solve(rows_.size(), index.samples().size(), edges_, column_of_row_);
  for (std::size_t row = 0; row < rows_.size(); ++row) {
    if (column_of_row_[row] == kUnassigned) continue;
    const auto [b, m] = rows_[row];
    BodyState& body = bodies[b];
    if (!body.fitted) {
      const auto of_body =
          static_cast<std::size_t>(std::count_if(rows_.begin(), rows_.end(), [&](const Row& other) {
            return other.body == b &&
                   column_of_row_[static_cast<std::size_t>(&other - rows_.data())] != kUnassigned;
          }));
      if (of_body < 2) continue;
    }
    body.sample[m] = column_of_row_[row];
    body.track[m] = index.samples()[body.sample[m]].track;
    index.use(body.sample[m], true);
    changed[b] = 1;
    ++counters.acquired;
  }
}

void Acquisition::drop_contested(BodyCounters& counters) {
  order_.resize(edges_.size());
  for (std::uint32_t k = 0; k < order_.size(); ++k) order_[k] = k;
  std::sort(order_.begin(), order_.end(), [this](std::uint32_t a, std::uint32_t b) {
    if (edges_[a].column != edges_[b].column) return edges_[a].column < edges_[b].column;
    return edges_[a].gain != edges_[b].gain ? edges_[a].gain > edges_[b].gain : a < b;
  });
  for (std::size_t begin = 0; begin < order_.size();) {
    std::size_t end = begin + 1;
    while (end < order_.size() && edges_[order_[end]].column == edges_[order_[begin]].column) ++end;
    if (end > begin + 1 && edges_[order_[begin]].gain - edges_[order_[begin + 1]].gain < kContestedLogOdds) {
      for (std::size_t k = begin; k < end; ++k) edges_[order_[k]].gain = 0.0;
      ++counters.contested;
    }
    begin = end;
  }
}

}  // namespace glint
