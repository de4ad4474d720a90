// SPDX-License-Identifier: MIT
// From words on the command line to an open input.
#include "host/apps/run_arguments.hpp"

#include <algorithm>
#include <filesystem>
#include <functional>
#include <string_view>

#include "gpu/background.hpp"
#include "host/apps/rig_board.hpp"
#include "host/base/error.hpp"
#include "host/capture/blob_source.hpp"
#include "host/capture/image_file.hpp"
#include "host/capture/image_source.hpp"
#include "host/capture/v4l2/v4l2_source.hpp"
#include "host/pipeline/blob_input.hpp"
#include "host/pipeline/frame_input.hpp"
#include "host/pipeline/learn_background.hpp"
#include "host/sim/rig.hpp"
#include "host/sim/sim_source.hpp"

namespace glint::apps {
namespace {

constexpr std::string_view kImages = "images:", kBlobs = "blobs:", kLive = "v4l2:";

bool all_digits(const std::string& text) {
  return !text.empty() && text.size() < 7 &&
         std::all_of(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; });
}

void check_sim_cameras(const Rig& rig, const Scene& scene) {
  const auto& wanted = rig.calibration.cameras;
  const auto& simulated = scene.calibration().cameras;
  bool same = wanted.size() == simulated.size();
  for (std::size_t i = 0; same && i < wanted.size(); ++i) {
    same = wanted[i].width_px == simulated[i].width_px && wanted[i].height_px == simulated[i].height_px;
  }
  if (same) return;
  throw UsageError(
      rig.path.string() + " has " + std::to_string(wanted.size()) + " cameras, the simulated rig " +
      std::to_string(simulated.size()) + " of " + std::to_string(simulated.front().width_px) + "x" +
      std::to_string(simulated.front().height_px) + ": they must agree (--cameras, --width, --height)");
}

// The file's settings, then the command line's over them.
Rig make_rig(const RunArguments& a, const Scene* scene) {
  Rig rig;
  if (!a.rig_file.empty()) {
    rig = read_rig(a.rig_file);
    if (scene != nullptr) check_sim_cameras(rig, *scene);
    if (scene != nullptr && a.sim.calibration_error_px > 0.0) {
      throw UsageError("--calibration-error: the calibration comes from --rig " + a.rig_file +
                       "; leave out one of the two");
    }
  } else if (scene != nullptr) {
    rig.name = "simulated";
    rig.calibration = told_calibration(a.sim, scene->calibration());
    rig.rate_hz = scene->options().rate_hz;
    rig.marker_radius_m = rig.match.marker_radius_m = scene->options().marker_radius_m;
    rig.match.exposure_s = scene->options().exposure_s;
    rig.sync.code_seed = scene->options().code_seed;
    rig.sync.code_group = scene->options().code_group;
  }
  if (!a.device.empty()) rig.gpu.device = a.device;
  if (a.depth) rig.gpu.depth = *a.depth;
  if (a.threshold) rig.detect.threshold = *a.threshold;
  if (a.min_area_px) rig.detect.min_area_px = *a.min_area_px;
  if (a.max_area_px) rig.detect.max_area_px = *a.max_area_px;
  if (a.rate_hz) rig.rate_hz = *a.rate_hz;
  if (a.plane_height_m) rig.match.plane_height_m = *a.plane_height_m;
  if (a.background == "none") rig.detect.background_frames = 0;
  if (all_digits(a.background))
    rig.detect.background_frames = static_cast<unsigned>(std::stoul(a.background));
  std::vector<std::string> problems;
  rig.gpu.check(problems);
  rig.detect.check(problems);
  rig.match.check(problems);
  rig.track.check(problems);
  if (problems.empty()) return rig;
  std::string text;
  for (const std::string& problem : problems) text += (text.empty() ? "" : "\n") + problem;
  throw UsageError(text);
}

PaceOptions make_pace(const RunArguments& a, const Rig& rig, bool simulated) {
  if (a.source.starts_with(kLive)) {
    if (!a.pace.empty()) throw UsageError("--pace: cameras set the pace themselves");
    return {Pace::Fastest, 0.0};
  }
  if (a.pace.empty()) {
    if (a.rate_hz || simulated) return {Pace::Rate, rig.rate_hz};
    return {Pace::Fastest, 0.0};
  }
  if (a.pace == "fast") return {Pace::Fastest, 0.0};
  if (a.pace == "recorded") return {Pace::AsRecorded, 0.0};
  if (a.pace == "rate") return {Pace::Rate, rig.rate_hz};
  throw UsageError("--pace " + a.pace + ": must be recorded, rate or fast");
}

std::vector<gpu::Lens> lenses_of(const Rig& rig, std::size_t cameras) {
  std::vector<gpu::Lens> lenses(cameras);
  for (std::size_t i = 0; i < rig.calibration.cameras.size(); ++i) {
    const CameraCalibration& c = rig.calibration.cameras[i];
    lenses[i] = {c.fx_px, c.fy_px, c.cx_px, c.cy_px, c.k1_k2_p1_p2_k3};
  }
  return lenses;
}

ImageSourceOptions image_options(const RunArguments& a, const Rig& rig) {
  ImageSourceOptions options;
  options.rate_hz = a.rate_hz || !a.rig_file.empty() ? rig.rate_hz : 0.0;
  for (const CameraCalibration& camera : rig.calibration.cameras) {
    options.camera_names.push_back(camera.name);
    options.camera_sizes.push_back({camera.width_px, camera.height_px});
  }
  return options;
}

std::filesystem::path background_file(const std::filesystem::path& where, const std::string& camera) {
  if (!std::filesystem::is_directory(where)) return where;
  for (const auto& entry : std::filesystem::directory_iterator(where)) {
    if (entry.is_regular_file() && entry.path().stem() == camera) return entry.path();
  }
  throw Error(where.string() + ": no background picture for camera " + camera + " (expected " + camera +
              ".png or the like)");
}

using Backgrounds = std::vector<gpu::Background>;

Backgrounds backgrounds_from_files(std::span<const SourceCamera> cameras, const std::string& where,
                                   unsigned threshold) {
  Backgrounds backgrounds;
  for (const SourceCamera& camera : cameras) {
    const std::filesystem::path file = background_file(where, camera.name);
    const GreyImage image = read_grey_image(file);
    if (image.width_px != camera.size.width_px || image.height_px != camera.size.height_px) {
      throw Error(file.string() + ": " + std::to_string(image.width_px) + "x" +
                  std::to_string(image.height_px) + " pixels, but camera " + camera.name + " has " +
                  std::to_string(camera.size.width_px) + "x" + std::to_string(camera.size.height_px));
    }
    gpu::BackgroundLearner learner;
    learner.add(image.view());
    backgrounds.push_back(learner.learn(threshold));
  }
  return backgrounds;
}

// `learn_from` loses the frames that are learnt from.
Backgrounds make_backgrounds(const RunArguments& a, const DetectSettings& detect,
                             std::span<const SourceCamera> cameras,
                             const std::function<FrameSource&()>& learn_from,
                             std::vector<std::string>& notes) {
  if (!a.background.empty() && a.background != "none" && !all_digits(a.background)) {
    return backgrounds_from_files(cameras, a.background, detect.threshold);
  }
  if (detect.background_frames == 0) {
    Backgrounds backgrounds;
    for (const SourceCamera& camera : cameras) {
      backgrounds.push_back(
          {gpu::flat_limit(camera.size.width_px, camera.size.height_px, detect.threshold), {}});
    }
    return backgrounds;
  }
  LearntBackgrounds learnt = learn_backgrounds(learn_from(), detect.background_frames, detect.threshold);
  if (learnt.frames < detect.background_frames) {
    notes.push_back("background learnt from " + std::to_string(learnt.frames) + " frames, all there are");
  }
  return std::move(learnt.cameras);
}

// Where to end, in frame sets; 0: at the end of the source.
std::uint64_t sets_wanted(const RunArguments& a, double rate_hz) {
  if (!a.seconds) return a.max_ticks;
  const auto sets = std::max<std::uint64_t>(1, static_cast<std::uint64_t>(*a.seconds * rate_hz + 0.5));
  return a.max_ticks == 0 ? sets : std::min(a.max_ticks, sets);
}

void open_frames(OpenedRun& run, const RunArguments& a, FrameInputOptions options, RealTime* real_time) {
  if (real_time != nullptr)
    options.on_capture_thread = [real_time] { real_time->enter(ThreadRole::Assembly); };
  const auto open = [&]() -> std::unique_ptr<FrameSource> {
    if (run.scene)
      return std::make_unique<SimSource>(*run.scene, SimSourceOptions{options.pace.pace != Pace::Fastest, 0});
    if (a.source.starts_with(kLive)) {
      const bool rate_known = a.rate_hz || !a.rig_file.empty();
      V4l2Options live = live_options(std::string_view(a.source).substr(kLive.size()),
                                      rate_known ? run.rig.rate_hz : 0.0, run.rig, a.live);
      run.board = open_board(run.rig, run.notes);
      live.pulses = run.board.get();
      live.assemble.exposure_s = run.board ? run.rig.sync.strobe_us * 1e-6 : 0.0;
      if (real_time != nullptr) live.feed.on_thread = [real_time] { real_time->enter(ThreadRole::Camera); };
      return std::make_unique<V4l2Source>(live);
    }
    return open_image_source(a.source.substr(kImages.size()), image_options(a, run.rig));
  };
  std::unique_ptr<FrameSource> source = open(), lesson;
  // A live source is learnt from as it comes; a recording is opened twice, so that tracking starts at its
  // first frame.
  const auto learn_from = [&]() -> FrameSource& {
    if (source->live()) return *source;
    lesson = open();
    return *lesson;
  };
  const std::size_t cameras = source->cameras().size();
  options.max_sets = sets_wanted(a, source->rate_hz() > 0.0 ? source->rate_hz() : run.rig.rate_hz);
  Backgrounds backgrounds = make_backgrounds(a, run.rig.detect, source->cameras(), learn_from, run.notes);
  auto input = std::make_unique<FrameInput>(std::move(source), lenses_of(run.rig, cameras), options);
  for (std::uint32_t i = 0; i < cameras; ++i) input->set_background(i, std::move(backgrounds[i]));
  if (!input->reads_in_place() && input->device_name().rfind("cpu", 0) != 0) {
    run.notes.push_back("frames are copied: " + input->device_name() + " cannot read them in place");
  }
  run.input = std::move(input);
}

}  // namespace

