// SPDX-License-Identifier: MIT
// Image of one marker over the exposure.
#include "host/sim/marker_painter.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace glint::sim {
namespace {

constexpr double kGreyAt1m = 3375.0;  // for 137 us, before the beads' loss: peaks of 230 at 1.5 m, 70 at 5 m
constexpr double kNominalExposure_s = 137e-6;
constexpr double kRingRadius_m = 0.02;                              // LEDs around the lens
constexpr double kBeadAngle_rad = 0.40 * std::numbers::pi / 180.0;  // return falls to 1/e
constexpr unsigned kHiddenSamples = 400;
static_assert(kHiddenSamples <= Scene::kMostSamples);

struct Node {
  double at, weight;  // over an exposure from -1/2 to +1/2
};

/// Gauss-Legendre quadrature: exact to the fifth power of time with three nodes; longer paths are cut into
/// pieces.
void time_nodes(double path_px, double sigma_px, std::array<Node, 48>& nodes, std::size_t& count) noexcept {
  const double paths = path_px / sigma_px;
  if (paths < 0.03) {
    nodes[0] = {0.0, 1.0};
    count = 1;
    return;
  }
  if (paths < 0.4) {
    const double off = 0.5 / std::numbers::sqrt3;
    nodes[0] = {-off, 0.5};
    nodes[1] = {off, 0.5};
    count = 2;
    return;
  }
  const std::size_t pieces = std::min<std::size_t>(16, static_cast<std::size_t>(std::ceil(paths / 2.0)));
  const double width = 1.0 / static_cast<double>(pieces), off = 0.5 * width * std::sqrt(0.6);
  count = 0;
  for (std::size_t i = 0; i < pieces; ++i) {
    const double middle = -0.5 + (static_cast<double>(i) + 0.5) * width;
    nodes[count++] = {middle - off, width * 5.0 / 18.0};
    nodes[count++] = {middle, width * 8.0 / 18.0};
    nodes[count++] = {middle + off, width * 5.0 / 18.0};
  }
}

}  // namespace

double marker_grey(double distance_m, double exposure_s) noexcept {
  const double observation_rad = std::atan(kRingRadius_m / distance_m);
  return kGreyAt1m / (distance_m * distance_m) * std::exp(-observation_rad / kBeadAngle_rad) *
         (exposure_s / kNominalExposure_s);
}

MarkerPainter::MarkerPainter(const Scene& scene)
    : scene_(scene), kernel_(scene.options().sensor.psf_sigma_px) {
  outline_.resize(512);
}

const Patch* MarkerPainter::paint(std::uint32_t camera, std::uint64_t tick, std::uint32_t marker,
                                  std::span<const MarkerView> views, bool with_gradient) {
  const MarkerView& view = views[marker];
  if (!view.imaged) return nullptr;
  const SimOptions& options = scene_.options();
  // The view's box comes from few outline points: it may be a fiftieth of the radius too small.
  const double margin = kernel_.reach() + 1.0 + 0.03 * view.radius_px;
  const double x_low = std::max(0.0, std::floor(view.x_px - view.half_width_px - margin));
  const double y_low = std::max(0.0, std::floor(view.y_px - view.half_height_px - margin));
  const double x_high = std::min(options.width_px - 1.0, std::ceil(view.x_px + view.half_width_px + margin));
  const double y_high =
      std::min(options.height_px - 1.0, std::ceil(view.y_px + view.half_height_px + margin));
  if (x_low > x_high || y_low > y_high) return nullptr;
  patch_.reset(static_cast<int>(x_low), static_cast<int>(y_low), static_cast<int>(x_high),
               static_cast<int>(y_high), with_gradient);

  const SimCamera& from = scene_.camera(camera, tick);
  const double middle_s = scene_.mid_exposure_s(camera, tick), half_s = 0.5 * options.exposure_s;
  const MarkerState first = scene_.marker(marker, middle_s - half_s),
                    last = scene_.marker(marker, middle_s + half_s);
  // Speed counts, not only displacement: a ball that bounces during the exposure goes there and back.
  const double path_m =
      std::max(first.velocity_in_world.norm(), last.velocity_in_world.norm()) * options.exposure_s;
  const double path_px = path_m / view.distance_m * from.calibration().fx_px;
  std::array<Node, 48> nodes;
  std::size_t count = 0;
  time_nodes(path_px, options.sensor.psf_sigma_px, nodes, count);
  const bool partly_hidden = !with_gradient && scene_.may_be_hidden(camera, tick, marker, views);
  for (std::size_t i = 0; i < count; ++i) {
    add_at(camera, tick, marker, views, middle_s + nodes[i].at * options.exposure_s, nodes[i].weight,
           partly_hidden);
  }
  return &patch_;
}

void MarkerPainter::add_at(std::uint32_t camera, std::uint64_t tick, std::uint32_t marker,
                           std::span<const MarkerView> views, double time_s, double share,
                           bool partly_hidden) {
  const SimOptions& options = scene_.options();
  const SimCamera& from = scene_.camera(camera, tick);
  const Eigen::Vector3d centre = from.in_camera(scene_.marker(marker, time_s).position_in_world);
  if (!from.images(centre, options.marker_radius_m)) return;
  // Spacing of the outline's points below the blur's width: the error then falls as exp(-(2 pi
  // sigma/spacing)^2 / 2).
  const double spacing_px = std::min(1.0, options.sensor.psf_sigma_px);
  const double wanted = 2.0 * std::numbers::pi * (views[marker].radius_px + 0.5) / spacing_px;
  const auto points = static_cast<std::size_t>(std::clamp(std::ceil(wanted), 16.0, 512.0));
  const std::span<OutlinePoint> outline(outline_.data(), points);
  from.outline(centre, options.marker_radius_m, outline);
  const OutlineMoments shape = moments(outline);
  const double grey = share * marker_grey(centre.norm(), options.exposure_s);
  if (!partly_hidden) {
    patch_.add_filled(kernel_, outline, shape.orientation, grey);
    return;
  }
  const double grey_per_point = grey * shape.area_px2 / kHiddenSamples;
  scene_.sample_disc(camera, tick, marker, time_s, views, kHiddenSamples,
                     [&](const Eigen::Vector3d& point, bool is_hidden) {
                       if (is_hidden) return;
                       const Eigen::Vector2d pixel = from.project(point);
                       patch_.add_point(kernel_, pixel.x(), pixel.y(), grey_per_point);
                     });
}

}  // namespace glint::sim
