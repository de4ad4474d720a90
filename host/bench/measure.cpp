// SPDX-License-Identifier: MIT
// The measuring loops.
#include "host/bench/measure.hpp"

#include <time.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <limits>
#include <thread>

#include "host/base/error.hpp"
#include "host/base/ids.hpp"

namespace glint::bench {
namespace {

using Clock = std::chrono::steady_clock;

Clock::duration duration(double seconds) {
  return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
}

std::vector<double> first(const std::vector<double>& values, std::size_t count) {
  return {values.begin(), values.begin() + static_cast<std::ptrdiff_t>(count)};
}

}  // namespace

Drive::Drive(const Scene& scene, const Expected& expected, gpu::Detector& detector, unsigned cameras)
    : detector_(detector) {
  for (unsigned tick = 0; tick < scene.options().ticks; ++tick) {
    images_.push_back(scene.images(tick));
    images_.back().resize(cameras);
    found_.push_back(expected.found(tick, cameras));
  }
}

bool Drive::submit() noexcept {
  broken_ = broken_ || detector_.submit(images_[submitted_ % images_.size()]) != gpu::RunStatus::Ok;
  if (!broken_) ++submitted_;
  return !broken_;
}

bool Drive::collect() noexcept {
  broken_ = broken_ || detector_.collect(batch_) != gpu::RunStatus::Ok;
  if (broken_) return false;
  std::size_t found = 0;
  for (const gpu::CameraBlobs& camera : batch_.cameras) found += camera.found;
  if (found != found_[collected_ % found_.size()]) ++wrong_;
  ++collected_;
  return true;
}

bool Drive::drain() noexcept {
  while (collected_ < submitted_) {
    if (!collect()) return false;
  }
  return true;
}

Outcome Drive::outcome() const noexcept {
  return broken_ ? Outcome::Failed : wrong_ > 0 ? Outcome::Wrong : Outcome::Ok;
}

std::string Drive::problem() const {
  if (broken_) return "it broke down: " + detector_.last_error();
  if (wrong_ == 0) return "";
  return "while it was timed, " + std::to_string(wrong_) + " of " + std::to_string(collected_) +
         " ticks had another number of blobs than the reference finds";
}

StageLog::StageLog(std::size_t most_ticks)
    : most_ticks_(most_ticks),
      names_(kMostStages),
      seconds_(kMostStages * most_ticks, std::numeric_limits<double>::quiet_NaN()) {
  for (std::string& name : names_) name.reserve(kLongestName);
}

void StageLog::add(std::size_t tick, const std::vector<gpu::StageTime>& stages) noexcept {
  for (const gpu::StageTime& stage : stages) {
    const std::string_view name = std::string_view(stage.name).substr(0, kLongestName);
    const auto end = names_.begin() + static_cast<std::ptrdiff_t>(used_);
    const auto at = static_cast<std::size_t>(std::find(names_.begin(), end, name) - names_.begin());
    if (at == kMostStages) {
      full_ = true;
      continue;
    }
    if (at == used_) names_[used_++] = name;
    double& seconds = seconds_[at * most_ticks_ + tick];
    seconds = std::isnan(seconds) ? stage.seconds : seconds + stage.seconds;
  }
}

std::vector<StageSeries> StageLog::series() const {
  if (full_) throw Error("the detector has more than " + std::to_string(kMostStages) + " stages");
  std::vector<StageSeries> all;
  for (std::size_t s = 0; s < used_; ++s) {
    std::vector<double> ran;
    ran.reserve(most_ticks_);
    for (std::size_t t = 0; t < most_ticks_; ++t) {
      if (const double seconds = seconds_[s * most_ticks_ + t]; !std::isnan(seconds)) ran.push_back(seconds);
    }
    all.push_back({names_[s], make_series(std::move(ran))});
  }
  return all;
}

double process_cpu_s() noexcept {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

void warm_up(Drive& drive, const Conditions& conditions) {
  const Timestamp end = Clock::now() + duration(conditions.max_time_s);
  for (unsigned n = 0; n < conditions.warm_up; ++n) {
    if (!drive.tick() || Clock::now() >= end) return;
  }
}

void measure_latency(Drive& drive, const Conditions& conditions, Row& row) {
  std::vector<double> wall(conditions.ticks), cpu(conditions.ticks);
  StageLog stages(conditions.ticks);
  std::size_t count = 0;
  const Timestamp end = Clock::now() + duration(conditions.max_time_s);
  for (Timestamp now{}; count < conditions.ticks && now < end; ++count) {
    const double cpu_before = process_cpu_s();
    const Timestamp submitted = Clock::now();
    if (!drive.tick()) return;
    now = Clock::now();
    cpu[count] = process_cpu_s() - cpu_before;
    wall[count] = seconds_between(submitted, now);
    stages.add(count, drive.batch().stages);
  }
  row.wall = make_series(first(wall, count));
  row.cpu = make_series(first(cpu, count));
  row.stages = stages.series();
}

void measure_throughput(Drive& drive, const Conditions& conditions, Row& row) {
  row.depth = conditions.depth;
  for (unsigned n = 0; n < conditions.depth; ++n) {
    if (!drive.submit()) return;
  }
  std::vector<double> intervals(conditions.ticks);
  std::size_t count = 0;
  const Timestamp end = Clock::now() + duration(conditions.max_time_s);
  if (!drive.collect() || !drive.submit()) return;
  const Timestamp began = Clock::now();
  Timestamp before = began;
  for (; count < conditions.ticks && before < end; ++count) {
    if (!drive.collect()) return;
    const Timestamp now = Clock::now();
    intervals[count] = seconds_between(before, now);
    before = now;
    if (!drive.submit()) return;
  }
  if (!drive.drain() || count == 0) return;
  row.ticks_per_s = static_cast<double>(count) / seconds_between(began, before);
  row.interval = make_series(first(intervals, count));
}

Paced measure_pace(Drive& drive, const Conditions& conditions, std::size_t most_late) {
  Paced paced;
  paced.rate_hz = conditions.rate_hz;
  std::vector<double> latency(conditions.ticks);
  const double period_s = 1.0 / conditions.rate_hz;
  const Clock::duration period = duration(period_s);
  std::size_t count = 0, late = 0;
  const Timestamp began = Clock::now() + std::chrono::milliseconds(1),
                  end = began + duration(conditions.max_time_s);
  Timestamp due = began;
  for (Timestamp now{}; count < conditions.ticks && now < end && late <= most_late; ++count, due += period) {
    std::this_thread::sleep_until(due);  // not at all if it is past: a late tick does not move the schedule
    const Timestamp submitted = Clock::now();
    if (!drive.tick()) return paced;
    now = Clock::now();
    latency[count] = seconds_between(submitted, now);
    if (latency[count] >= period_s) ++late;
    if (now > due + period) ++paced.missed;
  }
  paced.latency = make_series(first(latency, count));
  return paced;
}

}  // namespace glint::bench
