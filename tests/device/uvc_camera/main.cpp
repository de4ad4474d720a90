// SPDX-License-Identifier: MIT
// Virtual UVC cameras at the kernel's virtual USB ports while a command captures from them.
//   uvc_cameras --frames FILE [--rate HZ] [--pulses N] [--faults FILE] [--log FILE] -- COMMAND ARGUMENT...
// COMMAND starts when all cameras have their nodes, which it finds in CAMERA_1, CAMERA_2, ... The trigger
// starts when all cameras stream. Ends when COMMAND does, and as it did.
#include <poll.h>
#include <time.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/base/error.hpp"
#include "tests/device/frame_file/frame_file.hpp"
#include "tests/device/program/program.hpp"
#include "tests/device/reader_command/reader_command.hpp"
#include "tests/device/uvc_camera/fault_script.hpp"
#include "tests/device/uvc_camera/pulse_lines.hpp"
#include "tests/device/uvc_camera/trigger.hpp"
#include "tests/device/uvc_camera/virtual_camera.hpp"

namespace glint::device {
namespace {

struct Arguments {
  std::string frames, faults, log, board;
  TriggerOptions trigger;
};

std::int64_t now_ns() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

/// One pass: waits until something is due or the host wants something, at most `patience_ns`, and does it.
void serve(Trigger::Cameras& cameras, Trigger& trigger, PulseLines* pulses, std::int64_t patience_ns) {
  std::int64_t wake_ns = std::min(now_ns() + patience_ns, trigger.next_ns());
  std::vector<pollfd> polls;
  for (const VirtualCamera& camera : cameras) {
    wake_ns = std::min(wake_ns, camera.next_due_ns());
    polls.push_back({camera.socket(), POLLIN, 0});
  }
  if (pulses != nullptr) polls.push_back({pulses->socket(), POLLIN, 0});
  const std::int64_t wait_ns = std::max<std::int64_t>(wake_ns - now_ns(), 0);
  const timespec wait{wait_ns / 1'000'000'000, wait_ns % 1'000'000'000};
  ppoll(polls.data(), polls.size(), &wait, nullptr);
  const std::int64_t now = now_ns();
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    if (polls[c].revents != 0 && !cameras[c].answer_host(now)) cameras[c].unplug();
  }
  if (pulses != nullptr) {
    while (const std::optional<std::int64_t> pulse_ns = pulses->next(now)) trigger.fire(*pulse_ns);
  }
  trigger.fire_due(now);
  for (VirtualCamera& camera : cameras) camera.complete_due(now);
  trigger.replug_waiting();
}

constexpr std::int64_t kPatience_ns = 5'000'000;

/// Plugs the cameras in one after the other, so that their nodes are numbered in their order.
std::vector<std::string> plug_all(Trigger::Cameras& cameras, Trigger& trigger, PulseLines* pulses) {
  constexpr std::int64_t kLongest_ns = 20'000'000'000;
  std::vector<std::string> environment;
  for (VirtualCamera& camera : cameras) {
    camera.plug();
    const std::int64_t latest = now_ns() + kLongest_ns;
    while (camera.capture_node().empty()) {
      const std::string name = "virtual camera " + std::to_string(environment.size() + 1);
      if (now_ns() > latest) throw Error(name + ": the kernel makes no capture node of it; load uvcvideo");
      serve(cameras, trigger, pulses, kPatience_ns);
    }
    environment.push_back("CAMERA_" + std::to_string(environment.size() + 1) + "=" + camera.capture_node());
  }
  return environment;
}

int run(int argc, char** argv) {
  Arguments a;
  const std::vector<std::string> command = take_command(argc, argv);
  double read_out_ms = 2.0;
  CLI::App app("virtual UVC cameras while a command captures from them");
  app.add_option("--frames", a.frames, "what they send; sim_frames makes it")->required();
  app.add_option("--rate", a.trigger.rate_hz, "pulses per second")->check(CLI::Range(0.1, 1000.0));
  app.add_option("--pulses", a.trigger.pulses,
                 "then the trigger falls silent; 0: as many as the file has ticks");
  app.add_option("--read-out", read_out_ms, "ms from the pulse until the frame leaves the camera");
  app.add_option(
      "--board", a.board,
      "ADDRESS:PORT of usbip_server.js's control port: its GP2 triggers, not a trigger of our own");
  app.add_option("--faults", a.faults, "script of lines PULSE CAMERA FAULT");
  app.add_option("--log", a.log, "CSV of what was sent, written at the end");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    throw UsageError(error.what());
  }
  const FrameFile frames(a.frames);
  const unsigned count = frames.header().cameras;
  const FaultScript faults = a.faults.empty() ? FaultScript() : FaultScript::read(a.faults, count);
  if (a.trigger.pulses == 0) a.trigger.pulses = frames.header().ticks;
  a.trigger.read_out_ns = static_cast<std::int64_t>(read_out_ms * 1e6);
  Trigger::Cameras cameras;
  for (unsigned c = 0; c < count; ++c) {
    CameraModel model;
    model.serial = "GLINT000" + std::to_string(c + 1);
    model.width_px = frames.header().width_px;
    model.height_px = frames.header().height_px;
    cameras.emplace_back(model, c);
  }
  Trigger trigger(a.trigger, frames, faults, cameras);
  become_hardware();
  constexpr unsigned kTriggerPin = 2;
  std::optional<PulseLines> lines;
  if (!a.board.empty()) lines.emplace(a.board, kTriggerPin);
  PulseLines* const pulses = lines ? &*lines : nullptr;
  const std::vector<std::string> environment = plug_all(cameras, trigger, pulses);
  ReaderCommand reader(command, environment);
  while (!reader.ended()) {
    serve(cameras, trigger, pulses, kPatience_ns);
    if (pulses != nullptr) continue;
    const auto streams = [](const VirtualCamera& camera) { return camera.streaming(); };
    if (!trigger.started() && std::all_of(cameras.begin(), cameras.end(), streams)) {
      constexpr std::int64_t kSettle_ns =
          20'000'000;  // the first transfers of the last camera are on their way
      trigger.start(now_ns() + kSettle_ns);
    }
  }
  std::uint64_t starved = 0;
  for (const VirtualCamera& camera : cameras) starved += camera.starved();
  std::fprintf(stderr, "uvc_cameras: %llu pulses, %llu transfers came too late for the bus\n",
               static_cast<unsigned long long>(trigger.pulses()), static_cast<unsigned long long>(starved));
  if (!a.log.empty()) trigger.write_log(a.log);
  return *reader.ended();
}

}  // namespace
}  // namespace glint::device

int main(int argc, char** argv) {
  return glint::device::run_program("uvc_cameras", glint::device::run, argc, argv);
}
