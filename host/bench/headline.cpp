// SPDX-License-Identifier: MIT
// Bisection over the number of cameras.
#include "host/bench/headline.hpp"

#include <algorithm>
#include <cstdio>
#include <exception>

#include "host/bench/measure.hpp"

namespace glint::bench {
namespace {

std::string rate_text(double rate_hz) {
  char text[32];
  std::snprintf(text, sizeof text, "%g Hz", rate_hz);
  return text;
}

Attempt try_once(const Target& target, Scene& scene, const Expected& expected, unsigned cameras,
                 const Conditions& conditions, unsigned threads) {
  Attempt attempt;
  try {
    const PreparedDetector made = make_detector(target, scene, cameras, {threads, conditions.depth});
    if (attempt.problem = expected.difference(*made.detector, cameras); !attempt.problem.empty()) {
      attempt.outcome = Outcome::Wrong;
      return attempt;
    }
    Drive drive(scene, expected, *made.detector, cameras);
    const double period_s = 1.0 / conditions.rate_hz;
    for (int chance = 0; chance < 2 && !attempt.in_time; ++chance) {
      warm_up(drive, conditions);
      const Paced paced = measure_pace(drive, conditions, conditions.ticks / 100);
      attempt.outcome = drive.outcome();
      attempt.problem = drive.problem();
      if (attempt.outcome != Outcome::Ok) return attempt;
      attempt.p99_s = paced.latency.summary.p99;
      attempt.in_time = attempt.p99_s < period_s;
    }
  } catch (const std::exception& e) {
    attempt.outcome = Outcome::Failed;
    attempt.problem = e.what();
  }
  return attempt;
}

}  // namespace

Headline search_headline(double rate_hz, unsigned most, const std::function<Attempt(unsigned)>& attempt) {
  Headline result;
  result.rate_hz = rate_hz;
  result.outcome = Outcome::Ok;
  unsigned in_time = 0, too_many = most + 1;
  // The largest number first: a quick device is done at once, and a slow one shows itself within a few ticks.
  for (unsigned cameras = most; in_time + 1 < too_many; cameras = in_time + (too_many - in_time) / 2) {
    const Attempt tried = attempt(cameras);
    if (tried.outcome == Outcome::Wrong || (tried.outcome == Outcome::Failed && cameras == 1)) {
      result.cameras = 0;
      result.p99_s = 0.0;
      result.outcome = tried.outcome;
      result.problem = tried.problem;
      return result;
    }
    if (tried.outcome == Outcome::Ok && tried.in_time) {
      in_time = cameras;
      result.p99_s = tried.p99_s;
    } else {
      too_many = cameras;
      result.problem = tried.problem;
    }
  }
  result.cameras = in_time;
  result.at_limit = in_time == gpu::kMaxCameras;
  return result;
}

std::vector<Headline> find_headlines(const Target& target, Scene& scene, const Expected& expected,
                                     const std::vector<double>& rates_hz, const Conditions& conditions,
                                     unsigned threads,
                                     const std::function<void(const std::string&)>& progress) {
  std::vector<double> rates = rates_hz;
  std::sort(rates.begin(), rates.end());
  std::vector<Headline> found;
  unsigned most = scene.options().cameras;
  for (const double rate_hz : rates) {
    Conditions at_rate = conditions;
    at_rate.rate_hz = rate_hz;
    if (most == 0) {  // not even one camera at a lower rate
      found.push_back({rate_hz, 0, false, 0.0, Outcome::Ok, ""});
      continue;
    }
    found.push_back(search_headline(rate_hz, most, [&](unsigned cameras) {
      progress("most cameras at " + rate_text(rate_hz) + ": trying " + std::to_string(cameras));
      return try_once(target, scene, expected, cameras, at_rate, threads);
    }));
    if (found.back().outcome != Outcome::Ok) return found;
    if (found.size() > 1 && found.back().cameras == most) found.back().problem = found.end()[-2].problem;
    most = found.back().cameras;
  }
  return found;
}

}  // namespace glint::bench
