// SPDX-License-Identifier: MIT
// Motion JPEG in memory to blobs: glint's two decoders and its detectors, beside cv::imdecode and the
// thesis's steps, as Markdown tables.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <ctime>
#include <memory>
#include <opencv2/imgcodecs.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "benchmarks/jpeg_streams.hpp"
#include "benchmarks/opencv_steps.hpp"
#include "host/pipeline/frame_input.hpp"
#include "host/pipeline/learn_background.hpp"
#include "host/sim/rig.hpp"
#include "host/sim/sim_source.hpp"

namespace glint::benchmarks {
namespace {

struct Options {
  SimOptions sim;
  std::vector<int> qualities{80, 90};
  std::vector<std::string> devices;
  double seconds = 2.0;
  unsigned rounds = 5, length = 12, threshold = 12;
};

/// One run of one contender.
struct Run {
  double sets_per_s = 0.0, decode_ms = 0.0, total_ms = 0.0;  // CPU time of all threads per set
  std::vector<double> latency_ms;                            // paced runs only
  std::uint64_t sets = 0, missed = 0;
  double blobs = 0.0;
};

struct Contender {
  std::string name;
  std::function<Run(bool paced)> run;
  std::vector<Run> paced, unpaced;
};

double process_cpu_s() noexcept {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_nsec) * 1e-9;
}

std::vector<gpu::Lens> lenses_of(const SimOptions& sim) {
  std::vector<gpu::Lens> lenses;
  for (const CameraCalibration& c : sim_calibration(sim).cameras)
    lenses.push_back({c.fx_px, c.fy_px, c.cx_px, c.cy_px, c.k1_k2_p1_p2_k3});
  return lenses;
}

Run run_glint(const Options& o, const JpegPictures& pictures, const LearntBackgrounds& learnt,
              const std::string& device, bool whole, bool paced) {
  // Enough sets for the time wanted, or for a while where nothing waits.
  const auto sets = static_cast<std::uint64_t>(o.seconds * (paced ? o.sim.rate_hz : 400.0));
  FrameInputOptions options;
  options.device = device;
  options.pace = {Pace::Fastest, 0.0};
  auto source = std::make_unique<JpegStreams>(pictures, sets, o.sim.rate_hz, paced, whole);
  const JpegStreams& streams = *source;
  FrameInput input(std::move(source), lenses_of(o.sim), options);
  for (std::uint32_t camera = 0; camera < learnt.cameras.size(); ++camera)
    input.set_background(camera, learnt.cameras[camera]);
  const std::uint64_t warm_up = sets / 4;
  Run run;
  TickBlobs tick;
  double cpu_s = 0.0, decoding_s = 0.0;
  Timestamp from{}, to{};
  ReadStatus status = ReadStatus::Ok;
  while ((status = input.next(tick)) == ReadStatus::Ok || status == ReadStatus::Idle) {
    if (status == ReadStatus::Idle || number(tick.trigger) < warm_up) continue;
    if (run.sets++ == 0) {
      cpu_s = process_cpu_s();
      decoding_s = streams.decoding_cpu_s();
      from = tick.detected;
    }
    to = tick.detected;
    for (const auto& camera : tick.cameras) run.blobs += static_cast<double>(camera.size());
    if (paced) run.latency_ms.push_back(seconds_between(tick.exposed, tick.detected) * 1e3);
  }
  if (status == ReadStatus::Failed) throw std::runtime_error(input.problem());
  const auto measured = static_cast<double>(run.sets - 1);
  run.sets_per_s = measured / seconds_between(from, to);
  run.total_ms = (process_cpu_s() - cpu_s) * 1e3 / measured;
  run.decode_ms = (streams.decoding_cpu_s() - decoding_s) * 1e3 / measured;
  run.blobs /= static_cast<double>(run.sets);
  run.missed = sets - warm_up - run.sets;
  return run;
}

/// imdecode and the thesis's steps, whole cameras shared out to two threads.
class OpenCvStreams {
 public:
  OpenCvStreams(const Options& o, const JpegPictures& pictures, const LearntBackgrounds& learnt, bool maps)
      : pictures_(pictures),
        maps_(maps),
        grey_(pictures.cameras()),
        found_(pictures.cameras()),
        workers_(1, 1, static_cast<unsigned>(pictures.cameras()), &OpenCvStreams::work, this) {
    const std::vector<gpu::Lens> lenses = lenses_of(o.sim);
    for (std::size_t camera = 0; camera < pictures.cameras(); ++camera) {
      const FrameSize size = pictures.described()[camera].size;
      std::vector<std::uint8_t> background = learnt.cameras[camera].limit;
      for (std::uint8_t& grey : background)
        grey = static_cast<std::uint8_t>(grey - std::min<unsigned>(grey, o.threshold));
      cameras_.emplace_back(gpu::CameraFormat{size.width_px, size.height_px, lenses[camera]}, background);
    }
  }

