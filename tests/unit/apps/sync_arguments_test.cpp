// SPDX-License-Identifier: MIT
// What people write, and what it means.
#include "host/apps/sync_arguments.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "host/base/error.hpp"
#include "host/base/pulse_code.hpp"

namespace glint::apps {
namespace {

using namespace std::chrono_literals;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// What the UsageError of `work` says; "" if there is none.
template <class Work>
std::string complaint(Work&& work) {
  try {
    work();
  } catch (const UsageError& error) {
    return error.what();
  }
  return "";
}

std::string time_complaint(const std::string& text) {
  return complaint([&] { parse_time(text, "--exposure"); });
}

TEST(ParseTime, KnowsItsUnits) {
  EXPECT_DOUBLE_EQ(parse_time("8ns", "").count(), 8e-9);
  EXPECT_DOUBLE_EQ(parse_time("137us", "").count(), 137e-6);
  EXPECT_DOUBLE_EQ(parse_time("137 us", "").count(), 137e-6);
  EXPECT_DOUBLE_EQ(parse_time("137\u00b5s", "").count(), 137e-6);
  EXPECT_DOUBLE_EQ(parse_time("137\u03bcs", "").count(), 137e-6);
  EXPECT_DOUBLE_EQ(parse_time("1.5ms", "").count(), 1.5e-3);
  EXPECT_DOUBLE_EQ(parse_time("2s", "").count(), 2.0);
  EXPECT_DOUBLE_EQ(parse_time("0s", "").count(), 0.0);
}

TEST(ParseTime, ANumberAloneSaysWhichUnitsThereAre) {
  EXPECT_THAT(time_complaint("137"), AllOf(HasSubstr("--exposure 137"), HasSubstr("137us")));
}

TEST(ParseTime, NonsenseIsRefused) {
  for (const char* text : {"", "us", "-1us", "nan us", "inf s", "1e400s", "--", "137ks", "137us1", "1 2us"}) {
    EXPECT_NE(time_complaint(text), "") << text;
  }
}

std::vector<std::size_t> strobes_of(const std::string& text) {
  return parse_outputs(text, "--strobes", 4, 7);
}

TEST(ParseOutputs, ListsAndRanges) {
  EXPECT_THAT(strobes_of("4"), ElementsAre(4));
  EXPECT_THAT(strobes_of("4-7"), ElementsAre(4, 5, 6, 7));
  EXPECT_THAT(strobes_of("7,4-5"), ElementsAre(7, 4, 5));
  EXPECT_THAT(strobes_of("5,5,4-6"), ElementsAre(5, 4, 6));
  EXPECT_THAT(strobes_of("none"), IsEmpty());
}

TEST(ParseOutputs, NonsenseIsRefusedAndTheRangeNamed) {
  for (const char* text :
       {"", "3", "8", "4-8", "6-5", "4,", ",4", "4-", "4;5", "a", "4 5", "-4", "99999999999999999999999"}) {
    EXPECT_THAT(complaint([&] { strobes_of(text); }), AllOf(HasSubstr("--strobes"), HasSubstr("4 to 7")))
        << text;
  }
}

TEST(ParseSeed, OneUnlessSaidOtherwise) {
  EXPECT_EQ(parse_seed(""), 1u);
  EXPECT_EQ(parse_seed("4294967295"), 4294967295u);
  for (const char* text : {"0", "-1", "4294967296", "x", "1x"})
    EXPECT_NE(complaint([&] { parse_seed(text); }), "") << text;
}

TEST(ParseEdge, TwoThereAre) {
  EXPECT_EQ(parse_edge("rising"), sync::FrameStart::RisingEdge);
  EXPECT_EQ(parse_edge("falling"), sync::FrameStart::FallingEdge);
  EXPECT_THAT(complaint([] { parse_edge("up"); }), HasSubstr("rising or falling"));
}

StartArguments usual() {
  StartArguments a;
  a.rate_hz = 90.0;
  a.exposure = 137us;
  a.strobe_delay = 788us;
  return a;
}

TEST(PlanOf, AllTriggersAndStrobes) {
  const sync::BoardPlan plan = plan_of(usual());
  EXPECT_DOUBLE_EQ(plan.period.count(), 1.0 / 90.0);
  EXPECT_EQ(plan.start, sync::FrameStart::Internal);
  EXPECT_EQ(plan.pulses, 0u);
  EXPECT_EQ(plan.keepalive, 0ms);
  EXPECT_EQ(plan.code.group, 0);
  for (std::size_t i = 0; i < sync::kOutputs; ++i) {
    const sync::OutputPlan& output = plan.outputs[i];
    EXPECT_TRUE(output.enabled);
    EXPECT_FALSE(output.active_low);
    EXPECT_EQ(output.every_n, 1);
    EXPECT_DOUBLE_EQ(output.width.count(), i < 4 ? 100e-6 : 137e-6);
    EXPECT_DOUBLE_EQ(output.delay.count(), i < 4 ? 0.0 : 788e-6);
  }
}

TEST(PlanOf, InterleaveMovesPairs) {
  StartArguments a = usual();
  a.interleave = 2ms;
  a.trigger_delay = 10us;
  const sync::BoardPlan plan = plan_of(a);
  for (std::size_t i = 0; i < sync::kTriggers; ++i) {
    EXPECT_NEAR(plan.outputs[i].delay.count(), 10e-6 + 2e-3 * static_cast<double>(i), 1e-12);
    EXPECT_NEAR(plan.outputs[i + 4].delay.count(), 788e-6 + 2e-3 * static_cast<double>(i), 1e-12);
  }
}

TEST(PlanOf, ChosenOutputsOnly) {
  StartArguments a = usual();
  a.triggers = {1, 3};
  a.strobes = {6};
  const sync::BoardPlan plan = plan_of(a);
  for (std::size_t i = 0; i < sync::kOutputs; ++i)
    EXPECT_EQ(plan.outputs[i].enabled, i == 1 || i == 3 || i == 6) << i;
}

TEST(PlanOf, EverythingElseArrives) {
  StartArguments a = usual();
  a.external = sync::FrameStart::FallingEdge;
  a.pulses = 100;
  a.keepalive = 500ms;
  a.sync_out = true;
  a.trigger_width = 1ms;
  a.code_seed = 7;
  a.code_dark_width = 10us;
  sync::BoardPlan plan = plan_of(a);
  EXPECT_EQ(plan.start, sync::FrameStart::FallingEdge);
  EXPECT_EQ(plan.pulses, 100u);
  EXPECT_EQ(plan.keepalive, 500ms);
  EXPECT_TRUE(plan.sync_out);
  EXPECT_DOUBLE_EQ(plan.outputs[0].width.count(), 1e-3);
  EXPECT_EQ(plan.code.seed, 7u);
  EXPECT_EQ(plan.code.group, 30);  // as PulseCode recommends for 90 Hz
  EXPECT_EQ(PulseCode::recommended_group(90.0), 30u);
  EXPECT_DOUBLE_EQ(plan.code.dark_width.count(), 10e-6);
  a.code_group = 100;
  EXPECT_EQ(plan_of(a).code.group, 100);
  set_strobe_level(plan, true);
  for (std::size_t i = 0; i < sync::kOutputs; ++i) EXPECT_EQ(plan.outputs[i].active_low, i >= 4);
}

template <class Change>
std::string start_complaint(Change&& change) {
  StartArguments a = usual();
  change(a);
  return complaint([&] { plan_of(a); });
}

TEST(PlanOf, WhatDoesNotFitTogetherIsRefused) {
  EXPECT_THAT(start_complaint([](auto& a) { a.exposure.reset(); }), HasSubstr("--exposure is missing"));
  EXPECT_THAT(start_complaint([](auto& a) { a.strobes.emplace(); }), HasSubstr("--strobes says none"));
  EXPECT_EQ(start_complaint([](auto& a) { a.triggers.emplace(); }), "");
  EXPECT_THAT(start_complaint([](auto& a) {
                a.triggers.emplace();
                a.trigger_width = 1ms;
              }),
              HasSubstr("--triggers says none"));
  EXPECT_THAT(start_complaint([](auto& a) {
                a = StartArguments{};
                a.triggers.emplace();
                a.strobes.emplace();
              }),
              HasSubstr("nothing is left"));
  EXPECT_THAT(start_complaint([](auto& a) { a.rate_hz = 0.0; }), HasSubstr("--rate"));
  EXPECT_THAT(start_complaint([](auto& a) { a.rate_hz = -90.0; }), HasSubstr("--rate"));
  EXPECT_THAT(start_complaint([](auto& a) { a.pulses = 0; }), HasSubstr("--pulses"));
  EXPECT_THAT(start_complaint([](auto& a) { a.keepalive = 100us; }), HasSubstr("--keepalive"));
  EXPECT_THAT(start_complaint([](auto& a) { a.keepalive = 66s; }), HasSubstr("--keepalive"));
  EXPECT_THAT(start_complaint([](auto& a) { a.code_group = 30; }), HasSubstr("go with --code"));
  EXPECT_THAT(start_complaint([](auto& a) { a.code_seed = 1, a.code_group = 17; }), HasSubstr("18 to 1024"));
  EXPECT_THAT(start_complaint([](auto& a) { a.triggers = {1}, a.sync_out = true; }), HasSubstr("--sync-out"));
}

TEST(StartArguments, EmptyOnlyWithoutAnyOption) {
  EXPECT_TRUE(StartArguments{}.empty());
  StartArguments a;
  a.rate_hz = 90.0;
  EXPECT_FALSE(a.empty());
  a = {};
  a.strobes.emplace();
  EXPECT_FALSE(a.empty());
}

class ChangedPlan : public ::testing::Test {
 protected:
  ChangedPlan() { change_.output = 5; }
  sync::BoardPlan changed(bool strobes_active_low = false) const {
    return changed_plan(before_, change_, strobes_active_low);
  }
  std::string refusal() const {
    return complaint([this] { changed(); });
  }

