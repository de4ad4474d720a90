// SPDX-License-Identifier: MIT
// `glint track`: any source in, tracked points out.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>

#include "host/apps/alignment_text.hpp"
#include "host/apps/body_text.hpp"
#include "host/apps/commands.hpp"
#include "host/apps/health_text.hpp"
#include "host/apps/identity_text.hpp"
#include "host/apps/live_cameras.hpp"
#include "host/apps/real_time_arguments.hpp"
#include "host/apps/run_arguments.hpp"
#include "host/apps/run_summary.hpp"
#include "host/apps/status_line.hpp"
#include "host/apps/stop_signal.hpp"
#include "host/base/error.hpp"
#include "host/files/text_file.hpp"
#include "host/output/body_sink.hpp"
#include "host/output/report.hpp"
#include "host/output/report_recorder.hpp"
#include "host/output/track_sink.hpp"
#include "host/pipeline/track_pipeline.hpp"
#include "host/sim/score.hpp"

namespace glint::apps {
namespace {

struct TrackArguments {
  RunArguments run;
  std::string output = "none", poses, report, summary;
  std::vector<std::filesystem::path> body_files;
  RealTimeArguments real_time;
  bool force = false, quiet = false;
};

/// The output thread's part of a run: sinks, recorder, score, status line.
class TrackOutput {
 public:
  /// `pose_score`: the bodies are the scene's own, in its order.
  TrackOutput(const TrackArguments& a, const OutputSpec& spec, const Scene* scene,
              std::vector<std::string> cameras, std::vector<BodyModel> bodies, bool pose_score)
      : sink_(make_track_sink(spec, bodies)), cameras_(std::move(cameras)), status_(a.quiet) {
    if (!a.poses.empty()) body_sink_.emplace(a.poses, a.force, bodies);
    if (scene != nullptr) score_.emplace(*scene);
    if (pose_score) pose_score_.emplace(*scene);
    bodies_.steadiness.resize(bodies.size());
    bodies_.bodies = std::move(bodies);
  }

  void take(const TickResult& tick, TrackPipeline& pipeline) {
    if (!first_) first_ = tick;
    last_delivered_ = tick.delivered;
    TrackRow row{tick.trigger, tick.exposed, tick.points, tick.frames, std::nullopt, std::nullopt};
    if (tick.live) row.exposed_error_s = tick.live->exposed_error_s, row.stamped = tick.live->stamped;
    row.unproven = tick.unproven;
    row.dark = tick.dark;
    row.identity = tick.identity;
    row.bodies = tick.bodies;
    for (const AlignmentEvent& event : tick.events) print_event(event_text(event, cameras_));
    for (const HealthEvent& event : tick.health) print_event(event_text(event, cameras_));
    identity_.take(tick.trigger, tick.identity, std::chrono::steady_clock::now(), lines_);
    for (const std::string& line : lines_) print_event(line);
    for (const BodyEvent& event : tick.body_events)
      print_event(event_text(tick.trigger, event, bodies_.bodies));
    if (sink_->write(row) != SinkStatus::Ok) end_run(sink_->problem(), pipeline);
    if (body_sink_ && body_sink_->write(tick.trigger, tick.exposed, tick.bodies) != SinkStatus::Ok)
      end_run(body_sink_->problem(), pipeline);
    if (!tick.dark) bodies_.add(tick.bodies);
    if (pose_score_ && !tick.dark) {
      to_scored(tick.bodies, scored_poses_);
      pose_score_->add(number(tick.trigger), scored_poses_);
    }
    recorder_.add({tick.exposed, tick.points, tick.detection_s(), tick.end_to_end_s(), since_stamp_s(tick)});
    if (tick.live) {
      time_error_.add(tick.live->exposed_error_s);
      stamp_ = tick.live->stamp;
    }
    for (const TrackedPoint& point : tick.points) highest_id_ = std::max(highest_id_, number(point.id));
    kinds_.add(tick.points);
    if (score_) {
      scored_.clear();
      for (const TrackedPoint& p : tick.points)
        if (p.kind != SampleKind::Predicted)  // it claims no measurement
          scored_.push_back({number(p.id), p.position_in_world, p.cameras});
      score_->add(number(tick.trigger), scored_);
    }
    ++ticks_;
    points_ += tick.points.size();
    if (status_.due(tick.delivered)) show(tick, pipeline);
  }

  /// Ends messages and files. Returns why the output is not complete; "" if it is.
  std::string finish() {
    if (const std::string rest = identity_.rest(); !rest.empty()) print_event(rest);
    if (sink_->finish() != SinkStatus::Ok && sink_problem_.empty()) sink_problem_ = sink_->problem();
    if (body_sink_ && body_sink_->finish() != SinkStatus::Ok && sink_problem_.empty())
      sink_problem_ = body_sink_->problem();
    return sink_problem_;
  }