  Run run(double seconds, double rate_hz, bool paced) {
    Run result;
    cpu_ns_ = 0;
    const double cpu_s = process_cpu_s();
    const Timestamp started = std::chrono::steady_clock::now();
    const auto most = static_cast<std::uint64_t>(seconds * rate_hz);
    Timestamp now = started;
    for (; paced ? set_no_ < most : seconds_between(started, now) < seconds; ++set_no_) {
      Timestamp due = now;
      if (paced) {
        due = started + std::chrono::duration_cast<Timestamp::duration>(
                            std::chrono::duration<double>(static_cast<double>(set_no_) / rate_hz));
        // Newest first, as glint does: what is more than two periods old is left out.
        if (seconds_between(due, now) > 2.0 / rate_hz) {
          ++result.missed;
          continue;
        }
        std::this_thread::sleep_until(due);
      }
      workers_.start();
      workers_.finish(0);
      now = std::chrono::steady_clock::now();
      if (paced) result.latency_ms.push_back(seconds_between(due, now) * 1e3);
      ++result.sets;
      for (const std::size_t found : found_) result.blobs += static_cast<double>(found);
    }
    set_no_ = 0;
    const auto sets = static_cast<double>(result.sets);
    result.sets_per_s = sets / seconds_between(started, now);
    result.total_ms = (process_cpu_s() - cpu_s) * 1e3 / sets;
    result.decode_ms = static_cast<double>(cpu_ns_.load()) * 1e-6 / sets;
    result.blobs /= sets;
    return result;
  }

 private:
  static void work(void* context, unsigned, unsigned camera) noexcept {
    OpenCvStreams& self = *static_cast<OpenCvStreams*>(context);
    const std::span<const std::byte> jpeg = self.pictures_.picture(self.set_no_, camera);
    const cv::Mat bytes(1, static_cast<int>(jpeg.size()), CV_8UC1, const_cast<std::byte*>(jpeg.data()));
    const double before_s = thread_cpu_s();
    cv::imdecode(bytes, cv::IMREAD_GRAYSCALE, &self.grey_[camera]);
    self.cpu_ns_ += static_cast<std::int64_t>((thread_cpu_s() - before_s) * 1e9);
    OpenCvCamera& steps = self.cameras_[camera];
    self.found_[camera] =
        self.maps_ ? steps.thesis_with_maps(self.grey_[camera]) : steps.thesis(self.grey_[camera]);
  }

  const JpegPictures& pictures_;
  bool maps_;
  std::uint64_t set_no_ = 0;
  std::vector<OpenCvCamera> cameras_;
  std::vector<cv::Mat> grey_;
  std::vector<std::size_t> found_;
  std::atomic<std::int64_t> cpu_ns_{0};
  gpu::Workers workers_;  // last: its threads use everything above
};

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2),
                   values.end());
  return values[values.size() / 2];
}

double median_of(const std::vector<Run>& runs, double Run::*figure) {
  std::vector<double> values;
  for (const Run& run : runs) values.push_back(run.*figure);
  return median(values);
}

void print(const Options& o, const Contender& c) {
  std::vector<double> all;
  std::uint64_t sets = 0, missed = 0;
  for (const Run& run : c.paced) {
    all.insert(all.end(), run.latency_ms.begin(), run.latency_ms.end());
    sets += run.sets + run.missed;
    missed += run.missed;
  }
  std::sort(all.begin(), all.end());
  const double total_ms = median_of(c.paced, &Run::total_ms), decode_ms = median_of(c.paced, &Run::decode_ms);
  const double period_ms = 1e3 / o.sim.rate_hz;
  std::printf("| %s | %.0f | %.2f | %.2f | %.0f %% | %.0f %% | %.2f | %.2f | %.2f | %llu of %llu | %.1f |\n",
              c.name.c_str(), median_of(c.unpaced, &Run::sets_per_s), decode_ms, total_ms - decode_ms,
              100.0 * decode_ms / period_ms, 100.0 * (total_ms - decode_ms) / period_ms, all[all.size() / 2],
              all[all.size() * 99 / 100], all.back(), static_cast<unsigned long long>(missed),
              static_cast<unsigned long long>(sets), median_of(c.paced, &Run::blobs));
}