  sync::BoardPlan before_ = plan_of(usual());
  SetArguments change_;
};

TEST_F(ChangedPlan, OneOutputOnly) {
  change_.off = true;
  change_.delay = 1ms;
  change_.width = 200us;
  change_.every = 3;
  change_.phase = 2;
  const sync::BoardPlan after = changed();
  sync::BoardPlan wanted = before_;
  wanted.outputs[5] = {
      .enabled = false, .active_low = false, .delay = 1ms, .width = 200us, .every_n = 3, .phase = 2};
  EXPECT_EQ(after, wanted);
}

TEST_F(ChangedPlan, WhatIsNotGivenStays) {
  EXPECT_TRUE(change_.empty());
  change_.every = 2;
  EXPECT_FALSE(change_.empty());
  EXPECT_EQ(changed().outputs[5].width, before_.outputs[5].width);
  EXPECT_TRUE(changed().outputs[5].enabled);
}

TEST_F(ChangedPlan, StrobesAreAsTheJumperSays) {
  change_.active_low = true;
  EXPECT_THAT(refusal(), AllOf(HasSubstr("output 5"), HasSubstr("jumper")));
  EXPECT_TRUE(changed(true).outputs[5].active_low);
  change_.output = 1;
  EXPECT_TRUE(changed().outputs[1].active_low);
}

TEST_F(ChangedPlan, ContradictionsAreRefused) {
  change_.on = change_.off = true;
  EXPECT_THAT(refusal(), HasSubstr("exclude"));
  change_ = {};
  change_.active_low = change_.active_high = true;
  EXPECT_THAT(refusal(), HasSubstr("exclude"));
  for (const int every : {0, 256}) {
    change_ = {};
    change_.every = every;
    EXPECT_THAT(refusal(), HasSubstr("--every"));
  }
  change_ = {};
  change_.phase = 1;
  EXPECT_THAT(refusal(), HasSubstr("--phase must be 0 to 0"));
}

TEST(ChangedLimits, TheRearmVoltageGoesDownWithTheLockout) {
  const sync::Limits before{
      .lockout_v = 14.0, .rearm_v = 13.8, .strobe_max_duty = 0.025, .strobe_max_width = 300us};
  LimitArguments a;
  EXPECT_TRUE(a.empty());
  a.lockout_v = 13.0;
  EXPECT_DOUBLE_EQ(changed_limits(before, a).rearm_v, 12.8);
  a.rearm_v = 12.0;
  EXPECT_DOUBLE_EQ(changed_limits(before, a).rearm_v, 12.0);
  a.strobe_duty_percent = 1.0;
  a.strobe_width = 150us;
  EXPECT_DOUBLE_EQ(changed_limits(before, a).strobe_max_duty, 0.01);
  EXPECT_DOUBLE_EQ(changed_limits(before, a).strobe_max_width.count(), 150e-6);
  a.rearm_v = 13.5;
  EXPECT_THAT(complaint([&] { changed_limits(before, a); }), HasSubstr("--rearm"));
  a.rearm_v.reset();
  a.strobe_duty_percent = 0.01;
  EXPECT_THAT(complaint([&] { changed_limits(before, a); }), HasSubstr("--strobe-duty"));
}

}  // namespace
}  // namespace glint::apps
