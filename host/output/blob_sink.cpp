// SPDX-License-Identifier: MIT
// Blobs as text.
#include "host/output/blob_sink.hpp"

#include <string_view>
#include <vector>

#include "host/base/check.hpp"

namespace glint {

namespace {

constexpr int kPixelDecimals = 5;  // 1e-5 px: below the step of a float at 100 px

struct Pinhole {
  double fx_px, fy_px, cx_px, cy_px;
};

class FileBlobSink : public BlobSink {
 public:
  FileBlobSink(const OutputSpec& spec, std::span<const CameraCalibration> cameras, std::string_view header)
      : file_(spec.path, spec.force, header) {
    for (const CameraCalibration& c : cameras) pinholes_.push_back({c.fx_px, c.fy_px, c.cx_px, c.cy_px});
  }
  SinkStatus flush() noexcept override { return file_.flush(); }
  SinkStatus finish() noexcept override { return file_.finish(); }
  SinkCounters counters() const noexcept override { return file_.counters(); }
  const std::string& problem() const noexcept override { return file_.problem(); }

 protected:
  const Pinhole& pinhole(CameraId camera) const noexcept {
    GLINT_CHECK(index(camera) < pinholes_.size());
    return pinholes_[index(camera)];
  }
  static double double_of(float value) noexcept { return static_cast<double>(value); }

  RecordFile file_;

 private:
  std::vector<Pinhole> pinholes_;
};

class CsvBlobSink final : public FileBlobSink {
 public:
  CsvBlobSink(const OutputSpec& spec, std::span<const CameraCalibration> cameras)
      : FileBlobSink(spec, cameras,
                     "tick,camera,x_px,y_px,x_undist_px,y_undist_px,area_px,sum,peak,overflow\n") {}

  SinkStatus write(const BlobRow& row) noexcept override {
    const Pinhole& lens = pinhole(row.camera);
    for (const shaders::BlobRecord& blob : row.blobs) {
      file_.unsigned_integer(number(row.trigger)).text(",");
      file_.unsigned_integer(index(row.camera) + 1).text(",");
      file_.number(double_of(blob.x_px), kPixelDecimals, "nan").text(",");
      file_.number(double_of(blob.y_px), kPixelDecimals, "nan").text(",");
      file_.number(double_of(blob.x_undist) * lens.fx_px + lens.cx_px, kPixelDecimals, "nan").text(",");
      file_.number(double_of(blob.y_undist) * lens.fy_px + lens.cy_px, kPixelDecimals, "nan").text(",");
      file_.unsigned_integer(blob.area_px).text(",");
      file_.unsigned_integer(blob.sum).text(",");
      file_.unsigned_integer(blob.peak).text(row.overflow ? ",1" : ",0");
      file_.end_row();
    }
    return file_.end_group();
  }
};

class JsonlBlobSink final : public FileBlobSink {
 public:
  JsonlBlobSink(const OutputSpec& spec, std::span<const CameraCalibration> cameras)
      : FileBlobSink(spec, cameras, {}) {}

  SinkStatus write(const BlobRow& row) noexcept override {
    const Pinhole& lens = pinhole(row.camera);
    file_.text("{\"tick\":").unsigned_integer(number(row.trigger));
    file_.text(",\"camera\":").unsigned_integer(index(row.camera) + 1);
    file_.text(row.overflow ? ",\"overflow\":true,\"blobs\":[" : ",\"overflow\":false,\"blobs\":[");
    bool first = true;
    for (const shaders::BlobRecord& blob : row.blobs) {
      file_.text(first ? "{\"x_px\":" : ",{\"x_px\":").number(double_of(blob.x_px), kPixelDecimals, "null");
      file_.text(",\"y_px\":").number(double_of(blob.y_px), kPixelDecimals, "null");
      file_.text(",\"x_undist_px\":")
          .number(double_of(blob.x_undist) * lens.fx_px + lens.cx_px, kPixelDecimals, "null");
      file_.text(",\"y_undist_px\":")
          .number(double_of(blob.y_undist) * lens.fy_px + lens.cy_px, kPixelDecimals, "null");
      file_.text(",\"area_px\":").unsigned_integer(blob.area_px);
      file_.text(",\"sum\":").unsigned_integer(blob.sum);
      file_.text(",\"peak\":").unsigned_integer(blob.peak).text("}");
      first = false;
    }
    file_.text("]}");
    file_.end_row();
    return file_.end_group();
  }
};

class NoBlobSink final : public BlobSink {
 public:
  SinkStatus write(const BlobRow&) noexcept override { return SinkStatus::Ok; }
  SinkStatus flush() noexcept override { return SinkStatus::Ok; }
  SinkStatus finish() noexcept override { return SinkStatus::Ok; }
  SinkCounters counters() const noexcept override { return {}; }
  const std::string& problem() const noexcept override { return problem_; }

 private:
  std::string problem_;
};

}  // namespace

std::unique_ptr<BlobSink> make_blob_sink(const OutputSpec& spec, std::span<const CameraCalibration> cameras) {
  switch (spec.kind) {
    case OutputKind::Csv:
      return std::make_unique<CsvBlobSink>(spec, cameras);
    case OutputKind::Jsonl:
      return std::make_unique<JsonlBlobSink>(spec, cameras);
    case OutputKind::None:
      break;
  }
  return std::make_unique<NoBlobSink>();
}

}  // namespace glint
