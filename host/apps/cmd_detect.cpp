// SPDX-License-Identifier: MIT
// `glint detect`: images in, a table of blobs out, and pictures to tune by.
#include <cstdio>
#include <filesystem>
#include <memory>

#include "host/apps/commands.hpp"
#include "host/apps/run_arguments.hpp"
#include "host/apps/stop_signal.hpp"
#include "host/base/error.hpp"
#include "host/capture/image_file.hpp"
#include "host/output/blob_sink.hpp"
#include "host/output/latency_histogram.hpp"
#include "host/output/overlay.hpp"

namespace glint::apps {
namespace {

struct DetectArguments {
  RunArguments run;
  std::string output = "none", overlay;
  bool force = false, quiet = false;
};

std::vector<CameraCalibration> calibrations_of(const OpenedRun& run) {
  std::vector<CameraCalibration> cameras = run.rig.calibration.cameras;
  if (cameras.empty()) cameras.resize(run.input->cameras().size());
  return cameras;
}

/// Draws each image with its blobs into DIR/CAMERA/TICK.png.
class OverlayWriter {
 public:
  OverlayWriter(std::filesystem::path folder, std::span<const SourceCamera> cameras)
      : folder_(std::move(folder)) {
    for (const SourceCamera& camera : cameras) {
      std::error_code error;
      std::filesystem::create_directories(folder_ / camera.name, error);
      if (error) throw Error((folder_ / camera.name).string() + ": cannot be made: " + error.message());
      names_.push_back(camera.name);
    }
  }

  void write(const TickBlobs& tick) {
    for (std::size_t i = 0; i < names_.size(); ++i) {
      const gpu::ImageView& image = tick.images[i];
      if (image.pixels == nullptr) continue;
      draw_overlay({image.pixels, image.width_px, image.height_px, image.stride_bytes}, tick.cameras[i], {},
                   rgb_);
      char name[32];
      std::snprintf(name, sizeof name, "%06llu.png", static_cast<unsigned long long>(number(tick.trigger)));
      write_png_rgb(folder_ / names_[i] / name, image.width_px, image.height_px, rgb_);
    }
  }

 private:
  std::filesystem::path folder_;
  std::vector<std::string> names_;
  std::vector<std::uint8_t> rgb_;
};

void run(const DetectArguments& a) {
  const OutputSpec spec = parse_output_spec(a.output, a.force);
  if (a.run.source.starts_with("blobs:"))
    throw UsageError("detect works on images: sim, v4l2:[DEVICE,...] or images:LOCATION");
  StopSignal stop_signal;
  OpenedRun opened = open_run(a.run, false);
  TickInput& input = *opened.input;
  const auto sink = make_blob_sink(spec, calibrations_of(opened));
  std::unique_ptr<OverlayWriter> overlay;
  if (!a.overlay.empty()) overlay = std::make_unique<OverlayWriter>(a.overlay, input.cameras());
  if (!a.quiet) {
    std::fprintf(stderr, "glint: %s, %zu cameras, on %s\n", a.run.source.c_str(), input.cameras().size(),
                 input.device_name().c_str());
    for (const std::string& note : opened.notes) std::fprintf(stderr, "glint: %s\n", note.c_str());
  }
  const StopSignal::Handler on_stop(stop_signal, [&input] { input.stop(); });

  LatencyHistogram detection;
  std::uint64_t blobs = 0;
  TickBlobs tick;
  ReadStatus status = ReadStatus::Ok;
  while ((status = input.next(tick)) == ReadStatus::Ok) {
    detection.add(seconds_between(tick.delivered, tick.detected));
    for (std::size_t i = 0; i < tick.cameras.size(); ++i) {
      blobs += tick.cameras[i].size();
      const BlobRow row{tick.trigger, static_cast<CameraId>(i), tick.cameras[i],
                        (tick.overflow >> i & 1u) != 0};
      if (sink->write(row) != SinkStatus::Ok) throw Error("output: " + sink->problem());
    }
    if (overlay) overlay->write(tick);
  }
  if (sink->finish() != SinkStatus::Ok) throw Error("output: " + sink->problem());
  const InputCounters counters = input.counters();
  if (!a.quiet) {
    std::fprintf(stderr,
                 "%llu frame sets, %llu blobs, %llu images overflowed, detection p50 %.2f ms p99 %.2f ms\n",
                 static_cast<unsigned long long>(counters.sets), static_cast<unsigned long long>(blobs),
                 static_cast<unsigned long long>(counters.overflows), detection.quantile_s(0.5) * 1e3,
                 detection.quantile_s(0.99) * 1e3);
    if (overlay) std::fprintf(stderr, "pictures: %s\n", a.overlay.c_str());
  }
  if (status == ReadStatus::Failed) throw Error(input.problem());
  if (!input.live() && (counters.source.damaged > 0 || counters.source.ended_early > 0)) {
    throw Error("the recording is not whole:\n" + input.problem());
  }
  if (!a.quiet && !input.problem().empty())
    std::fprintf(stderr, "glint: note: %s\n", input.problem().c_str());
}

}  // namespace

void add_detect(CLI::App& app) {
  CLI::App* command = app.add_subcommand("detect", "Find blobs in images");
  const auto a = std::make_shared<DetectArguments>();
  add_run_options(*command, a->run, "sim, v4l2:[DEVICE,...] or images:LOCATION");
  command->add_option("--output", a->output, "csv:FILE, csv:-, jsonl:FILE, jsonl:- or none")
      ->capture_default_str();
  command->add_option("--overlay", a->overlay, "folder for pictures with the blobs drawn in");
  command->add_flag("--force", a->force, "replace an existing output file");
  command->add_flag("--quiet", a->quiet, "no messages");
  command->callback([a] { run(*a); });
}

}  // namespace glint::apps