std::string name_of(const std::string& device) {
  if (device == "cpu") return "native";
  for (const gpu::DeviceInfo& info : gpu::list_devices()) {
    if (info.uuid == device) return info.name + (info.software ? " (software, no GPU)" : "");
  }
  return device;
}

void compare(const Options& o, const Scene& scene, const LearntBackgrounds& learnt, int quality) {
  const JpegPictures pictures(scene, o.length, quality);
  std::vector<std::unique_ptr<OpenCvStreams>> opencv;
  std::vector<Contender> contenders;
  for (const std::string& device : o.devices) {
    for (const bool whole : {false, true}) {
      contenders.push_back({(whole ? "glint, whole pictures, " : "glint, ") + name_of(device),
                            [&o, &pictures, &learnt, device, whole](bool paced) {
                              return run_glint(o, pictures, learnt, device, whole, paced);
                            },
                            {},
                            {}});
    }
  }
  for (const bool maps : {false, true}) {
    opencv.push_back(std::make_unique<OpenCvStreams>(o, pictures, learnt, maps));
    contenders.push_back({maps ? "OpenCV imdecode, thesis with precomputed maps" : "OpenCV imdecode, thesis",
                          [&o, streams = opencv.back().get()](bool paced) {
                            return streams->run(o.seconds, o.sim.rate_hz, paced);
                          },
                          {},
                          {}});
  }
  for (unsigned round = 0; round < o.rounds; ++round) {
    for (Contender& contender : contenders) {
      contender.unpaced.push_back(contender.run(false));
      contender.paced.push_back(contender.run(true));
    }
  }
  std::printf(
      "\n## Quality %d, %.0f kB a picture\n\n| | sets/s | decode ms | rest ms | decode, of a core | rest, of "
      "a core "
      "| p50 ms | p99 ms | max ms | missed | blobs |\n|---|---|---|---|---|---|---|---|---|---|---|\n",
      quality, pictures.mean_bytes() * 1e-3);
  for (const Contender& contender : contenders) print(o, contender);
  std::fflush(stdout);
}

int run_all(int argc, char** argv) {
  Options o;
  CLI::App app{"Motion JPEG in memory to blobs"};
  app.add_option("--device", o.devices, "as for glint track");
  app.add_option("--quality", o.qualities)->capture_default_str()->check(CLI::Range(1, 100));
  app.add_option("--cameras", o.sim.cameras)->capture_default_str()->check(CLI::Range(2u, gpu::kMaxCameras));
  app.add_option("--markers", o.sim.markers)->capture_default_str()->check(CLI::Range(1u, 500u));
  app.add_option("--noise", o.sim.faults.extra_noise_grey, "sd added to every pixel, grey levels")
      ->capture_default_str()
      ->check(CLI::Range(0.0, 50.0));
  app.add_option("--rate", o.sim.rate_hz, "frame sets per second of the paced runs")
      ->capture_default_str()
      ->check(CLI::Range(1.0, 1000.0));
  app.add_option("--seconds", o.seconds, "length of each run")
      ->capture_default_str()
      ->check(CLI::Range(0.5, 600.0));
  app.add_option("--rounds", o.rounds, "runs of each contender, in turns")
      ->capture_default_str()
      ->check(CLI::Range(1u, 100u));
  CLI11_PARSE(app, argc, argv);
  if (o.devices.empty()) {
    o.devices = {"cpu"};
    for (const gpu::DeviceInfo& device : gpu::list_devices()) {
      if (device.usable) o.devices.push_back(device.uuid);
    }
  }
  cv::setNumThreads(1);  // threads are ours: one camera each is quicker than splitting images
  const Scene scene(o.sim);
  SimSource to_learn_from(scene);
  const LearntBackgrounds learnt = learn_backgrounds(to_learn_from, 30, o.threshold);
  std::printf("%u cameras of %ux%u px, %u markers; CPU time per set and latency at %g Hz\n", o.sim.cameras,
              o.sim.width_px, o.sim.height_px, o.sim.markers, o.sim.rate_hz);
  for (const int quality : o.qualities) compare(o, scene, learnt, quality);
  return 0;
}

}  // namespace
}  // namespace glint::benchmarks

int main(int argc, char** argv) {
  try {
    return glint::benchmarks::run_all(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "mjpeg: %s\n", error.what());
    return 1;
  }
}