  void fill(RunSummary& summary) const {
    summary.detection = recorder_.detection();
    summary.end_to_end = recorder_.end_to_end();
    summary.stamp_to_output = recorder_.stamp_to_output();
    summary.time_error = time_error_;
    summary.stamp = stamp_;
    summary.ids = highest_id_;
    summary.kinds = kinds_;
    summary.wall_s = first_ ? seconds_between(first_->delivered, last_delivered_) : 0.0;
    summary.rate_hz = summary.wall_s > 0.0 ? static_cast<double>(ticks_ - 1) / summary.wall_s : 0.0;
    if (score_) summary.score = score_->result();
    summary.bodies = bodies_;
    if (pose_score_) summary.bodies.score = pose_score_->result();
  }
  void fill(ReportData& report) const { recorder_.fill(report); }

 private:
  /// Negative where there is no stamp. Some drivers stamp a little ahead of time: then it took no time at
  /// all.
  static double since_stamp_s(const TickResult& tick) noexcept {
    if (!tick.live) return -1.0;
    return std::max(0.0, seconds_between(tick.live->stamped, std::chrono::steady_clock::now()));
  }
  void end_run(const std::string& problem, TrackPipeline& pipeline) {
    if (!sink_problem_.empty()) return;
    sink_problem_ = problem;
    std::fprintf(stderr, "glint: output: %s; the run ends\n", sink_problem_.c_str());
    pipeline.stop();
  }
  void show(const TickResult& tick, TrackPipeline& pipeline) {
    Status s;
    s.since_start_s = seconds_between(first_->delivered, tick.delivered);
    const double lap_s = seconds_between(lap_started_ ? *lap_started_ : first_->delivered, tick.delivered);
    s.rate_hz = lap_s > 0.0 ? static_cast<double>(ticks_ - lap_ticks_) / lap_s : 0.0;
    s.points_per_tick = static_cast<double>(points_ - lap_points_) /
                        static_cast<double>(std::max<std::uint64_t>(1, ticks_ - lap_ticks_));
    s.detection_p50_s = recorder_.detection().quantile_s(0.5);
    s.from_stamp = recorder_.stamp_to_output().count() > 0;
    const LatencyHistogram& latency = s.from_stamp ? recorder_.stamp_to_output() : recorder_.end_to_end();
    s.latency_p50_s = latency.quantile_s(0.5);
    s.latency_p99_s = latency.quantile_s(0.99);
    const InputCounters input = pipeline.input().counters();
    s.missed = input.dropped + input.late + pipeline.counters().results_dropped;
    const std::span<const SourceCamera> cameras = pipeline.input().cameras();
    for (std::size_t camera = 0; camera < cameras.size(); ++camera) {
      if (input.not_used[camera] == 0) continue;
      s.not_used += (s.not_used.empty() ? "" : ", ") + cameras[camera].name + " " +
                    std::to_string(input.not_used[camera]);
    }
    status_.show(s);
    (void)sink_->flush();
    if (body_sink_) (void)body_sink_->flush();
    lap_started_ = tick.delivered;
    lap_ticks_ = ticks_;
    lap_points_ = points_;
  }

