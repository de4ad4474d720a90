// SPDX-License-Identifier: MIT
// Computers of several kinds.
#include "host/doctor/machine_checks.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include "tests/support/temp_dir.hpp"
#include "tests/unit/realtime/fake_scheduler.hpp"

namespace glint {
namespace {

using test::FakeScheduler;
using test::TempDir;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

gpu::DeviceInfo device(const char* name, bool software, bool usable = true) {
  gpu::DeviceInfo info;
  info.name = name;
  info.software = software;
  info.usable = usable;
  info.imports_host_memory = software;
  if (!usable) info.why_not_usable = "is too old";
  return info;
}

TEST(VulkanCheck, AGpuIsBestSoftwareWillDo) {
  const Finding both = check_vulkan({device("llvmpipe", true), device("Radeon", false)}, "");
  EXPECT_EQ(both.verdict, Verdict::Ok);
  EXPECT_EQ(both.text, "Radeon, frames are copied to it");
  const Finding software = check_vulkan({device("llvmpipe", true), device("Old", false, false)}, "");
  EXPECT_EQ(software.verdict, Verdict::Warning);
  EXPECT_THAT(software.text, HasSubstr("llvmpipe, reads frames in place"));
  EXPECT_THAT(software.advice, HasSubstr("Old: is too old"));
}

TEST(VulkanCheck, NoneIsNoProblem) {
  const Finding finding = check_vulkan({}, "no driver is installed");
  EXPECT_EQ(finding.verdict, Verdict::Warning);
  EXPECT_THAT(finding.text, HasSubstr("no driver is installed"));
  EXPECT_THAT(finding.advice, HasSubstr("--device cpu"));
}

TEST(LimitsCheck, SaysWhatIsRefusedAndHowToGetIt) {
  FakeScheduler scheduler;
  for (const Finding& finding : check_limits(scheduler))
    EXPECT_EQ(finding.verdict, Verdict::Ok) << finding.text;
  scheduler.highest_priority = 0;
  scheduler.lock_limit = std::uint64_t{8} << 20;
  const Findings findings = check_limits(scheduler);
  ASSERT_EQ(findings.size(), 2u);
  for (const Finding& finding : findings) {
    EXPECT_EQ(finding.verdict, Verdict::Warning);
    EXPECT_THAT(finding.advice, HasSubstr("/etc/security/limits.d"));
  }
  EXPECT_EQ(scheduler.locks, 0) << "asking must not change anything";
}

TEST(ProcessorCheck, GovernorsAndIsolatedOnes) {
  FakeScheduler scheduler;
  TempDir sys;
  EXPECT_EQ(check_processors(sys.path(), scheduler).at(0).verdict, Verdict::Ok)
      << "a virtual machine tells nothing";
  const std::string folder = "devices/system/cpu/";
  for (const char* cpu : {"cpu0", "cpu1"})
    sys.write(folder + cpu + "/cpufreq/scaling_governor", "performance\n");
  sys.write(folder + "isolated", "\n");
  EXPECT_THAT(check_processors(sys.path(), scheduler).at(0).text, HasSubstr("performance"));
  EXPECT_THAT(check_processors(sys.path(), scheduler).at(1).text,
              HasSubstr("0-3 can be used, isolated: none"));
  for (const char* cpu : {"cpu2", "cpu3"})
    sys.write(folder + cpu + "/cpufreq/scaling_governor", "powersave\n");
  sys.write(folder + "isolated", "2-3\n");
  const Findings findings = check_processors(sys.path(), scheduler);
  EXPECT_EQ(findings.at(0).verdict, Verdict::Warning);
  EXPECT_EQ(findings.at(0).text, "powersave on 2-3");
  EXPECT_THAT(findings.at(1).advice, HasSubstr("--pin 2-3"));
}

TEST(ClockCheck, SlowClocksAndForeignStamps) {
  TempDir sys;
  EXPECT_EQ(check_clocks(sys.path()).at(0).verdict, Verdict::Ok);
  const std::string clock = "devices/system/clocksource/clocksource0/current_clocksource";
  sys.write(clock, "tsc\n");
  sys.write("module/uvcvideo/parameters/clock", "CLOCK_MONOTONIC\n");
  ASSERT_EQ(check_clocks(sys.path()).size(), 1u);
  EXPECT_EQ(check_clocks(sys.path())[0].text, "clock source tsc");
  sys.write(clock, "hpet\n");
  sys.write("module/uvcvideo/parameters/clock", "CLOCK_REALTIME\n");
  const Findings findings = check_clocks(sys.path());
  ASSERT_EQ(findings.size(), 2u);
  EXPECT_EQ(findings[0].verdict, Verdict::Warning);
  EXPECT_THAT(findings[1].text, HasSubstr("CLOCK_REALTIME"));
}

TEST(HidCheck, IsToldOnlyWhereThereAreNodes) {
  TempDir dev;
  EXPECT_THAT(check_hid(dev.path()), IsEmpty());
  dev.write("hidraw0", "");
  const std::string closed = dev.write("hidraw1", "").string();
  ASSERT_EQ(chmod(closed.c_str(), 0), 0);
  const Findings findings = check_hid(dev.path());
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_EQ(findings[0].verdict, Verdict::Ok);
  // root may open everything
  EXPECT_THAT(findings[0].text, HasSubstr(geteuid() == 0 ? "2 of 2" : "1 of 2"));
}

}  // namespace
}  // namespace glint
