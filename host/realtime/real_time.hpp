// SPDX-License-Identifier: MIT
// Scheduling ahead of other programs, memory that stays in memory, threads on chosen CPUs: for live cameras,
// whose frames do not wait.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "host/realtime/scheduler_calls.hpp"

namespace glint {

/// The threads that are favoured, most urgent first. Never a Vulkan driver's own threads (lavapipe's would
/// take all CPUs) nor the output, which may block.
enum class ThreadRole : std::uint8_t {
  Camera,    ///< one for each: what it does not fetch in time is lost
  Assembly,  ///< pairs frames
  Tracking,  ///< detection, matching, tracks
};
inline constexpr std::size_t kThreadRoles = 3;

/// Low, so that interrupt threads (50) and the kernel's own stay ahead.
constexpr int fifo_priority(ThreadRole role) noexcept { return 12 - static_cast<int>(role); }

enum class RealTimeMode : std::uint8_t {
  Off,
  Auto,     ///< takes what is permitted, and says what is not
  Require,  ///< refuses to run without
};

struct RealTimeOptions {
  RealTimeMode mode = RealTimeMode::Off;
  std::vector<unsigned> cpus;  ///< favoured threads run on these only; empty: on all
};

/// What a process may do of it, and how to get the rest.
struct RealTimePermission {
  std::string fifo_refusal;  ///< "" if SCHED_FIFO is permitted at all priorities of the roles
  std::string lock_refusal;  ///< "" if all memory may be locked
};

/// Asks by trying SCHED_FIFO in a short-lived thread. Nothing stays changed.
RealTimePermission real_time_permission(SchedulerCalls& calls);

/// The line in /etc/security/limits.d that permits all of it.
inline constexpr std::string_view kLimitsAdvice =
    "put \"@video - rtprio 20\" and \"@video - memlock unlimited\" into /etc/security/limits.d/glint.conf, "
    "have your user in the group video, and log in again";

/// What a run got.
struct RealTimeState {
  RealTimeMode mode = RealTimeMode::Off;
  /// How many threads of each role asked (a camera's thread does so again when it is started again), and how
  /// many of them got SCHED_FIFO and, where CPUs are given, their CPUs.
  std::array<std::uint32_t, kThreadRoles> threads{}, fifo{}, pinned{};
  bool memory_locked = false;
  std::vector<unsigned> cpus;
  std::string refusal;  ///< what was refused, in a line; "" if nothing
};

/// Made before the first camera thread; outlives all threads that enter().
class RealTime {
 public:
  /// Throws UsageError that names a CPU which is not there, and Error where mode is Require and something is
  /// not permitted.
  RealTime(RealTimeOptions options, std::shared_ptr<SchedulerCalls> calls);

  /// Locks all memory; once what the run needs has been made, so that the limit is known to suffice. Throws
  /// Error where mode is Require.
  void lock_memory();
  /// The calling thread takes its place, and makes the pages of its stack exist. Allocates nothing.
  void enter(ThreadRole role) noexcept;

  /// Any thread.
  RealTimeState state() const;

 private:
  void refuse(const std::string& what);

  RealTimeOptions options_;
  std::shared_ptr<SchedulerCalls> calls_;
  RealTimePermission permission_;
  bool memory_locked_ = false;
  std::string refusal_;
  std::array<std::atomic<std::uint32_t>, kThreadRoles> threads_{}, fifo_{}, pinned_{};
};

/// "SCHED_FIFO 12 cameras, 11 frame sets, 10 tracking; memory locked; on CPUs 2-3", or what of it there is.
std::string text_of(const RealTimeState& state);
std::string_view name_of(RealTimeMode mode) noexcept;
std::string_view name_of(ThreadRole role) noexcept;

}  // namespace glint
