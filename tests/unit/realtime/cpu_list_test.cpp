// SPDX-License-Identifier: MIT
// Lists of CPUs.
#include "host/realtime/cpu_list.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace glint {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

TEST(CpuList, ReadsNumbersAndRanges) {
  EXPECT_THAT(*parse_cpu_list("3"), ElementsAre(3));
  EXPECT_THAT(*parse_cpu_list("6-8,2,7"), ElementsAre(2, 6, 7, 8));
  EXPECT_THAT(*parse_cpu_list(""), IsEmpty());
}

TEST(CpuList, RefusesWhatIsNone) {
  for (const char* text : {"a", "1,", ",1", "3-1", "1-", "-1", "1 2", "0-4000000000", "99999", "1,,2", "2x"})
    EXPECT_FALSE(parse_cpu_list(text)) << text;
}

TEST(CpuList, IsWrittenAsLinuxDoes) {
  EXPECT_EQ(cpu_list_text({}), "");
  EXPECT_EQ(cpu_list_text({5}), "5");
  EXPECT_EQ(cpu_list_text({0, 1, 4, 5, 6}), "0-1,4-6");
}

}  // namespace
}  // namespace glint
