// SPDX-License-Identifier: MIT
// Tracked points as text.
#include "host/output/track_sink.hpp"

#include <bit>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <string_view>
#include <vector>

#include "host/output/body_sink.hpp"

namespace glint {

namespace {

constexpr int kMetreDecimals = 7;  // 0.1 um, a hundredth of the best rig's noise
constexpr int kSdDecimals = 8;     // two figures of what the best rig comes to
constexpr int kPixelDecimals = 4;

std::int64_t nanoseconds(Timestamp time) noexcept {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(time.time_since_epoch()).count();
}

void write_cameras(RecordFile& file, std::uint32_t bits, std::string_view separator) noexcept {
  for (bool first = true; bits != 0; bits &= bits - 1, first = false) {
    if (!first) file.text(separator);
    file.unsigned_integer(static_cast<std::uint64_t>(std::countr_zero(bits)) + 1);
  }
}

bool aligned(const TrackRow& row, const TrackedPoint& point) noexcept {
  return (point.cameras & row.unproven.value_or(0)) == 0;
}

std::string_view name_of(SampleKind kind) noexcept {
  switch (kind) {
    case SampleKind::SingleView:
      return "single-view";
    case SampleKind::Predicted:
      return "predicted";
    case SampleKind::Measured:
      break;
  }
  return "measured";
}

std::string_view name_of(IdentityEvent::Kind kind) noexcept {
  switch (kind) {
    case IdentityEvent::Kind::Kept:
      return "kept";
    case IdentityEvent::Kind::Swapped:
      return "swapped";
    case IdentityEvent::Kind::Unresolved:
      return "unresolved";
    case IdentityEvent::Kind::Ambiguous:
      break;
  }
  return "ambiguous";
}

/// Per axis: with it in all three directions the mean squared error is what the covariance says.
double sd_m(const TrackedPoint& point) noexcept { return std::sqrt(point.covariance_m2.trace() / 3.0); }

void write_id_or_null(RecordFile& file, TrackId id) noexcept {
  if (id == TrackId{}) {
    file.text("null");
  } else {
    file.unsigned_integer(number(id));
  }
}

void write_identity(RecordFile& file, std::span<const IdentityEvent> events) noexcept {
  bool first = true;
  for (const IdentityEvent& event : events) {
    file.text(first ? ",\"identity\":[{\"kind\":\"" : ",{\"kind\":\"").text(name_of(event.kind));
    file.text("\",\"a\":").unsigned_integer(number(event.a));
    file.text(",\"b\":").unsigned_integer(number(event.b));
    if (event.kind == IdentityEvent::Kind::Unresolved) {
      file.text(",\"new_a\":");
      write_id_or_null(file, event.new_a);
      file.text(",\"new_b\":");
      write_id_or_null(file, event.new_b);
    }
    file.text("}");
    first = false;
  }
  if (!first) file.text("]");
}

class FileTrackSink : public TrackSink {
 public:
  FileTrackSink(const OutputSpec& spec, std::string_view header) : file_(spec.path, spec.force, header) {}
  SinkStatus flush() noexcept override { return file_.flush(); }
  SinkStatus finish() noexcept override { return file_.finish(); }
  SinkCounters counters() const noexcept override { return file_.counters(); }
  const std::string& problem() const noexcept override { return file_.problem(); }

 protected:
  RecordFile file_;
};

class CsvTrackSink final : public FileTrackSink {
 public:
  explicit CsvTrackSink(const OutputSpec& spec)
      : FileTrackSink(spec,
                      "tick,time_ns,id,x_m,y_m,z_m,residual_px,cameras,aligned,kind,age,ambiguous,sd_m\n") {}