  std::unique_ptr<TrackSink> sink_;
  std::optional<BodySink> body_sink_;
  std::vector<std::string> cameras_;
  std::string sink_problem_;
  StatusLine status_;
  IdentityLines identity_;
  std::vector<std::string> lines_;
  KindCounts kinds_;
  ReportRecorder recorder_;
  LatencyHistogram time_error_;
  StampPoint stamp_ = StampPoint::HostArrival;
  std::optional<Score> score_;
  std::vector<ScoredPoint> scored_;
  BodyRun bodies_;
  std::optional<PoseScore> pose_score_;
  std::vector<ScoredPose> scored_poses_;
  std::optional<TickResult> first_;
  Timestamp last_delivered_{};
  std::optional<Timestamp> lap_started_;
  std::uint32_t highest_id_ = 0;
  std::uint64_t ticks_ = 0, points_ = 0, lap_ticks_ = 0, lap_points_ = 0;
};

void print_lines(const char* prefix, const std::string& text) {
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    std::fprintf(stderr, "glint: %s%s\n", prefix, text.substr(at, end - at).c_str());
    at = end + 1;
  }
}

void run(const TrackArguments& a) {
  const OutputSpec spec = parse_output_spec(a.output, a.force);
  if (spec.to_stdout() && a.poses == "-")
    throw UsageError("--output and --poses cannot both go to standard output: give one of them a file");
  StopSignal stop_signal;  // before any thread
  std::optional<ReportFile> report_file;
  if (!a.report.empty()) report_file.emplace(a.report, true);
  std::optional<RealTime> real_time = make_real_time(a.real_time, a.run);
  OpenedRun opened = open_run(a.run, true, real_time ? &*real_time : nullptr);
  if (opened.rig.calibration.cameras.size() == 1 && !opened.rig.match.plane_height_m) {
    throw Error(
        "one camera alone measures no depth: say at which height the markers are, match.plane_height_m in "
        "the rig file or --plane-height");
  }
  const std::vector<BodyModel> bodies = chosen_bodies(opened.rig, a.body_files, opened.scene.get());
  if (bodies.empty() && !a.poses.empty())
    throw UsageError(
        "--poses: no rigid body is known: give --body FILE, or [[body]] sections in the rig file");
  const bool bodies_of_scene =
      opened.scene && opened.rig.bodies.empty() && a.body_files.empty() && !bodies.empty();
  RunSummary summary;
  summary.plane_height_m = opened.rig.match.plane_height_m;
  for (const SourceCamera& camera : opened.input->cameras()) summary.cameras.push_back(camera.name);
  std::optional<TrackOutput> output(std::in_place, a, spec, opened.scene.get(), summary.cameras, bodies,
                                    bodies_of_scene);

  summary.source = a.run.source;
  summary.rig = opened.rig.path.empty() ? opened.rig.name : opened.rig.path.string();
  summary.device = opened.input->device_name();
  summary.nominal_rate_hz = opened.input->rate_hz();
  if (!a.quiet) {
    std::fprintf(stderr, "glint: %s, %zu cameras, on %s\n", a.run.source.c_str(),
                 opened.input->cameras().size(), summary.device.c_str());
    for (const std::string& note : opened.notes) std::fprintf(stderr, "glint: %s\n", note.c_str());
  }

  std::function<void()> on_track_thread;
  if (real_time) on_track_thread = [&real_time] { real_time->enter(ThreadRole::Tracking); };
  TrackPipeline pipeline(std::move(opened.input), opened.rig.calibration, opened.rig.match, opened.rig.track,
                         bodies, on_track_thread);
  if (real_time) {
    real_time->lock_memory();
    const std::string refusal = real_time->state().refusal;
    if (!refusal.empty()) {
      std::fprintf(stderr, "glint: not in real time: %s; %s (or --realtime=off)\n", refusal.c_str(),
                   std::string(kLimitsAdvice).c_str());
    }
  }
  const StopSignal::Handler on_stop(stop_signal, [&pipeline] { pipeline.stop(); });
  const ReadStatus end = pipeline.run([&](const TickResult& tick) { output->take(tick, pipeline); });
  const std::string output_problem = output->finish();
  output->fill(summary);
  if (real_time) summary.real_time = real_time->state();
  summary.counters = pipeline.counters();
  summary.health = pipeline.health();
  summary.input = pipeline.input().counters();
  if (const Ledger* const ledger = pipeline.input().ledger()) summary.ledger = *ledger;
  if (const CodeReport* const code = pipeline.input().code()) summary.code = *code;
  if (opened.board) {
    summary.board = opened.board->counters();
    summary.board_serial = opened.board->info().serial;
  }
  ReportData report;
  if (report_file) output->fill(report);
  output.reset();  // ends the status line

  if (!a.quiet) std::fputs(summary_text(summary).c_str(), stderr);
  if (!a.summary.empty()) write_text_file(a.summary, summary_json(summary), true);
  if (report_file) {
    report.title = "glint: " + a.run.source;
    report.subtitle = "rig " + summary.rig + ", " + summary.device;
    report.summary = summary_rows(summary);
    report.cameras = opened.rig.calibration.cameras;
    report.nominal_rate_hz = summary.nominal_rate_hz;
    report_file->write(report);
    std::fprintf(stderr, "report: %s\n", report_file->path().c_str());
  }
  if (!output_problem.empty()) throw Error("output is not complete: " + output_problem);
  if (end == ReadStatus::Failed) throw Error(pipeline.problem());
  const SourceCounters& frames = summary.input.source;
  if (!pipeline.input().live() && (frames.damaged > 0 || frames.ended_early > 0))
    throw Error("the recording is not whole:\n" + pipeline.problem());
  if (!pipeline.problem().empty()) print_lines("note: ", pipeline.problem());
}

}  // namespace

void add_track(CLI::App& app) {
  CLI::App* command = app.add_subcommand("track", "Track markers: images or blobs in, 3D points out");
  const auto a = std::make_shared<TrackArguments>();
  add_run_options(*command, a->run, "sim, v4l2:[DEVICE,...], images:LOCATION or blobs:FOLDER");
  command->add_option("--output", a->output, "csv:FILE, csv:-, jsonl:FILE, jsonl:- or none")
      ->capture_default_str();
  command
      ->add_option("--body", a->body_files,
                   "body file (glint body learn), besides those of the rig file; more than once")
      ->type_name("FILE")
      ->allow_extra_args(false);
  command->add_option("--poses", a->poses, "write poses of rigid bodies to this CSV file, or -")
      ->type_name("FILE.csv");
  command->add_option("--report", a->report, "write a page with a picture of cameras and trajectories");
  command->add_option("--summary", a->summary, "write the summary as JSON");
  add_real_time_options(*command, a->real_time);
  command->add_flag("--force", a->force, "replace an existing output file");
  command->add_flag("--quiet", a->quiet, "no status line, no summary");
  command->callback([a] { run(*a); });
}

}  // namespace glint::apps
