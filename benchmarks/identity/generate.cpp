// SPDX-License-Identifier: MIT
// Blobs as glint's CPU detector finds them, and what was really there.
#include "benchmarks/identity/generate.hpp"

#include <bit>
#include <memory>
#include <vector>

#include "benchmarks/identity/product.hpp"
#include "host/base/error.hpp"
#include "host/config/rig.hpp"
#include "host/files/text_file.hpp"
#include "host/output/record_file.hpp"

namespace glint::identity {
namespace {

namespace fs = std::filesystem;
constexpr int kPixelDecimals = 4, kMetreDecimals = 9;

void expect_written(SinkStatus status, const RecordFile& file) {
  if (status != SinkStatus::Ok) throw Error(file.problem());
}

void prepare(const fs::path& folder) {
  try {
    if (fs::exists(folder) && !fs::is_empty(folder))
      throw Error(folder.string() + ": is there and not empty; give another folder");
    fs::create_directories(folder / "blobs");
  } catch (const fs::filesystem_error& error) {
    throw Error(folder.string() + ": cannot be made: " + error.code().message());
  }
}

void write_truth(RecordFile& file, const TickTruth& truth) {
  for (std::uint32_t m = 0; m < truth.markers.size(); ++m) {
    const MarkerTruth& marker = truth.markers[m];
    file.unsigned_integer(truth.tick).text(",").unsigned_integer(m).text(",");
    for (int axis = 0; axis < 3; ++axis)
      file.number(marker.position_in_world[axis], kMetreDecimals, "nan").text(",");
    file.unsigned_integer(marker.visible & truth.delivered)
        .text(",")
        .unsigned_integer(marker.clean)
        .text(",");
    file.text(std::popcount(marker.visible & truth.delivered) >= 2 ? "1" : "0");
    file.end_row();
  }
  expect_written(file.end_group(), file);
}

void write_blobs(RecordFile& file, std::uint64_t tick, std::span<const gpu::BlobRecord> blobs) {
  for (const gpu::BlobRecord& blob : blobs) {
    file.unsigned_integer(tick).text(",");
    file.number(static_cast<double>(blob.x_px), kPixelDecimals, "nan").text(",");
    file.number(static_cast<double>(blob.y_px), kPixelDecimals, "nan").text(",");
    file.unsigned_integer(blob.area_px).text(",").unsigned_integer(blob.sum);
    file.end_row();
  }
  expect_written(file.end_group(), file);
}

}  // namespace

void generate(const ChosenScene& chosen, const fs::path& folder) {
  prepare(folder);
  const Scene scene(chosen.scene->options_with(chosen.seed));
  const Calibration calibration = given_calibration(scene, chosen.scene->calibration_error_px);
  write_calibration(folder / "calibration.toml", calibration);
  RecordFile truth_file((folder / "truth.csv").string(), false,
                        "tick,marker,x_m,y_m,z_m,cameras_visible,cameras_clean,expected\n");
  std::vector<std::unique_ptr<RecordFile>> blob_files;
  for (const CameraCalibration& camera : calibration.cameras) {
    blob_files.push_back(std::make_unique<RecordFile>((folder / "blobs" / (camera.name + ".csv")).string(),
                                                      false, "tick,x_px,y_px,area_px,sum\n"));
  }
  const std::unique_ptr<TickInput> input = open_scene(scene, chosen.ticks);
  TickBlobs blobs;
  TickTruth truth;
  ReadStatus status = ReadStatus::Ok;
  while ((status = input->next(blobs)) == ReadStatus::Ok) {
    const std::uint64_t tick = number(blobs.trigger);
    scene.truth(tick, truth);
    write_truth(truth_file, truth);
    for (std::size_t c = 0; c < blob_files.size(); ++c) write_blobs(*blob_files[c], tick, blobs.cameras[c]);
  }
  if (status == ReadStatus::Failed) throw Error(input->problem());
  expect_written(truth_file.finish(), truth_file);
  for (const auto& file : blob_files) expect_written(file->finish(), *file);
  write_text_file(folder / "scene.json", scene_json(chosen), false);
}

}  // namespace glint::identity
