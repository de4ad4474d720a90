// SPDX-License-Identifier: MIT
// `glint sim`: writes a recording of the simulated rig with its truth.
#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "host/apps/commands.hpp"
#include "host/apps/sim_arguments.hpp"
#include "host/base/error.hpp"
#include "host/capture/image_file.hpp"
#include "host/config/rig.hpp"
#include "host/sim/bound.hpp"
#include "host/sim/scene.hpp"
#include "host/sim/sim_source.hpp"

namespace glint::apps {
namespace {

namespace fs = std::filesystem;

struct SimCommandArguments {
  SimArguments sim;
  std::string out, rig_out, format = "pgm";
  double seconds = 1.0;
  bool force = false;
};

/// A CSV file that tells when the disk is full.
class CsvFile {
 public:
  CsvFile(fs::path path, std::string_view header) : path_(std::move(path)), file_(path_, std::ios::binary) {
    if (!file_) fail("cannot be written");
    line(header);
  }
  void line(std::string_view text) {
    file_ << text << '\n';
    if (!file_) fail("cannot be written to its end");
  }
  void finish() {
    file_.close();
    if (!file_) fail("cannot be written to its end");
  }

 private:
  [[noreturn]] void fail(const char* what) const {
    const int reason = errno;
    throw Error(path_.string() + ": " + what +
                (reason != 0 ? std::string(": ") + std::strerror(reason) : ""));
  }
  fs::path path_;
  std::ofstream file_;
};

bool all_digits(std::string_view text) {
  return !text.empty() &&
         std::all_of(text.begin(), text.end(), [](unsigned char c) { return std::isdigit(c) != 0; });
}

/// Whether that is a frame which an earlier run of this command wrote.
bool is_own_frame(const fs::path& path) {
  const std::string extension = path.extension().string();
  return (extension == ".pgm" || extension == ".png") && all_digits(path.stem().string());
}

/// Frames of an earlier, longer run must not mix with the new ones. Nothing else is touched.
void remove_old_frames(const fs::path& folder) {
  std::vector<fs::path> old;
  for (const fs::directory_entry& camera : fs::directory_iterator(folder)) {
    const std::string name = camera.path().filename().string();
    if (!camera.is_directory() || name.rfind("cam", 0) != 0 || !all_digits(std::string_view(name).substr(3)))
      continue;
    for (const fs::directory_entry& frame : fs::directory_iterator(camera.path())) {
      if (frame.is_regular_file() && is_own_frame(frame.path())) old.push_back(frame.path());
    }
    old.push_back(camera.path());  // goes only if nothing else is in it
  }
  for (const fs::path& path : old) {
    std::error_code not_empty;
    fs::remove(path, not_empty);
  }
}

void prepare_folder(const fs::path& folder, const SimCommandArguments& a,
                    std::span<const SourceCamera> cameras) {
  try {
    if (fs::exists(folder) && !fs::is_directory(folder))
      throw Error(folder.string() + ": is there and no folder");
    if (fs::exists(folder) && !fs::is_empty(folder)) {
      if (!a.force) throw Error(folder.string() + ": is not empty; give another folder or --force");
      remove_old_frames(folder);
    }
    for (const SourceCamera& camera : cameras) fs::create_directories(folder / camera.name);
  } catch (const fs::filesystem_error& error) {
    throw Error(error.path1().string() + ": cannot be made: " + error.code().message());
  }
}

/// Uncompressed frames are large: better told before than after half an hour.
void check_space(const fs::path& folder, const SimCommandArguments& a, const SimOptions& options,
                 std::uint64_t ticks) {
  if (a.format != "pgm") return;
  const double needed = static_cast<double>(ticks) * options.cameras * options.width_px * options.height_px;
  std::error_code unknown;
  const fs::space_info space = fs::space(folder, unknown);
  if (unknown || needed < static_cast<double>(space.available)) return;
  char text[160];
  std::snprintf(text, sizeof text,
                ": no room: %.0f MB are needed, %.0f MB are free; use --format png or fewer --seconds",
                needed / 1e6, static_cast<double>(space.available) / 1e6);
  throw Error(folder.string() + text);
}

std::string truth_line(const TickTruth& truth, std::uint32_t marker, double variance_m2) {
  const MarkerTruth& ball = truth.markers[marker];
  char text[200];
  const int length =
      std::snprintf(text, sizeof text, "%llu,%u,%.9f,%.9f,%.9f,%u,%u,",
                    static_cast<unsigned long long>(truth.tick), marker, ball.position_in_world.x(),
                    ball.position_in_world.y(), ball.position_in_world.z(), ball.visible, ball.clean);
  std::string line(text, static_cast<std::size_t>(length));
  if (!std::isfinite(variance_m2)) return line;  // empty: fewer than two cameras see it alone
  std::snprintf(text, sizeof text, "%.9f", std::sqrt(variance_m2));
  return line + text;
}

void write_recording(const SimCommandArguments& a, const SimOptions& options, const Scene& scene) {
  const fs::path folder = a.out;
  const auto ticks = static_cast<std::uint64_t>(std::llround(a.seconds * options.rate_hz));
  if (ticks == 0) throw UsageError("--seconds " + std::to_string(a.seconds) + ": is less than one frame");
  SimSource source(scene, {false, ticks});
  prepare_folder(folder, a, source.cameras());
  check_space(folder, a, options, ticks);
  write_calibration(folder / "calibration.toml", told_calibration(a.sim, scene.calibration()), a.force);
  CsvFile frames_csv(folder / "frames.csv", "camera,frame,sequence,time_ns");
  CsvFile truth_csv(folder / "truth.csv", "tick,marker,x_m,y_m,z_m,cameras_visible,cameras_clean,crb_m");

  FramePool pool(std::vector<FrameSize>(options.cameras, {options.width_px, options.height_px}), 1);
  PositionBound bound(scene);
  FrameSet set;
  TickTruth truth;
  for (std::uint64_t tick = 0; tick < ticks; ++tick) {
    if (source.read(pool, set) != ReadStatus::Ok) throw Error(source.problem());
    for (std::size_t c = 0; c < source.cameras().size(); ++c) {
      if (!set.frames[c]) continue;
      const Frame& frame = *set.frames[c];
      const std::string& camera = source.cameras()[c].name;
      char name[40];
      std::snprintf(name, sizeof name, "%06llu.%s", static_cast<unsigned long long>(tick), a.format.c_str());
      if (a.format == "pgm") {
        write_pgm(folder / camera / name, frame.image());
      } else {
        write_png_grey(folder / camera / name, frame.image());
      }
      const double exposed_s = scene.mid_exposure_s(frame.sequence);
      frames_csv.line(camera + "," + std::to_string(tick) + "," + std::to_string(frame.sequence) + "," +
                      std::to_string(std::llround(exposed_s * 1e9)));
    }
    scene.truth(tick, truth);
    for (std::uint32_t m = 0; m < scene.markers(); ++m) {
      truth_csv.line(truth_line(truth, m, bound.variance_m2(truth, m)));
    }
  }
  frames_csv.finish();
  truth_csv.finish();

  const SourceCounters counters = source.counters();
  std::printf(
      "%s: %llu frame sets of %u cameras at %g Hz, %llu frames (%llu missing, %llu late, %llu duplicated)\n",
      a.out.c_str(), static_cast<unsigned long long>(ticks), options.cameras, options.rate_hz,
      static_cast<unsigned long long>(counters.frames), static_cast<unsigned long long>(counters.missing),
      static_cast<unsigned long long>(counters.late), static_cast<unsigned long long>(counters.duplicated));
}

void run(const SimCommandArguments& a) {
  if (a.out.empty() && a.rig_out.empty())
    throw UsageError("glint sim: give --out DIR, --rig-out FILE or both");
  if (!(a.seconds > 0.0 && a.seconds <= 1e6))
    throw UsageError("--seconds must be above 0 and at most 1000000");
  const SimOptions options = checked_sim_options(a.sim);
  const Scene scene(options);
  if (!a.out.empty()) write_recording(a, options, scene);
  if (!a.rig_out.empty()) {
    write_calibration(a.rig_out, told_calibration(a.sim, scene.calibration()), a.force);
    std::printf("%s: calibration of the simulated rig\n", a.rig_out.c_str());
  }
}

}  // namespace

void add_sim(CLI::App& app) {
  CLI::App* command = app.add_subcommand("sim", "write a recording of the simulated rig with its truth");
  const auto a = std::make_shared<SimCommandArguments>();
  command->add_option("--out", a->out, "folder for images, calibration.toml, frames.csv and truth.csv")
      ->type_name("DIR");
  command->add_option("--rig-out", a->rig_out, "write the rig's calibration to this file")->type_name("FILE");
  command->add_option("--seconds", a->seconds, "length of the recording")->capture_default_str();
  command->add_option("--rate", a->sim.options.rate_hz, "frame sets per second")->capture_default_str();
  command->add_option("--format", a->format, "pgm or png")
      ->check(CLI::IsMember({"pgm", "png"}))
      ->capture_default_str();
  command->add_flag("--force", a->force, "overwrite an earlier recording");
  add_sim_options(*command, a->sim);
  command->callback([a] { run(*a); });
}

}  // namespace glint::apps
