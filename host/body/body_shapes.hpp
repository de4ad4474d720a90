// SPDX-License-Identifier: MIT
// Bodies of equal shape, brought to one frame and one numbering, so that one can stand for the other.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "host/body/body_model.hpp"
#include "host/body/confusions.hpp"

namespace glint {

/// A body as its shape sees it. The shape's frame and numbering are those of its first body.
struct ShapedBody {
  std::uint32_t shape = 0;
  std::vector<std::uint32_t> own_marker;          ///< the body's number of the shape's k-th marker
  std::vector<Eigen::Vector3d> markers_in_shape;  ///< the body's own measures, in the shape's frame and order
  Pose shape_from_body;
  double marker_sd_m = 0.0;
};

struct BodyShapes {
  std::vector<ShapedBody> bodies;                   ///< one per model, in their order
  std::vector<std::vector<std::uint32_t>> members;  ///< of each shape, ascending
  std::vector<bool> symmetric;                      ///< of each shape: it looks like itself when turned
};

/// Bodies whose markers all agree within `tolerance_m`, not mirrored, are of one shape.
BodyShapes sort_into_shapes(std::span<const BodyModel> models, double tolerance_m = kConfusionTolerance_m);

}  // namespace glint
