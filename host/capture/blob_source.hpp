// SPDX-License-Identifier: MIT
// Blob sets from CSV files: other tools' 2D points, straight to correspondence.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "host/frames/source.hpp"

namespace glint {

struct BlobSourceOptions {
  std::vector<std::string>
      camera_names;      ///< wanted order, normally the rig's; empty: all found, natural order
  double rate_hz = 0.0;  ///< ticks per second, for BlobSet::exposed; 0: 30 Hz is assumed
  void check(std::vector<std::string>& problems) const;  ///< appends "source.rate_hz must be >= 0", ...
};

/// Opens a folder with one CSV per camera; the file's stem is the camera's name. Columns
/// `tick,x_px,y_px[,area_px][,sum]`, one blob a line, raw (distorted) pixels, ticks not descending. Without a
/// header line the columns are in this order; a header may order them otherwise and leave out area_px or sum.
/// Unknown area and sum are 0. Empty lines and lines that begin with # are passed over.
///
/// Files are read as they are needed. A tick without a line in one camera gives an empty list there; a tick
/// that no file has is not delivered. BlobSet::trigger is the tick, exposed is tick / rate. Throws Error if
/// the folder, a camera's file or its first line is wrong; later faults make read() Failed with
/// file:line:column in problem().
std::unique_ptr<BlobSource> open_blob_source(const std::string& folder, const BlobSourceOptions& options);

}  // namespace glint
