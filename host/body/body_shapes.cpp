// SPDX-License-Identifier: MIT
// Each body is compared with the first of every shape.
#include "host/body/body_shapes.hpp"

#include <algorithm>
#include <numeric>

namespace glint {
namespace {

bool all_agree(const Agreement& agreement, std::size_t a, std::size_t b) {
  return agreement.markers.size() == a && a == b;
}

}  // namespace

BodyShapes sort_into_shapes(std::span<const BodyModel> models, double tolerance_m) {
  BodyShapes shapes;
  for (std::uint32_t k = 0; k < models.size(); ++k) {
    const auto& own = models[k].markers_in_body;
    ShapedBody body;
    body.marker_sd_m = models[k].marker_sd_m;
    body.shape = static_cast<std::uint32_t>(shapes.members.size());
    body.own_marker.resize(own.size());
    std::iota(body.own_marker.begin(), body.own_marker.end(), 0u);
    for (std::uint32_t s = 0; s < shapes.members.size(); ++s) {
      const auto& first = models[shapes.members[s].front()].markers_in_body;
      if (first.size() != own.size()) continue;
      const auto found = find_agreements(first, own, tolerance_m);
      if (found.empty() || !all_agree(found.front(), first.size(), own.size())) continue;
      body.shape = s;
      body.shape_from_body = found.front().a_from_b;
      for (const auto& [in_shape, in_body] : found.front().markers) body.own_marker[in_shape] = in_body;
      break;
    }
    for (const std::uint32_t marker : body.own_marker)
      body.markers_in_shape.push_back(body.shape_from_body * own[marker]);
    if (body.shape == shapes.members.size()) {
      shapes.members.emplace_back();
      const auto turned = find_agreements(own, own, tolerance_m);
      shapes.symmetric.push_back(std::count_if(turned.begin(), turned.end(), [&](const Agreement& a) {
                                   return all_agree(a, own.size(), own.size());
                                 }) > 1);
    }
    shapes.members[body.shape].push_back(k);
    shapes.bodies.push_back(std::move(body));
  }
  return shapes;
}

}  // namespace glint
