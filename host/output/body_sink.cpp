// SPDX-License-Identifier: MIT
// Rows and objects of bodies.
#include "host/output/body_sink.hpp"

#include <chrono>
#include <cmath>
#include <cstdio>

namespace glint {
namespace {

constexpr int kMetreDecimals = 7, kTurnDecimals = 8, kSdDecimals = 8, kPixelDecimals = 4;

const char* name_of(BodyKind kind) noexcept { return kind == BodyKind::Measured ? "measured" : "predicted"; }

/// Of the two quaternions of one orientation the one with w >= 0.
Eigen::Quaterniond upper(const Eigen::Quaterniond& q) noexcept {
  return q.w() < 0.0 ? Eigen::Quaterniond(-q.coeffs()) : q;
}

std::string quote_csv(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

}  // namespace

double place_sd_m(const TrackedBody& body) noexcept {
  return std::sqrt(body.covariance.bottomRightCorner<3, 3>().trace() / 3.0);
}

double turn_sd_rad(const TrackedBody& body) noexcept {
  return std::sqrt(body.covariance.topLeftCorner<3, 3>().trace() / 3.0);
}

std::string quote_json(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') {
      quoted += '\\';
      quoted += c;
    } else if (static_cast<unsigned char>(c) < 0x20) {
      char code[8];
      std::snprintf(code, sizeof code, "\\u%04x", static_cast<unsigned>(c));
      quoted += code;
    } else {
      quoted += c;
    }
  }
  return quoted + "\"";
}

BodySink::BodySink(const std::string& path, bool force, std::span<const BodyModel> models)
    : file_(path, force,
            "tick,time_ns,body,x_m,y_m,z_m,qx,qy,qz,qw,kind,age,markers,ambiguous,sd_m,sd_rad\n") {
  for (const BodyModel& model : models) names_.push_back(quote_csv(model.name));
}

SinkStatus BodySink::write(TriggerNo trigger, Timestamp exposed,
                           std::span<const TrackedBody> bodies) noexcept {
  const std::int64_t time_ns =
      std::chrono::duration_cast<std::chrono::nanoseconds>(exposed.time_since_epoch()).count();
  for (const TrackedBody& body : bodies) {
    file_.unsigned_integer(number(trigger)).text(",").integer(time_ns).text(",").text(names_[body.body]);
    for (int axis = 0; axis < 3; ++axis)
      file_.text(",").number(body.world_from_body.translation[axis], kMetreDecimals, "nan");
    const Eigen::Quaterniond turn = upper(body.world_from_body.rotation);
    for (const double part : {turn.x(), turn.y(), turn.z(), turn.w()})
      file_.text(",").number(part, kTurnDecimals, "nan");
    file_.text(",").text(name_of(body.kind)).text(",").unsigned_integer(body.age_frames);
    file_.text(",").unsigned_integer(body.markers).text(",");
    if (body.ambiguous) file_.text(names_[body.ambiguous_with]);
    file_.text(",").number(place_sd_m(body), kSdDecimals, "nan");
    file_.text(",").number(turn_sd_rad(body), kSdDecimals, "nan");
    file_.end_row();
  }
  return file_.end_group();
}

void write_bodies_json(RecordFile& file, std::span<const TrackedBody> bodies,
                       std::span<const std::string> names) noexcept {
  bool first = true;
  file.text("[");
  for (const TrackedBody& body : bodies) {
    const Eigen::Vector3d& at = body.world_from_body.translation;
    const Eigen::Quaterniond turn = upper(body.world_from_body.rotation);
    file.text(first ? "{\"name\":" : ",{\"name\":").text(names[body.body]);
    file.text(",\"x_m\":").number(at.x(), kMetreDecimals, "null");
    file.text(",\"y_m\":").number(at.y(), kMetreDecimals, "null");
    file.text(",\"z_m\":").number(at.z(), kMetreDecimals, "null");
    file.text(",\"qx\":").number(turn.x(), kTurnDecimals, "null");
    file.text(",\"qy\":").number(turn.y(), kTurnDecimals, "null");
    file.text(",\"qz\":").number(turn.z(), kTurnDecimals, "null");
    file.text(",\"qw\":").number(turn.w(), kTurnDecimals, "null");
    file.text(",\"kind\":\"").text(name_of(body.kind));
    file.text("\",\"age\":").unsigned_integer(body.age_frames);
    file.text(",\"markers\":").unsigned_integer(body.markers);
    file.text(",\"rms_px\":");
    if (body.views > 0) {
      file.number(body.rms_px, kPixelDecimals, "null");
    } else {
      file.text("null");
    }
    file.text(",\"ambiguous\":").text(body.ambiguous ? std::string_view(names[body.ambiguous_with]) : "null");
    file.text(",\"sd_m\":").number(place_sd_m(body), kSdDecimals, "null");
    file.text(",\"sd_rad\":").number(turn_sd_rad(body), kSdDecimals, "null").text("}");
    first = false;
  }
  file.text("]");
}

}  // namespace glint
