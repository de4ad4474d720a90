// SPDX-License-Identifier: MIT
// The whole text, as a person would paste it.
#include "host/bench/report_markdown.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/unit/bench/sample_results.hpp"

namespace glint::bench {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr const char* kWhole =
    R"(| glint bench | 2026-01-02T03:04:05Z                                                                |
|-------------|-------------------------------------------------------------------------------------|
| glint       | 0.1.0 (abc1234), shaders 00ff00ff00ff00ff                                           |
| processor   | Some "Fast" CPU, 8 logical cores, governor performance                              |
| system      | Debian GNU/Linux 12 (bookworm), Linux 6.1.0, x86_64                                 |
| device      | llvmpipe (software, no GPU): software, Vulkan 1.3.230, driver llvmpipe Mesa 22.3.6  |
| device      | Wrong GPU, fast: discrete, Vulkan 1.3.230, driver broken Mesa 22.3.6                |
| device      | cpu (8 threads, AVX2): the native detector, without Vulkan                          |
| run         | up to 500 ticks or 2 s after 50 to warm up; 2 in flight for ticks/s; paced at 90 Hz |
| note        | left out: Old GPU: its driver offers Vulkan 1.0                                     |

Most cameras of 1280x800 with 20 blobs each that a device keeps up with (paced, p99 from submit to result under the frame time):

| device                      | rate   | most cameras | p99 ms | frame time ms |
|-----------------------------|--------|--------------|-------:|--------------:|
| llvmpipe (software, no GPU) | 90 Hz  | 21           | 10.500 |          11.1 |
| llvmpipe (software, no GPU) | 250 Hz | not even 1   |        |           4.0 |
| Wrong GPU, fast             | 90 Hz  | **FAIL**     |        |               |
| cpu (8 threads, AVX2)       | 90 Hz  | 32 or more   |  1.500 |          11.1 |

Per tick, one at a time, from submit to result; CPU: time of the whole process (median):

| device                      | scene                             | correct   | p50 ms |   p90 |   p99 |   max | CPU ms | ticks/s | paced p99 ms |   missed |
|-----------------------------|-----------------------------------|-----------|-------:|------:|------:|------:|-------:|--------:|-------------:|---------:|
| llvmpipe (software, no GPU) | 4 x 1280x800, 0 blobs             | yes       |  0.500 | 0.540 | 0.549 | 0.550 |  0.750 |    2500 |        0.648 | 3 of 101 |
| llvmpipe (software, no GPU) | 4 x 1280x800, 20 blobs, noise 2.5 | yes       |  2.000 | 2.160 | 2.196 | 2.200 |  3.000 |     625 |        2.592 | 3 of 101 |
| Wrong GPU, fast             | 4 x 1280x800, 0 blobs             | **FAIL**  |        |       |       |       |        |         |              |          |
| Wrong GPU, fast             | 4 x 1280x800, 20 blobs, noise 2.5 | **FAIL**  |        |       |       |       |        |         |              |          |
| cpu (8 threads, AVX2)       | 4 x 1280x800, 0 blobs             | yes       |  0.050 | 0.054 | 0.055 | 0.055 |  0.075 |   25000 |        0.065 | 3 of 101 |
| cpu (8 threads, AVX2)       | 4 x 1280x800, 20 blobs, noise 2.5 | no result |        |       |       |       |        |         |              |          |

* FAIL: Wrong GPU, fast: 4 x 1280x800, 0 blobs: tick 0, camera 1, blob 3: sum is 7 instead of 8
* no result: cpu (8 threads, AVX2): 4 x 1280x800, 20 blobs, noise 2.5: it broke down: no memory

Stages of these ticks (Vulkan: time stamps of the device; cpu: wall time):

| device                      | scene                             | stage         | p50 ms |   p90 |   p99 |   max |
|-----------------------------|-----------------------------------|---------------|-------:|------:|------:|------:|
| llvmpipe (software, no GPU) | 4 x 1280x800, 0 blobs             | find \| tiles |  0.300 | 0.304 | 0.305 | 0.305 |
| llvmpipe (software, no GPU) | 4 x 1280x800, 0 blobs             | blobs         |  0.100 | 0.104 | 0.105 | 0.105 |
| llvmpipe (software, no GPU) | 4 x 1280x800, 20 blobs, noise 2.5 | find \| tiles |  1.200 | 1.216 | 1.220 | 1.220 |
| llvmpipe (software, no GPU) | 4 x 1280x800, 20 blobs, noise 2.5 | blobs         |  0.400 | 0.416 | 0.420 | 0.420 |
| cpu (8 threads, AVX2)       | 4 x 1280x800, 0 blobs             | find \| tiles |  0.030 | 0.030 | 0.030 | 0.030 |
| cpu (8 threads, AVX2)       | 4 x 1280x800, 0 blobs             | blobs         |  0.010 | 0.010 | 0.010 | 0.010 |
)";

TEST(ReportMarkdown, IsThisText) { EXPECT_EQ(to_markdown(test::sample_results()), kWhole); }

TEST(ReportMarkdown, NeverNamesASoftwareDeviceWithoutTheMark) {
  const std::string text = to_markdown(test::sample_results());
  const std::string marked = "llvmpipe (software, no GPU)";
  int named = 0;
  for (std::size_t at = text.find("llvmpipe"); at != std::string::npos; at = text.find("llvmpipe", at + 1)) {
    if (text.substr(at - 7, 7) == "driver ") continue;
    EXPECT_EQ(text.substr(at, marked.size()), marked);
    ++named;
  }
  EXPECT_EQ(named, 1 + 2 + 2 + 4);  // device, headlines, figures, stages
}

TEST(ReportMarkdown, ShowsChanges) {
  Results now = test::sample_results();
  now.devices[0].rows[0].wall = test::series_around(0.4e-3, 0.01e-3);
  now.devices[0].rows[1].scene.blobs = 21;
  const Baseline before{"/some/where/old.json", test::sample_results()};
  const std::string text = to_markdown(now, &before);
  EXPECT_THAT(text, HasSubstr("old.json: glint 0.1.0 (abc1234)"));
  EXPECT_THAT(text, Not(HasSubstr("/some/where")));
  EXPECT_THAT(text, HasSubstr("|      0.500 |    0.80 | faster"));
  EXPECT_THAT(text, HasSubstr("nothing to compare with"));
}

TEST(ReportMarkdown, SaysWhenOthersWereBusy) {
  Results busy = test::sample_results();
  busy.devices[0].rows[1].other_load_cores = 1.26;
  EXPECT_THAT(to_markdown(busy), HasSubstr("other programs kept up to 1.3 of 8 cores busy"));
  busy.devices[0].rows[1].other_load_cores.reset();
  EXPECT_THAT(to_markdown(busy), Not(HasSubstr("other programs")));
}

}  // namespace
}  // namespace glint::bench
