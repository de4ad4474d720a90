// SPDX-License-Identifier: MIT
// Gathers comparisons, judges one camera after the other, and accuses the one that explains most.
#include "host/health/camera_health.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <string>

#include "host/base/check.hpp"
#include "host/base/error.hpp"
#include "host/health/comparison.hpp"
#include "host/health/explanation.hpp"
#include "host/health/residual_histogram.hpp"
#include "host/health/swap_search.hpp"

namespace glint {
namespace {

using namespace health;

constexpr double kWindow_s = 1.0;
// Comparisons of one camera a second: enough for every judgement below, and never more than the window holds.
constexpr double kComparisonsPerSecond = 200.0;
constexpr std::size_t kMostAtOnce = 8;        // of one camera in one exposure
constexpr std::size_t kMostPerExposure = 16;  // of all cameras: bounds the time that an exposure costs
constexpr std::size_t kMostBlobVisits = 20'000;
constexpr double kJudgeEvery_s = 0.1;
// A finding must hold for so long, and more than once, before it is told.
constexpr double kConfirm_s = 0.3;
constexpr unsigned kConfirmations = 2;
// Drift is slow, and what one camera is off by shows in the others' points as well: time to see whose it is.
// And a camera's fault does not turn into another without good reason.
constexpr double kConfirmLong_s = 2.0;
// Cameras that must remain free of blame.
constexpr unsigned kLeastWitnesses = 2, kLeastWitnessesOfSwap = 1;
constexpr double kForgetFine_s = 5.0;

constexpr std::uint32_t kLeastSeen = 20;
constexpr double kMedianChi2 = 1.386;  // two degrees of freedom: 2 ln 2
// All is well if nearly every blob is where it should be.
constexpr double kWellShare = 0.95, kFitShare = 0.5;
// What a fault must account for: most of what was seen, at places that a reflection or a hidden marker cannot
// fake, and with a likelihood that noise reaches once in e^30.
constexpr double kFaultShare = 0.6;
constexpr std::uint32_t kLeastGained = 10, kLeastCells = 4;
constexpr double kLeastGain = 30.0, kLeastLead = 10.0;
// Below this a turn is called drift: it may as well be an error of the calibration.
constexpr double kBumpSigmas = 6.0, kLeastBump_px = 0.5, kLeastBumpIfUnknown_px = 1.0;
constexpr double kLeastDelay_s = 0.2e-3;
constexpr double kDriftRatio = 2.0, kDriftOverRatio = 1.5;  // where drifting begins and where it is over
constexpr double kSuspectShare = 0.3;                       // fits less: may be another camera's image
// Of three cameras two that are swapped leave one, which makes no points: they are looked for while a smaller
// share of the blobs than this has become markers that all three see, and a larger one ends it.
constexpr double kFewMatched = 0.3, kManyMatched = 0.6, kMatchedFade_s = 0.5;
constexpr std::size_t kEventsReserved = 2 * kMatchCameras;

bool is_fault(CameraCondition condition) noexcept {
  return condition != CameraCondition::Unknown && condition != CameraCondition::Fine;
}

struct Watch {
  explicit Watch(const CameraCalibration& calibration) : explainer(calibration) {}

  ComparisonWindow window;
  Explainer explainer;
  double allowance = 0.0;  // comparisons that may be made
  std::size_t cursor = 0;  // marker that is compared next
  double judged_s = -1.0;

  // By the last judgement; not a number where too little was seen.
  double misfit = std::numeric_limits<double>::quiet_NaN();  // median in variances
  double others_noise2 = std::numeric_limits<double>::quiet_NaN();
  bool fits = false;     // more often than not
  bool suspect = false;  // hardly ever
  CameraState finding;
  double finding_since_s = 0.0;
  unsigned finding_count = 0;

  CameraState state;
  double fine_s = 0.0;  // when it was last found fine
  CameraReport report;
  ResidualHistogram residuals, expected;
};

}  // namespace

struct CameraHealth::Impl {
  Impl(const Calibration& calibration, const MatchOptions& given)
      : options(given), swaps(calibration.cameras.size()) {
    for (const CameraCalibration& camera : calibration.cameras) {
      cameras.emplace_back(camera, options);
      watches.emplace_back(camera);
    }
    events.reserve(kEventsReserved);
    swap_points.reserve(kMostAtOnce);
  }