void add_run_options(CLI::App& command, RunArguments& a, const std::string& sources) {
  command.add_option("SOURCE", a.source, sources)->required();
  command.add_option("--rig", a.rig_file, "rig or calibration file (docs/rig-file.md)");
  command.add_option("--device", a.device, "auto, cpu, an index, a UUID or part of a name (glint devices)");
  command.add_option("--depth", a.depth, "frame sets in flight: 1 least delay, 2 most throughput");
  command.add_option("--threshold", a.threshold, "grey levels above the background");
  command.add_option("--min-area", a.min_area_px, "smallest blob, pixels");
  command.add_option("--max-area", a.max_area_px, "largest blob, pixels");
  command.add_option("--background", a.background,
                     "number of frames to learn from, a picture or a folder with one per camera, or none");
  command.add_option("--plane-height", a.plane_height_m,
                     "one camera: height of the markers' centres in the world, m");
  command.add_option("--pace", a.pace, "recorded, rate or fast (recordings: fast; sim: rate)");
  command.add_option("--rate", a.rate_hz, "frame sets per second")->check(CLI::Range(0.001, 10000.0));
  command.add_option("--seconds", a.seconds, "end after so long (at the nominal rate)")
      ->check(CLI::Range(0.0, 1e7));
  command.add_option("--ticks", a.max_ticks, "end after so many frame sets");
  command.add_option("--camera-format", a.live.format, "v4l2: auto, grey, nv12, yuyv or mjpeg");
  command.add_option("--camera-size", a.live.size, "v4l2 without --rig: WIDTHxHEIGHT");
  add_sim_options(command, a.sim);
}

