// SPDX-License-Identifier: MIT
// Where detected blobs go: CSV, JSON lines, or nowhere.
#pragma once

#include <memory>
#include <span>
#include <string>

#include "host/base/ids.hpp"
#include "host/geometry/camera.hpp"
#include "host/output/output_spec.hpp"
#include "host/output/record_file.hpp"
#include "shaders/interface/blob_record.h"

namespace glint {

/// The blobs of one camera at one tick; only borrowed.
struct BlobRow {
  TriggerNo trigger{};
  CameraId camera{};
  std::span<const shaders::BlobRecord> blobs;
  bool overflow = false;  ///< the camera had more blobs than there was room for
};

/// Thread-bound. Writing allocates nothing once warm. May block on a slow pipe.
class BlobSink {
 public:
  virtual ~BlobSink() = default;
  [[nodiscard]] virtual SinkStatus write(const BlobRow& row) noexcept = 0;
  [[nodiscard]] virtual SinkStatus flush() noexcept = 0;
  [[nodiscard]] virtual SinkStatus finish() noexcept = 0;
  virtual SinkCounters counters() const noexcept = 0;
  virtual const std::string& problem() const noexcept = 0;
};

/// CSV: one row a blob, `tick,camera,x_px,y_px,x_undist_px,y_undist_px,area_px,sum,peak,overflow`; cameras
/// are numbered from 1. JSON lines: one object a tick and camera, also without blobs. The undistorted
/// pixel is that of a pinhole with the camera's focal lengths and centre: `cameras` gives them, in rig
/// order, and a default CameraCalibration (no lens known) repeats the raw pixel. Throws Error when the
/// file cannot be written.
std::unique_ptr<BlobSink> make_blob_sink(const OutputSpec& spec, std::span<const CameraCalibration> cameras);

}  // namespace glint