  void gather(const HealthInput& input) noexcept;
  void search_swaps(const HealthInput& input) noexcept;
  void search_swaps_of_three(const HealthInput& input) noexcept;
  void judge(std::size_t camera) noexcept;
  CameraState find(std::size_t camera) noexcept;
  CameraState find_fault(std::size_t camera, const Account& well) noexcept;
  void conclude(std::size_t camera, const CameraState& finding) noexcept;
  void change(std::size_t camera, const CameraState& state) noexcept;
  bool another_explains_more(std::size_t camera, CameraCondition condition) const noexcept;
  bool knows_its_error(std::size_t camera) const noexcept {
    return cameras[camera].camera().calibration().rms_px > 0.0;
  }
  bool leaves(unsigned witnesses, std::uint32_t without) const noexcept;
  double rig_noise() noexcept;

  const MatchOptions options;
  std::vector<ComparedCamera> cameras;
  std::vector<Watch> watches;
  SwapSearch swaps;
  std::vector<OthersPoint> swap_points;
  std::vector<HealthEvent> events;
  std::uint32_t accused = 0;
  bool started = false;
  Timestamp first{};
  double now_s = 0.0, step_s = 0.0, noise = 1.0;
  double matched = 1.0;  // of three cameras: share of the blobs that are markers of all, lately
  std::size_t first_to_gather = 0, next_to_judge = 0, next_pair = 0, swap_cursor = 0;
  std::array<double, ComparisonWindow::kCapacity> scratch;
};

CameraHealth::CameraHealth(const Calibration& calibration, const MatchOptions& options) {
  if (calibration.cameras.size() > kMatchCameras)
    throw Error("the calibration has " + std::to_string(calibration.cameras.size()) +
                " cameras; at most 32 can be watched");
  impl_ = std::make_unique<Impl>(calibration, options);
}

CameraHealth::~CameraHealth() = default;

std::span<const HealthEvent> CameraHealth::events() const noexcept { return impl_->events; }

CameraState CameraHealth::state(CameraId camera) const noexcept {
  return impl_->watches[index(camera)].state;
}

HealthReport CameraHealth::report() const {
  HealthReport all;
  for (const Watch& watch : impl_->watches) {
    CameraReport report = watch.report;
    report.state = watch.state;
    report.residual_px = watch.residuals.median_px();
    report.expected_px = watch.expected.median_px();
    all.cameras.push_back(report);
  }
  return all;
}

void CameraHealth::watch(const HealthInput& input) noexcept {
  Impl& h = *impl_;
  GLINT_CHECK(input.blobs.size() == h.cameras.size());
  h.events.clear();
  if (!h.started) h.first = input.exposed;
  const double now_s = seconds_between(h.first, input.exposed);
  h.step_s = h.started ? std::max(0.0, now_s - h.now_s) : 0.0;
  h.now_s = std::max(h.now_s, now_s);
  h.started = true;
  h.gather(input);
  h.search_swaps(input);
  for (std::size_t n = 0; n < h.cameras.size(); ++n) {
    const std::size_t camera = (h.next_to_judge + n) % h.cameras.size();
    if (h.now_s - h.watches[camera].judged_s < kJudgeEvery_s) continue;
    h.watches[camera].judged_s = h.now_s;
    h.next_to_judge = camera + 1;
    h.judge(camera);
    break;
  }
}

void CameraHealth::Impl::gather(const HealthInput& input) noexcept {
  std::size_t left = kMostPerExposure, visits = 0;
  for (std::size_t n = 0; n < cameras.size() && left > 0; ++n) {
    const std::size_t camera = (first_to_gather + n) % cameras.size();
    Watch& watch = watches[camera];
    watch.allowance = std::min(watch.allowance + kComparisonsPerSecond * step_s, double{kMostAtOnce});
    if ((input.frames >> camera & 1u) == 0) continue;
    const std::uint32_t allowed = ~(accused | 1u << camera);
    std::size_t markers = std::min({static_cast<std::size_t>(watch.allowance), input.markers.size(), left});
    for (; markers > 0 && visits < kMostBlobVisits; --markers, --left, watch.allowance -= 1.0) {
      const WatchedMarker& marker = input.markers[watch.cursor++ % input.markers.size()];
      const auto point =
          point_of_others(input.points[marker.point], allowed, cameras, input.blobs, options.marker_radius_m);
      if (!point) continue;
      visits += input.blobs[camera].size();
      auto comparison = cameras[camera].compare(*point, marker.velocity_in_world, input.blobs[camera]);
      if (!comparison) continue;
      comparison->time_s = now_s;
      watch.window.add(*comparison);
      if (comparison->blobs == 0) continue;
      ++watch.report.compared;
      if (misfit2(*comparison, noise) <= kNearChi2) ++watch.report.agreed;
      watch.residuals.add(comparison->offset_px[0].norm());
      watch.expected.add(std::sqrt(0.5 * kMedianChi2 * comparison->covariance_px2.trace()));
    }
  }
  first_to_gather = cameras.empty() ? 0 : (first_to_gather + 1) % cameras.size();
}

// One pair of three cameras in an exposure.
void CameraHealth::Impl::search_swaps_of_three(const HealthInput& input) noexcept {
  if (input.frames != 0b111u) return;
  const std::size_t fewest = std::min({input.blobs[0].size(), input.blobs[1].size(), input.blobs[2].size()});
  if (fewest == 0) return;
  const auto by_all = std::ranges::count_if(
      input.markers, [&](const WatchedMarker& marker) { return input.points[marker.point].views == 3; });
  const double share = static_cast<double>(by_all) / static_cast<double>(fewest);
  matched += (share - matched) * (1.0 - std::exp(-step_s / kMatchedFade_s));
  if (matched > kFewMatched) return;
  next_pair = (next_pair + 1) % 3;
  swaps.add_triples((next_pair + 1) % 3, (next_pair + 2) % 3, next_pair, now_s, input.blobs, cameras);
}

// One pair of suspects in an exposure.
void CameraHealth::Impl::search_swaps(const HealthInput& input) noexcept {
  const std::size_t count = cameras.size();
  if (count == 3) return search_swaps_of_three(input);
  for (std::size_t n = 0; n < count * count; ++n) {
    next_pair = (next_pair + 1) % (count * count);
    const std::size_t a = next_pair / count, b = next_pair % count;
    if (a >= b || !watches[a].suspect || !watches[b].suspect) continue;
    const std::uint32_t pair = 1u << a | 1u << b;
    if ((input.frames & pair) != pair) continue;
    swap_points.clear();
    for (std::size_t k = 0; k < std::min(input.markers.size(), kMostAtOnce); ++k) {
      const WatchedMarker& marker = input.markers[swap_cursor++ % input.markers.size()];
      const auto point = point_of_others(input.points[marker.point], ~(accused | pair), cameras, input.blobs,
                                         options.marker_radius_m);
      if (point) swap_points.push_back(*point);
    }
    swaps.add(a, b, now_s, swap_points, input.blobs[a], cameras[b]);
    swaps.add(b, a, now_s, swap_points, input.blobs[b], cameras[a]);
    return;
  }
}

// How much worse than promised the cameras agree: where the one that fits worst has no part, and as the
// better half of those that fit does. Calibrations that promise too much are no reason to accuse one camera.
double CameraHealth::Impl::rig_noise() noexcept {
  double least = std::numeric_limits<double>::infinity();
  std::size_t fitting = 0;
  for (std::size_t camera = 0; camera < watches.size(); ++camera) {
    const Watch& watch = watches[camera];
    if (watch.others_noise2 < least) least = watch.others_noise2;
    if (watch.fits && std::isfinite(watch.misfit) && (accused >> camera & 1u) == 0)
      scratch[fitting++] = watch.misfit;
  }
  double variance = std::isfinite(least) ? std::max(1.0, least) : 1.0;
  if (fitting >= 2) {
    const auto middle = scratch.begin() + static_cast<std::ptrdiff_t>((fitting - 1) / 2);
    std::nth_element(scratch.begin(), middle, scratch.begin() + static_cast<std::ptrdiff_t>(fitting));
    variance = std::max(variance, *middle);
  }
  return std::sqrt(variance);
}

void CameraHealth::Impl::judge(std::size_t camera) noexcept {
  watches[camera].window.forget_before(now_s - kWindow_s);
  conclude(camera, find(camera));
}

CameraState CameraHealth::Impl::find(std::size_t camera) noexcept {
  Watch& watch = watches[camera];
  const ComparisonWindow& window = watch.window;
  noise = rig_noise();
  watch.misfit = watch.others_noise2 = std::numeric_limits<double>::quiet_NaN();
  watch.fits = false;
  CameraState finding;
  const auto median = [this](std::size_t count) {
    std::nth_element(scratch.begin(), scratch.begin() + count / 2, scratch.begin() + count);
    return scratch[count / 2];
  };
  if (window.size() >= kLeastSeen) {
    for (std::size_t n = 0; n < window.size(); ++n) scratch[n] = window[n].chi2_ratio;
    watch.others_noise2 = median(window.size());
  }
  const Account well = watch.explainer.all_is_well(window, noise);
  watch.suspect =
      window.size() >= kLeastSeen && well.explained < kSuspectShare * static_cast<double>(window.size());
  const bool one_witness = cameras.size() == 3;
  for (std::size_t other = 0; other < cameras.size() && (watch.suspect || one_witness); ++other) {
    if (other == camera || !swaps.swapped(camera, other, now_s)) continue;
    finding.condition = CameraCondition::Swapped;
    finding.swapped_with = CameraId{static_cast<std::uint8_t>(other)};
    return finding;
  }
  if (one_witness && watch.state.condition == CameraCondition::Swapped && matched > kManyMatched) {
    finding.condition = CameraCondition::Fine;
    return finding;
  }
  if (well.seen < kLeastSeen) return finding;

  std::size_t count = 0;
  for (std::size_t n = 0; n < window.size(); ++n)
    if (window[n].blobs > 0) scratch[count++] = misfit2(window[n], 1.0);
  watch.misfit = median(count) / kMedianChi2;
  watch.fits = well.explained >= kFitShare * well.seen;
  const double ratio = std::sqrt(watch.misfit) / noise;
  const double drift = watch.state.condition == CameraCondition::Drifting ? kDriftOverRatio : kDriftRatio;
  if (well.explained < kWellShare * well.seen || ratio > drift) {
    finding = find_fault(camera, well);
    if (finding.condition != CameraCondition::Unknown || !watch.fits) return finding;
  }
  // Twice of what nobody knows is no reason.
  const bool drifts = ratio > drift && knows_its_error(camera);
  finding.condition = drifts ? CameraCondition::Drifting : CameraCondition::Fine;
  return finding;
}

CameraState CameraHealth::Impl::find_fault(std::size_t camera, const Account& well) noexcept {
  Watch& watch = watches[camera];
  const DelayAccount delay = watch.explainer.delayed(watch.window, noise);
  const TurnAccount turn = watch.explainer.turned(watch.window, noise);
  // Schwarz, Estimating the dimension of a model, Annals of Statistics 6(2), 1978: what a free parameter
  // gains by chance.
  const double parameter = 0.5 * std::log(static_cast<double>(well.seen));
  const auto gain_of = [&](const Account& account, double parameters) {
    return account.log_likelihood - std::max(well.log_likelihood, account.log_likelihood_unmoved) -
           parameters * parameter;
  };
  const double delay_gain = gain_of(delay, 1.0), turn_gain = gain_of(turn, 3.0);
  const auto convinces = [&](const Account& account, double gain, double other_gain) {
    return gain > kLeastGain && gain > other_gain + kLeastLead && account.gained >= kLeastGained &&
           account.gained_cells >= kLeastCells && account.explained >= kFaultShare * account.seen;
  };
  CameraState finding;
  const double sigma_px = noise * std::sqrt(cameras[camera].variance_px2());
  if (convinces(delay, delay_gain, turn_gain) && std::abs(delay.late_s) >= kLeastDelay_s) {
    finding.condition = CameraCondition::Late;
    finding.late_s = delay.late_s;
  } else if (convinces(turn, turn_gain, delay_gain)) {
    const double least_px = knows_its_error(camera) ? kLeastBump_px : kLeastBumpIfUnknown_px;
    const bool bumped = turn.offset_px >= std::max(least_px, kBumpSigmas * sigma_px);
    if (!bumped && !knows_its_error(camera)) return finding;
    finding.condition = bumped ? CameraCondition::Bumped : CameraCondition::Drifting;
    finding.turn_rad = turn.turn_rad;
    finding.offset_px = turn.offset_px;
  }
  return finding;
}

// A camera that is wrong spoils the others' points as well; the right one to accuse is the one whose removal
// leaves least unexplained, which is the one that fits worst to the others. Drift is the least of all faults:
// any camera that fits worse may be its cause.
bool CameraHealth::Impl::another_explains_more(std::size_t camera, CameraCondition condition) const noexcept {
  for (std::size_t other = 0; other < watches.size(); ++other) {
    if (other == camera || (accused >> other & 1u) != 0) continue;
    const bool counts = condition == CameraCondition::Drifting || is_fault(watches[other].finding.condition);
    if (counts && watches[other].misfit > watches[camera].misfit) return true;
  }
  return false;
}

bool CameraHealth::Impl::leaves(unsigned witnesses, std::uint32_t without) const noexcept {
  return static_cast<unsigned>(std::popcount(accused | without)) + witnesses <= cameras.size();
}

void CameraHealth::Impl::conclude(std::size_t camera, const CameraState& finding) noexcept {
  Watch& watch = watches[camera];
  const bool same =
      finding.condition == watch.finding.condition && finding.swapped_with == watch.finding.swapped_with;
  watch.finding = finding;
  if (!same) {
    watch.finding_since_s = now_s;
    watch.finding_count = 0;
  }
  ++watch.finding_count;
  const double held_s = now_s - watch.finding_since_s;
  const CameraCondition before = watch.state.condition;
  const bool slowly =
      finding.condition == CameraCondition::Drifting ||
      (is_fault(finding.condition) && is_fault(before) && before != CameraCondition::Drifting);
  const bool held = watch.finding_count >= kConfirmations && held_s >= (slowly ? kConfirmLong_s : kConfirm_s);
  if (finding.condition == CameraCondition::Fine) watch.fine_s = now_s;
  if (finding.condition == CameraCondition::Unknown) {
    if (before == CameraCondition::Fine && now_s - watch.fine_s > kForgetFine_s) watch.state = finding;
  } else if (finding.condition == before) {
    watch.state = finding;  // newer figures
  } else if (finding.condition == CameraCondition::Fine) {
    if (before == CameraCondition::Unknown || held) change(camera, finding);
  } else if (held && finding.condition != CameraCondition::Swapped) {
    if (leaves(kLeastWitnesses, 1u << camera) && !another_explains_more(camera, finding.condition))
      change(camera, finding);
  } else if (held && leaves(kLeastWitnessesOfSwap, 1u << camera | 1u << index(finding.swapped_with))) {
    change(camera, finding);
    CameraState other = finding;
    other.swapped_with = CameraId{static_cast<std::uint8_t>(camera)};
    change(index(finding.swapped_with), other);
  }
}

void CameraHealth::Impl::change(std::size_t camera, const CameraState& state) noexcept {
  Watch& watch = watches[camera];
  const CameraCondition before = watch.state.condition;
  watch.state = state;
  if (is_fault(state.condition)) {
    ++watch.report.faults;
    accused |= 1u << camera;
    // What the others' points were made of counts no more.
    for (std::size_t other = 0; other < watches.size(); ++other) {
      if (other == camera || (accused >> other & 1u) != 0) continue;
      watches[other].window.clear();
      watches[other].finding = CameraState{};
      watches[other].finding_count = 0;
    }
  } else {
    accused &= ~(1u << camera);
  }
  if ((is_fault(state.condition) || is_fault(before)) && events.size() < events.capacity())
    events.push_back({CameraId{static_cast<std::uint8_t>(camera)}, state, before});
}

}  // namespace glint
