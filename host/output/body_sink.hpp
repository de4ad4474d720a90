// SPDX-License-Identifier: MIT
// Poses of rigid bodies as text: a CSV file of their own, and their part of a line of JSON.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "host/base/ids.hpp"
#include "host/body/body_tracker.hpp"
#include "host/output/record_file.hpp"

namespace glint {

/// Standard deviation per axis, root mean square over the three: of the origin, and of the orientation.
double place_sd_m(const TrackedBody& body) noexcept;
double turn_sd_rad(const TrackedBody& body) noexcept;

/// CSV, one row a body: `tick,time_ns,body,x_m,y_m,z_m,qx,qy,qz,qw,kind,age,markers,ambiguous,sd_m,sd_rad`.
/// body is a name, quoted where it needs that; position and unit quaternion take points of the body into the
/// world, qw >= 0; kind is measured or predicted; age counts frames since it was measured; ambiguous is the
/// name of the body that it may be instead (its own: only its orientation is in doubt), or empty.
/// Thread-bound. Writing allocates nothing once warm.
class BodySink {
 public:
  /// "-" is standard output. Throws Error when the file cannot be written.
  BodySink(const std::string& path, bool force, std::span<const BodyModel> models);

  [[nodiscard]] SinkStatus write(TriggerNo trigger, Timestamp exposed,
                                 std::span<const TrackedBody> bodies) noexcept;
  [[nodiscard]] SinkStatus flush() noexcept { return file_.flush(); }
  [[nodiscard]] SinkStatus finish() noexcept { return file_.finish(); }
  const std::string& problem() const noexcept { return file_.problem(); }

 private:
  RecordFile file_;
  std::vector<std::string> names_;  // as CSV
};

/// `[{"name":...,"x_m":...},...]`: name, x_m, y_m, z_m, qx, qy, qz, qw, kind, age, markers, rms_px (null: no
/// view), ambiguous (null: no doubt), sd_m, sd_rad. `names` as quote_json() made them, by body.
void write_bodies_json(RecordFile& file, std::span<const TrackedBody> bodies,
                       std::span<const std::string> names) noexcept;

/// `text` in quotes, as JSON has it.
std::string quote_json(const std::string& text);

}  // namespace glint
