// SPDX-License-Identifier: MIT
// Joins the clocks of the cameras, the grid of pulses and the window of open sets.
#include "host/assemble/assembler.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "gpu/detector.hpp"
#include "host/assemble/camera_clock.hpp"
#include "host/assemble/pulse_grid.hpp"
#include "host/assemble/set_window.hpp"
#include "host/base/check.hpp"
#include "host/base/error.hpp"

namespace glint {
namespace {

constexpr std::size_t kUnplacedInARow = 12;  // and a camera's clock is fitted anew
constexpr double kAlignedPhase = 1.0 / 20;   // of the period, standard deviation of the grid
constexpr double kLostPhase = 1.0 / 10;      // and the grid is fitted anew
// Stamps that are rounded up lie behind the truth by half the step, which is 1.7 of their standard
// deviations.
constexpr double kBias = 2.0;
constexpr double kOldestPeriods = 2.0;   // age of a set at which we are behind
constexpr double kLeastVariance = 1e-6;  // of a stamp, in periods squared
constexpr std::uint64_t kLargestTrigger = std::uint64_t{1} << 62;
constexpr double kDefaultDeadlinePeriods = 0.5;
// A silent camera is waited for until another has delivered so many frames.
constexpr std::size_t kWarmUpFrames = 2 * CameraClock::kStamps;

AssembleOptions checked(const AssembleOptions& options, std::size_t cameras) {
  std::vector<std::string> problems;
  options.check(problems);
  if (cameras == 0 || cameras > gpu::kMaxCameras) {
    problems.push_back("1 to " + std::to_string(gpu::kMaxCameras) + " cameras are possible, not " +
                       std::to_string(cameras));
  }
  std::string text;
  for (const std::string& problem : problems) text += (text.empty() ? "" : "; ") + problem;
  if (!text.empty()) throw UsageError(text);
  return options;
}

}  // namespace

void AssembleOptions::check(std::vector<std::string>& problems) const {
  if (!(rate_hz > 0.0 && rate_hz <= 10'000.0))
    problems.emplace_back("assemble.rate_hz must be > 0 and <= 10000");
  if (exposure_s < 0.0) problems.emplace_back("assemble.exposure_s must be >= 0");
  if (readout_s && *readout_s < 0.0) problems.emplace_back("assemble.readout_s must be >= 0");
  if (most_sets_waiting < 2 || most_sets_waiting > 128) {
    problems.emplace_back("assemble.most_sets_waiting must be 2 to 128");
  }
  const double wait_s = deadline_s.value_or(kDefaultDeadlinePeriods / rate_hz);
  if (!(wait_s >= 0.0)) problems.emplace_back("assemble.deadline_s must be >= 0");
  if (wait_s * rate_hz + 1.0 > static_cast<double>(most_sets_waiting)) {
    problems.emplace_back("assemble.deadline_s is longer than assemble.most_sets_waiting - 1 periods");
  }
}

struct Assembler::Impl {
  struct Camera {
    explicit Camera(double period_s) : clock(period_s) {}
    CameraClock clock;
    StampPoint stamp = StampPoint::HostArrival;
    bool present = true;
    bool heard = false;  // has ever delivered
    std::uint32_t run = 0;
    int shifted = 0;
    bool waited_for() const noexcept { return present && clock.locked(); }
    bool fits(const PulseGrid& grid) const noexcept {
      return clock.locked() && clock.scatter_s() < CameraClock::kMostScatter * grid.period_s();
    }
  };

  Impl(std::size_t count, const AssembleOptions& given)
      : options(checked(given, count)),
        period_s(1.0 / options.rate_hz),
        deadline_s(options.deadline_s.value_or(kDefaultDeadlinePeriods * period_s)),
        grid(period_s),
        window(count, options.most_sets_waiting) {
    cameras.assign(count, Camera(period_s));
  }

  std::int64_t since_origin_ns(Timestamp time) const noexcept {
    // Unsigned: stamps may be anywhere.
    return static_cast<std::int64_t>(static_cast<std::uint64_t>(time.time_since_epoch().count()) -
                                     static_cast<std::uint64_t>(origin->time_since_epoch().count()));
  }
  double seconds(Timestamp time) const noexcept { return 1e-9 * static_cast<double>(since_origin_ns(time)); }
  Timestamp timestamp(double seconds) const noexcept {
    return *origin + std::chrono::nanoseconds(static_cast<std::int64_t>(std::ceil(seconds * 1e9)));
  }

  void add(Frame frame, Timestamp arrived) noexcept;
  void collect(Camera& camera, CameraId id, const FrameStamp& stamp) noexcept;
  bool ready_to_start() noexcept;
  void start() noexcept;
  void start_grid() noexcept;
  void lock(Camera& camera) noexcept;
  void centre_offsets() noexcept;
  void fit_anew() noexcept;
  bool nobody_fits() const noexcept;
  double usual_offset_s(const Camera& camera) const noexcept;
  double usual_latency_s(const Camera& camera) const noexcept;

  std::optional<double> missing_until_s(std::int64_t pulse) const noexcept;
  bool can_go(std::int64_t pulse, double now_s) const noexcept;
  bool is_old(std::int64_t pulse, double now_s) const noexcept;
  bool newer_can_go(double now_s) const noexcept;
  std::optional<double> middle_before_stamp_s(const Camera& camera) const noexcept;
  Timestamp exposed(std::int64_t pulse) noexcept;

  AssembleOptions options;
  double period_s, deadline_s;
  std::optional<Timestamp> origin;  // of all times in seconds: the first that is seen
  std::vector<Camera> cameras;
  PulseGrid grid;
  std::optional<PulseGrid> grid_before;  // while the grid is fitted anew
  SetWindow window;
  bool started = false;   // the grid is known, and some camera's place on it
  bool counting = false;  // pulses have numbers
  std::optional<Timestamp> last_exposed;
};

double Assembler::Impl::usual_latency_s(const Camera& camera) const noexcept {
  if (camera.clock.latency_known()) return camera.clock.latency_s();
  double sum = 0.0, known = 0.0;
  for (const Camera& other : cameras) {
    if (!other.clock.latency_known()) continue;
    sum += other.clock.latency_s();
    known += 1.0;
  }
  return known > 0.0 ? sum / known : 0.0;
}

/// Stamp minus pulse, to half a period: with a fitted grid pulses are where the stamps are.
double Assembler::Impl::usual_offset_s(const Camera& camera) const noexcept {
  if (!grid.reported()) return 0.0;
  switch (camera.stamp) {
    case StampPoint::StartOfExposure:
      return 0.0;
    case StampPoint::MiddleOfExposure:
      return 0.5 * options.exposure_s;
    case StampPoint::EndOfFrame:
    case StampPoint::HostArrival:
      break;
  }
  // A camera at full rate reads out while it exposes the next frame: within a period.
  return options.readout_s ? options.exposure_s + *options.readout_s : 0.5 * grid.period_s();
}

void Assembler::Impl::add(Frame frame, Timestamp arrived) noexcept {
  GLINT_CHECK(index(frame.camera) < cameras.size());
  if (!origin) origin = arrived;
  Camera& camera = cameras[index(frame.camera)];
  camera.present = camera.heard = true;
  camera.stamp = frame.stamp;
  const FrameStamp stamp{since_origin_ns(frame.stamped), seconds(arrived), frame.sequence};
  if (started && !grid.reported() &&
      std::sqrt(grid.variance_s2(grid.nearest(stamp.arrived_s))) > kLostPhase * period_s) {
    fit_anew();  // nobody delivered for a minute or more
  }
  if (!camera.clock.locked()) {
    collect(camera, frame.camera, stamp);
    return;
  }
  const std::optional<Placement> placement = camera.clock.place(grid, stamp);
  if (!placement) {
    window.count_unplaced(frame.camera);
    if (camera.clock.unplaced() >= kUnplacedInARow) camera.clock.unlock();
    if (nobody_fits()) fit_anew();
    return;
  }
  const CameraId id = frame.camera;
  const bool whole = !frame.damaged;
  if (!placement->regular) ++camera.run;
  frame.run = camera.run;
  frame.shifted = camera.shifted;
  if (placement->out_of_order) window.came_after_all(id, placement->pulse);
  const bool news = window.put(placement->pulse, std::move(frame), arrived);
  if (placement->lost_by_host > 0) {
    window.lost_by_host(id, placement->after, placement->pulse, placement->lost_by_host);
  }
  if (!news || !whole) return;
  camera.clock.learn(grid, *placement, stamp.arrived_s);
  centre_offsets();
}

void Assembler::Impl::collect(Camera& camera, CameraId id, const FrameStamp& stamp) noexcept {
  if (counting) {
    window.count_unplaced(id);
  } else {
    window.count_warm_up(id);
  }
  camera.clock.collect(stamp, usual_latency_s(camera));
  if (!started) {
    if (ready_to_start()) start();
  } else if (camera.clock.ready(grid)) {
    lock(camera);
    centre_offsets();
  }
}

bool Assembler::Impl::ready_to_start() noexcept {
  if (!grid.reported()) grid.start(0, seconds(*origin), 0.0);  // any phase will do to see scatter
  bool all = true, any = false, patience_over = false;
  for (const Camera& camera : cameras) {
    const bool ready = camera.clock.ready(grid);
    any = any || ready;
    all = all && (ready || !camera.present);
    patience_over = patience_over || camera.clock.collected() >= kWarmUpFrames;
  }
  return any && (all || patience_over);
}

void Assembler::Impl::lock(Camera& camera) noexcept {
  camera.clock.lock(grid, usual_offset_s(camera));
  ++camera.run;
}

/// Finds the grid's phase and the pulse with which counting begins, or goes on.
void Assembler::Impl::start() noexcept {
  if (!grid.reported()) start_grid();
  std::int64_t first = 0;
  for (Camera& camera : cameras) {
    if (!camera.clock.ready(grid)) continue;
    lock(camera);
    camera.clock.count_from(grid);
    first = std::max(first, camera.clock.newest_collected(grid) + 1);
  }
  if (!counting) window.begin(first);
  started = counting = true;
  grid_before.reset();
  centre_offsets();
}

/// Pulses are where the cameras' mean stamps are, numbered so that the first that is counted follows all
/// frames seen so far.
void Assembler::Impl::start_grid() noexcept {
  const double radians = 2.0 * std::numbers::pi / period_s;
  double x = 0.0, y = 0.0, variance = 0.0, middle = 0.0, count = 0.0;
  for (const Camera& camera : cameras) {
    if (!camera.clock.ready(grid)) continue;
    const CameraClock::Phase phase = camera.clock.phase(grid);
    x += std::cos(radians * phase.mean_s);
    y += std::sin(radians * phase.mean_s);
    variance += phase.scatter_s * phase.scatter_s + kLeastVariance * period_s * period_s;
    middle += camera.clock.middle_s();
    count += 1.0;
  }
  const double time = grid.time_s(grid.nearest(middle / count)) + std::atan2(y, x) / radians;
  variance /= count * count * static_cast<double>(CameraClock::kStamps);
  grid.start(0, time, variance);
  std::int64_t newest = 0;
  for (Camera& camera : cameras) {
    if (!camera.clock.ready(grid)) continue;
    lock(camera);
    newest = std::max(newest, camera.clock.newest_collected(grid));
  }
  std::int64_t next = 0;
  // Goes on by the clock: a pulse that nobody saw meanwhile is one too.
  if (grid_before) next = std::max(window.newest() + 1, grid_before->nearest(grid.time_s(newest + 1)));
  grid.start(next - newest - 1, time, variance);
}

/// A fitted grid lies in the mean of the cameras' stamps; else grid and offsets could drift apart together.
void Assembler::Impl::centre_offsets() noexcept {
  if (grid.reported()) return;
  double sum = 0.0, count = 0.0;
  for (const Camera& camera : cameras) {
    if (!camera.clock.locked()) continue;
    sum += camera.clock.offset_s() - camera.clock.shifted_s(grid);
    count += 1.0;
  }
  if (count == 0.0) return;
  for (Camera& camera : cameras) camera.clock.move(-sum / count);
  grid.move(sum / count);
}

bool Assembler::Impl::nobody_fits() const noexcept {
  return std::none_of(cameras.begin(), cameras.end(),
                      [](const Camera& camera) { return camera.waited_for(); });
}

void Assembler::Impl::fit_anew() noexcept {
  for (Camera& camera : cameras) camera.clock.unlock();
  if (!grid.reported() && started) grid_before = grid;
  started = false;
}

/// Until when the pulse's set waits for a camera; nothing if it has all.
std::optional<double> Assembler::Impl::missing_until_s(std::int64_t pulse) const noexcept {
  std::optional<double> until;
  for (std::size_t k = 0; k < cameras.size(); ++k) {
    if (!cameras[k].waited_for() || !window.lacks(pulse, CameraId{static_cast<std::uint8_t>(k)})) continue;
    until = std::max(until.value_or(-1e300), cameras[k].clock.expected_s(grid, pulse) + deadline_s);
  }
  return until;
}

bool Assembler::Impl::can_go(std::int64_t pulse, double now_s) const noexcept {
  return now_s >= missing_until_s(pulse).value_or(-1e300);
}

/// Older than two periods, reckoned from when its last frame should have been here.
bool Assembler::Impl::is_old(std::int64_t pulse, double now_s) const noexcept {
  double expected = -1e300;
  for (const Camera& camera : cameras) {
    if (camera.waited_for()) expected = std::max(expected, camera.clock.expected_s(grid, pulse));
  }
  return now_s - expected > std::max(kOldestPeriods * period_s, deadline_s + period_s);
}

bool Assembler::Impl::newer_can_go(double now_s) const noexcept {
  for (std::int64_t pulse = window.head() + 1; pulse <= window.newest() && can_go(pulse, now_s); ++pulse) {
    if (window.has_frames(pulse) && !grid.dark(pulse)) return true;
  }
  return false;
}

/// From the stamp back to the middle of the exposure; nothing if that is not known.
std::optional<double> Assembler::Impl::middle_before_stamp_s(const Camera& camera) const noexcept {
  if (camera.clock.foreign()) return std::nullopt;
  switch (camera.stamp) {
    case StampPoint::StartOfExposure:
      return -0.5 * options.exposure_s;
    case StampPoint::MiddleOfExposure:
      return 0.0;
    case StampPoint::EndOfFrame:
    case StampPoint::HostArrival:
      break;
  }
  if (!options.readout_s) return std::nullopt;
  return *options.readout_s + 0.5 * options.exposure_s;
}

Timestamp Assembler::Impl::exposed(std::int64_t pulse) noexcept {
  double middle = 0.5 * options.exposure_s;
  if (!grid.reported()) {
    double sum = 0.0, count = 0.0;
    for (const Camera& camera : cameras) {
      if (!camera.clock.locked()) continue;
      sum += middle_before_stamp_s(camera).value_or(0.5 * options.exposure_s);
      count += 1.0;
    }
    middle = count > 0.0 ? -sum / count : 0.0;
  }
  Timestamp time = timestamp(grid.time_s(pulse) + middle);
  // The fit may move back a little; time never does.
  if (last_exposed && time <= *last_exposed) time = *last_exposed + std::chrono::nanoseconds(1);
  last_exposed = time;
  return time;
}

Assembler::Assembler(std::size_t cameras, const AssembleOptions& options)
    : impl_(std::make_unique<Impl>(cameras, options)) {}
Assembler::~Assembler() = default;

void Assembler::add(Frame frame, Timestamp arrived) noexcept { impl_->add(std::move(frame), arrived); }

void Assembler::set_present(CameraId camera, bool present) noexcept {
  GLINT_CHECK(index(camera) < impl_->cameras.size());
  Impl::Camera& it = impl_->cameras[index(camera)];
  it.present = present;
  if (!present) ++it.run;
}

void Assembler::add_pulse(TriggerNo trigger, Timestamp fired, bool lights_on) noexcept {
  Impl& my = *impl_;
  if (number(trigger) > kLargestTrigger) return;  // no board counts so far
  if (!my.origin) my.origin = fired;
  const auto pulse = static_cast<std::int64_t>(number(trigger));
  if (my.grid.add_reported(pulse, my.seconds(fired), lights_on)) {
    if (my.started) my.window.extend(pulse);
    return;
  }
  // Numbered anew: what is open has numbers of the old count.
  while (my.window.open()) my.window.retire(FrameFate::Skipped, nullptr);
  my.fit_anew();
  for (Impl::Camera& camera : my.cameras) camera.clock.forget_numbers();
  my.grid_before.reset();
  my.counting = false;
}

void Assembler::shift(CameraId camera, int pulses) noexcept {
  GLINT_CHECK(index(camera) < impl_->cameras.size());
  if (pulses == 0) return;
  impl_->window.drop_held(camera);
  Impl::Camera& it = impl_->cameras[index(camera)];
  it.clock.shift(impl_->grid, pulses);
  it.shifted += pulses;
  ++it.run;
}

bool Assembler::next(FrameSet& set, Timestamp now) noexcept {
  for (std::optional<Frame>& frame : set.frames) frame.reset();
  Impl& my = *impl_;
  if (!my.origin) return false;
  const double now_s = my.seconds(now);
  bool behind = false;
  while (my.window.open() && my.can_go(my.window.head(), now_s)) {
    const std::int64_t pulse = my.window.head();
    const bool dark = my.grid.dark(pulse);
    if (!my.window.has_frames(pulse)) {
      my.window.retire(FrameFate::Dark, nullptr);
      continue;
    }
    behind = behind || my.is_old(pulse, now_s);
    if (behind && my.newer_can_go(now_s)) {
      my.window.retire(dark ? FrameFate::Dark : FrameFate::Skipped, nullptr);
      continue;
    }
    my.window.retire(dark ? FrameFate::Dark : FrameFate::Used, &set);
    set.dark = dark;
    set.trigger = TriggerNo{static_cast<std::uint64_t>(pulse)};
    set.exposed = my.exposed(pulse);
    return true;
  }
  return false;
}

std::optional<Timestamp> Assembler::due() const noexcept {
  const Impl& my = *impl_;
  if (!my.window.open()) return std::nullopt;
  const std::optional<double> until = my.missing_until_s(my.window.head());
  return until ? my.timestamp(*until) : *my.origin;
}

const Ledger& Assembler::ledger() const noexcept { return impl_->window.ledger(); }

bool Assembler::aligned() const noexcept {
  const Impl& my = *impl_;
  if (!my.started) return false;
  for (const Impl::Camera& camera : my.cameras) {
    if (camera.present && camera.heard && !camera.fits(my.grid)) return false;
  }
  return std::sqrt(my.grid.variance_s2(my.window.newest())) < kAlignedPhase * my.period_s;
}

bool Assembler::aligned(CameraId camera) const noexcept {
  GLINT_CHECK(index(camera) < impl_->cameras.size());
  return impl_->started && impl_->cameras[index(camera)].fits(impl_->grid);
}

double Assembler::exposed_error_s() const noexcept {
  const Impl& my = *impl_;
  if (my.grid.reported()) return 0.0;
  double least = 1e300, most = -1e300, scatter = 0.0, unknown = 0.0;
  for (const Impl::Camera& camera : my.cameras) {
    if (!camera.clock.locked()) continue;
    const std::optional<double> before = my.middle_before_stamp_s(camera);
    if (!before) unknown = my.period_s;
    const double middle = camera.clock.offset_s() - camera.clock.shifted_s(my.grid) - before.value_or(0.0);
    least = std::min(least, middle);
    most = std::max(most, middle);
    scatter = std::max(scatter, camera.clock.scatter_s());
  }
  if (least > most) return my.period_s;
  const double fit = 3.0 * std::sqrt(my.grid.variance_s2(my.window.newest()));
  return fit + kBias * scatter + 0.5 * (most - least) + unknown;
}

double Assembler::period_s() const noexcept { return impl_->grid.period_s(); }

}  // namespace glint