OpenedRun open_run(const RunArguments& a, bool rig_needed, RealTime* real_time) {
  const bool simulated = a.source == "sim";
  const bool images = a.source.starts_with(kImages), blobs = a.source.starts_with(kBlobs);
  if (!simulated && !images && !blobs && !a.source.starts_with(kLive)) {
    throw UsageError("source \"" + a.source +
                     "\": must be sim, v4l2:[DEVICE,...], images:LOCATION or blobs:FOLDER");
  }
  if (rig_needed && !simulated && a.rig_file.empty()) {
    throw UsageError(
        "--rig FILE is needed: where the cameras are (glint import calibration makes one from other tools' "
        "files)");
  }
  OpenedRun run;
  if (simulated) {
    SimOptions options = checked_sim_options(a.sim);
    if (a.rate_hz) options.rate_hz = *a.rate_hz;
    run.scene = std::make_unique<Scene>(options);
  }
  run.rig = make_rig(a, run.scene.get());
  const PaceOptions pace = make_pace(a, run.rig, simulated);
  if (blobs) {
    std::vector<std::string> names;
    for (const CameraCalibration& camera : run.rig.calibration.cameras) names.push_back(camera.name);
    auto source = open_blob_source(a.source.substr(kBlobs.size()), {names, run.rig.rate_hz});
    const std::size_t cameras = source->cameras().size();
    run.input = std::make_unique<BlobInput>(std::move(source), lenses_of(run.rig, cameras), run.rig.rate_hz,
                                            pace, sets_wanted(a, run.rig.rate_hz));
    return run;
  }
  FrameInputOptions options;
  options.device = run.rig.gpu.device;
  options.detector.min_area_px = run.rig.detect.min_area_px;
  options.detector.max_area_px = run.rig.detect.max_area_px;
  options.detector.max_blobs_per_camera = run.rig.detect.max_blobs_per_camera;
  options.detector.depth = run.rig.gpu.depth;
  options.pace = pace;
  if (run.rig.sync.code_seed != 0) {
    options.code.emplace(run.rig.sync.code_seed,
                         PulseCode::group_for(run.rig.sync.code_group, run.rig.rate_hz));
  }
  open_frames(run, a, options, real_time);
  return run;
}

}  // namespace glint::apps
