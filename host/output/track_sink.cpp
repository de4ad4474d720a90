// SPDX-License-Identifier: MIT
// Tracked points as text.
#include "host/output/track_sink.hpp"

#include <bit>
#include <chrono>
#include <cstdint>
#include <string_view>

namespace glint {

namespace {

constexpr int kMetreDecimals = 7;  // 0.1 um, a hundredth of the best rig's noise
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
      : FileTrackSink(spec, "tick,time_ns,id,x_m,y_m,z_m,residual_px,cameras,aligned\n") {}

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
      file_.text(row.unproven ? (aligned(row, point) ? ",1" : ",0") : ",");
      file_.end_row();
    }
    return file_.end_group();
  }
};

class JsonlTrackSink final : public FileTrackSink {
 public:
  explicit JsonlTrackSink(const OutputSpec& spec) : FileTrackSink(spec, {}) {}

  SinkStatus write(const TrackRow& row) noexcept override {
    file_.text("{\"tick\":").unsigned_integer(number(row.trigger));
    file_.text(",\"time_ns\":").integer(nanoseconds(row.exposed));
    if (row.exposed_error_s) file_.text(",\"time_error_ns\":").number(*row.exposed_error_s * 1e9, 0, "null");
    if (row.stamped) file_.text(",\"stamped_ns\":").integer(nanoseconds(*row.stamped));
    file_.text(",\"cameras\":[");
    write_cameras(file_, row.frames, ",");
    file_.text(row.dark ? "],\"dark\":true,\"points\":[" : "],\"points\":[");
    bool first = true;
    for (const TrackedPoint& point : row.points) {
      file_.text(first ? "{\"id\":" : ",{\"id\":").unsigned_integer(number(point.id));
      file_.text(",\"x_m\":").number(point.position_in_world.x(), kMetreDecimals, "null");
      file_.text(",\"y_m\":").number(point.position_in_world.y(), kMetreDecimals, "null");
      file_.text(",\"z_m\":").number(point.position_in_world.z(), kMetreDecimals, "null");
      file_.text(",\"residual_px\":").number(point.residual_px, kPixelDecimals, "null");
      file_.text(",\"cameras\":[");
      write_cameras(file_, point.cameras, ",");
      file_.text(row.unproven ? (aligned(row, point) ? "],\"aligned\":true}" : "],\"aligned\":false}")
                              : "],\"aligned\":null}");
      first = false;
    }
    file_.text("]}");
    file_.end_row();
    return file_.end_group();
  }
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

std::unique_ptr<TrackSink> make_track_sink(const OutputSpec& spec) {
  switch (spec.kind) {
    case OutputKind::Csv:
      return std::make_unique<CsvTrackSink>(spec);
    case OutputKind::Jsonl:
      return std::make_unique<JsonlTrackSink>(spec);
    case OutputKind::None:
      break;
  }
  return std::make_unique<NoTrackSink>();
}

}  // namespace glint