  SinkStatus write(const TrackRow& row) noexcept override {
    const std::int64_t time_ns = nanoseconds(row.exposed);
    for (const TrackedPoint& point : row.points) {
      file_.unsigned_integer(number(row.trigger)).text(",").integer(time_ns).text(",");
      file_.unsigned_integer(number(point.id)).text(",");
      for (int axis = 0; axis < 3; ++axis) {
        file_.number(point.position_in_world[axis], kMetreDecimals, "nan").text(",");
      }
      file_.number(point.residual_px, kPixelDecimals, "nan").text(",");
      write_cameras(file_, point.cameras, "+");
      file_.text(row.unproven ? (aligned(row, point) ? ",1," : ",0,") : ",,");
      file_.text(name_of(point.kind)).text(",").unsigned_integer(point.age_frames).text(",");
      if (point.ambiguous_with != TrackId{}) file_.unsigned_integer(number(point.ambiguous_with));
      file_.text(",").number(sd_m(point), kSdDecimals, "nan");
      file_.end_row();
    }
    return file_.end_group();
  }
};

class JsonlTrackSink final : public FileTrackSink {
 public:
  JsonlTrackSink(const OutputSpec& spec, std::span<const BodyModel> bodies) : FileTrackSink(spec, {}) {
    for (const BodyModel& body : bodies) body_names_.push_back(quote_json(body.name));
  }

  SinkStatus write(const TrackRow& row) noexcept override {
    file_.text("{\"tick\":").unsigned_integer(number(row.trigger));
    file_.text(",\"time_ns\":").integer(nanoseconds(row.exposed));
    if (row.exposed_error_s) file_.text(",\"time_error_ns\":").number(*row.exposed_error_s * 1e9, 0, "null");
    if (row.stamped) file_.text(",\"stamped_ns\":").integer(nanoseconds(*row.stamped));
    file_.text(",\"cameras\":[");
    write_cameras(file_, row.frames, ",");
    file_.text(row.dark ? "],\"dark\":true" : "]");
    write_identity(file_, row.identity);
    file_.text(",\"points\":[");
    bool first = true;
    for (const TrackedPoint& point : row.points) {
      file_.text(first ? "{\"id\":" : ",{\"id\":").unsigned_integer(number(point.id));
      file_.text(",\"x_m\":").number(point.position_in_world.x(), kMetreDecimals, "null");
      file_.text(",\"y_m\":").number(point.position_in_world.y(), kMetreDecimals, "null");
      file_.text(",\"z_m\":").number(point.position_in_world.z(), kMetreDecimals, "null");
      file_.text(",\"residual_px\":").number(point.residual_px, kPixelDecimals, "null");
      file_.text(",\"cameras\":[");
      write_cameras(file_, point.cameras, ",");
      file_.text("],\"aligned\":");
      file_.text(row.unproven ? (aligned(row, point) ? "true" : "false") : "null");
      file_.text(",\"kind\":\"").text(name_of(point.kind));
      file_.text("\",\"age\":").unsigned_integer(point.age_frames).text(",\"ambiguous\":");
      write_id_or_null(file_, point.ambiguous_with);
      file_.text(",\"sd_m\":").number(sd_m(point), kSdDecimals, "null").text("}");
      first = false;
    }
    file_.text("]");
    if (!body_names_.empty()) {
      file_.text(",\"bodies\":");
      write_bodies_json(file_, row.bodies, body_names_);
    }
    file_.text("}");
    file_.end_row();
    return file_.end_group();
  }

 private:
  std::vector<std::string> body_names_;  // as JSON
};

class NoTrackSink final : public TrackSink {
 public:
  SinkStatus write(const TrackRow&) noexcept override { return SinkStatus::Ok; }
  SinkStatus flush() noexcept override { return SinkStatus::Ok; }
  SinkStatus finish() noexcept override { return SinkStatus::Ok; }
  SinkCounters counters() const noexcept override { return {}; }
  const std::string& problem() const noexcept override { return problem_; }

 private:
  std::string problem_;
};

}  // namespace

std::unique_ptr<TrackSink> make_track_sink(const OutputSpec& spec, std::span<const BodyModel> bodies) {
  switch (spec.kind) {
    case OutputKind::Csv:
      return std::make_unique<CsvTrackSink>(spec);
    case OutputKind::Jsonl:
      return std::make_unique<JsonlTrackSink>(spec, bodies);
    case OutputKind::None:
      break;
  }
  return std::make_unique<NoTrackSink>();
}

}  // namespace glint
