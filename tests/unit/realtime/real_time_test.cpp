// SPDX-License-Identifier: MIT
// What is asked of the kernel, and what is said when it refuses.
#include "host/realtime/real_time.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sched.h>

#include <cerrno>
#include <thread>

#include "host/base/error.hpp"
#include "tests/unit/realtime/fake_scheduler.hpp"

namespace glint {
namespace {

using test::FakeScheduler;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class Running : public ::testing::Test {
 protected:
  /// Priority that a thread of this role ends up with.
  int priority_of(RealTime& real_time, ThreadRole role) const {
    int priority = 0;
    std::thread([&] {
      real_time.enter(role);
      priority = calls_->fifo_here();
    }).join();
    return priority;
  }
  std::string refusal_of(const RealTimeOptions& options) const {
    try {
      RealTime(options, calls_).lock_memory();
    } catch (const UsageError& error) {
      return "usage: " + std::string(error.what());
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  }
  std::shared_ptr<FakeScheduler> calls_ = std::make_shared<FakeScheduler>();
};

TEST_F(Running, CamerasComeFirstThenFrameSetsThenTracking) {
  RealTime real_time({RealTimeMode::Auto, {2, 3}}, calls_);
  const int camera = priority_of(real_time, ThreadRole::Camera);
  const int assembly = priority_of(real_time, ThreadRole::Assembly);
  const int tracking = priority_of(real_time, ThreadRole::Tracking);
  EXPECT_GT(camera, assembly);
  EXPECT_GT(assembly, tracking);
  EXPECT_GT(tracking, 0);
  EXPECT_LT(camera, 50) << "interrupt threads must stay ahead";
  EXPECT_EQ(calls_->fifo_here(), 0) << "only threads that enter are favoured";
  EXPECT_THAT(calls_->pins, ElementsAre(ElementsAre(2, 3), ElementsAre(2, 3), ElementsAre(2, 3)));
  real_time.lock_memory();
  EXPECT_EQ(calls_->locks, 1);
  EXPECT_EQ(text_of(real_time.state()),
            "SCHED_FIFO 12 cameras, 11 frame sets, 10 tracking; memory locked; on CPUs 2-3");
  EXPECT_EQ(real_time.state().refusal, "");
}

TEST_F(Running, OffTouchesNothingButWhatIsPinned) {
  RealTime real_time({RealTimeMode::Off, {1}}, calls_);
  EXPECT_EQ(priority_of(real_time, ThreadRole::Camera), 0);
  real_time.lock_memory();
  EXPECT_EQ(calls_->locks, 0);
  EXPECT_THAT(calls_->pins, ElementsAre(ElementsAre(1)));
  EXPECT_EQ(text_of(real_time.state()), "off; on CPUs 1");
}

TEST_F(Running, ARefusalIsSaidAndTheRunGoesOn) {
  calls_->highest_priority = 0;
  calls_->lock_limit = std::uint64_t{8} << 20;
  RealTime real_time({RealTimeMode::Auto, {}}, calls_);
  EXPECT_EQ(priority_of(real_time, ThreadRole::Camera), 0);
  real_time.lock_memory();
  EXPECT_EQ(calls_->locks, 0) << "with a limit, later allocations would fail";
  const RealTimeState state = real_time.state();
  EXPECT_THAT(state.refusal, HasSubstr("SCHED_FIFO was refused (Operation not permitted)"));
  EXPECT_THAT(state.refusal, HasSubstr("the limit is 8192 KiB"));
  EXPECT_EQ(text_of(state), "usual scheduling of cameras; memory not locked");
  EXPECT_THAT(calls_->pins, IsEmpty());
}

TEST_F(Running, ALimitBelowTheCamerasPriorityIsARefusal) {
  calls_->highest_priority = fifo_priority(ThreadRole::Tracking);
  RealTime real_time({RealTimeMode::Auto, {}}, calls_);
  EXPECT_EQ(priority_of(real_time, ThreadRole::Tracking), 0)
      << "with tracking ahead of its cameras frames would be lost";
}

TEST_F(Running, RequireEndsTheRunAndSaysHow) {
  EXPECT_EQ(refusal_of({RealTimeMode::Require, {}}), "");
  calls_->highest_priority = 0;
  EXPECT_THAT(refusal_of({RealTimeMode::Require, {}}), HasSubstr("limits.d"));
  calls_->highest_priority = 99;
  calls_->lock_limit = 65536;
  EXPECT_THAT(refusal_of({RealTimeMode::Require, {}}), HasSubstr("64 KiB"));
  calls_->lock_limit.reset();
  calls_->lock_error = ENOMEM;
  EXPECT_THAT(refusal_of({RealTimeMode::Require, {}}), HasSubstr("Cannot allocate memory"));
  EXPECT_EQ(refusal_of({RealTimeMode::Auto, {}}), "");
}

TEST_F(Running, ACpuThatIsNotThereIsNamed) {
  const std::string text = refusal_of({RealTimeMode::Off, {3, 7}});
  EXPECT_THAT(text, HasSubstr("usage: --pin: CPU 7 is not there"));
  EXPECT_THAT(text, HasSubstr("it may use 0-3"));
}

TEST_F(Running, APinThatFailsShows) {
  calls_->pin_error = EINVAL;
  RealTime real_time({RealTimeMode::Off, {1}}, calls_);
  (void)priority_of(real_time, ThreadRole::Tracking);
  EXPECT_EQ(text_of(real_time.state()), "off; on CPUs 1; not pinned: tracking");
}

TEST(KernelScheduler, DoesWhatItSays) {
  KernelSchedulerCalls calls;
  const std::vector<unsigned> cpus = calls.usable_cpus();
  ASSERT_FALSE(cpus.empty());
  std::thread([&] {
    EXPECT_EQ(calls.pin({cpus.back()}), 0);
    EXPECT_THAT(calls.usable_cpus(), ElementsAre(cpus.back()));
    const int error = calls.set_fifo(1);
    if (error != 0) {
      EXPECT_EQ(error, EPERM);
      return;
    }
    EXPECT_EQ(sched_getscheduler(0), SCHED_FIFO | SCHED_RESET_ON_FORK);
    std::thread([] { EXPECT_EQ(sched_getscheduler(0), SCHED_OTHER); }).join();
  }).join();
  EXPECT_EQ(calls.usable_cpus(), cpus);
  EXPECT_EQ(calls.pin({1'000'000}), EINVAL);
}

}  // namespace
}  // namespace glint
