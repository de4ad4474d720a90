// SPDX-License-Identifier: MIT
// Lets vivid's capture devices go wrong while a command captures from them.
//   vivid_faults [--rate HZ] [--script FILE] [--log FILE] --device DEVICE... -- COMMAND ARGUMENT...
// Gives each device a signal of 1280x800 pixels and starts COMMAND; ends when it does, and as it did. Times
// of the script count from when all devices stream.
#include <time.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "host/base/error.hpp"
#include "tests/device/program/program.hpp"
#include "tests/device/reader_command/reader_command.hpp"
#include "tests/device/vivid_faults/vivid_device.hpp"

namespace glint::device {
namespace {

/// Words of the script, and the controls that they press or set.
struct Word {
  const char *text, *control;
};
constexpr Word kWords[] = {
    {"disconnect", "Disconnect"},
    {"flag-error", "Inject V4L2_BUF_FLAG_ERROR"},
    {"reqbufs-error", "Inject VIDIOC_REQBUFS Error"},
    {"qbuf-error", "Inject VIDIOC_QBUF Error"},
    {"streamon-error", "Inject VIDIOC_STREAMON Error"},
    {"streaming-error", "Inject Fatal Streaming Error"},
    {"dropped-percent", "Percentage of Dropped Buffers"},
    {"wrap-sequence", "Wrap Sequence Number"},
    {"wrap-timestamp", "Wrap Timestamp"},
    {"timestamp-source", "Timestamp Source"},
};
constexpr const char* kDriver = "/sys/bus/platform/drivers/vivid/";
constexpr std::int64_t kNap_ns = 2'000'000;

/// A line `MS CAMERA WORD [AMOUNT]`, such as `1500 2 disconnect 300`. `start` for MS: before COMMAND starts.
/// AMOUNT is the control's value; for disconnect and unbind the time that it lasts, in ms. `unbind` takes the
/// driver from all devices, whatever the camera.
struct Step {
  std::int64_t after_ns = 0;
  bool before_start = false;
  std::size_t camera = 0;
  std::string word;
  std::int32_t amount = 0;
};

std::vector<Step> read_script(const std::string& path, std::size_t cameras) {
  std::ifstream file(path);
  if (!file) throw Error(path + ": cannot be read");
  std::vector<Step> steps;
  std::string line;
  for (int number = 1; std::getline(file, line); ++number) {
    std::istringstream words(line);
    std::string when;
    Step step;
    words >> when >> step.camera >> step.word;
    step.before_start = when == "start";
    const bool known =
        step.word == "unbind" ||
        std::any_of(std::begin(kWords), std::end(kWords), [&](const Word& w) { return step.word == w.text; });
    double after_ms = 0.0;
    const bool timed = step.before_start || std::istringstream(when) >> after_ms;
    if (!words || !known || !timed || step.camera < 1 || step.camera > cameras)
      throw Error(path + ":" + std::to_string(number) + ": lines are MS CAMERA WORD [AMOUNT]");
    step.after_ns = static_cast<std::int64_t>(after_ms * 1e6);
    words >> step.amount;
    --step.camera;
    steps.push_back(step);
  }
  std::stable_sort(steps.begin(), steps.end(),
                   [](const Step& a, const Step& b) { return a.after_ns < b.after_ns; });
  return steps;
}

std::int64_t now_ns() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

void nap() {
  const timespec time{0, kNap_ns};
  nanosleep(&time, nullptr);
}

void write_word(const std::string& path, const char* word) {
  std::ofstream file(path);
  file << word << std::flush;
  if (!file) throw Error(path + ": refuses " + word);
}

/// Does what the script says, when it says so.
class Faults {
 public:
  Faults(std::vector<std::string> paths, std::vector<Step> steps, double rate_hz)
      : paths_(std::move(paths)), steps_(std::move(steps)), rate_hz_(rate_hz), held_(paths_.size()) {
    set_signals();
    for (; next_ < steps_.size() && steps_[next_].before_start; ++next_) begin(steps_[next_]);
  }

  bool all_stream() const {
    return std::all_of(paths_.begin(), paths_.end(),
                       [](const std::string& path) { return VividDevice(path).in_use(); });
  }

  void do_due(std::int64_t since_start_ns) {
    for (std::size_t c = 0; c < held_.size(); ++c) {
      if (held_[c] && now_ns() >= held_[c]->until_ns) end(c);
    }
    if (bound_again_ns_ && now_ns() >= *bound_again_ns_) bind();
    for (; next_ < steps_.size() && steps_[next_].after_ns <= since_start_ns; ++next_) begin(steps_[next_]);
  }

  void write_log(const std::string& path) const {
    std::ofstream file(path);
    file << "time_ns,camera,fault,event\n" << log_ << std::flush;
    if (!file) throw Error(path + ": cannot be written");
  }

 private:
  struct Held {
    VividDevice device;  // a device that is disconnected stays so until its last user has closed it
    std::int64_t until_ns;
  };

  void set_signals() {
    for (const std::string& path : paths_) VividDevice(path).set_signal(rate_hz_);
  }
  void note(std::size_t camera, const std::string& word, const char* event) {
    log_ += std::to_string(now_ns()) + ',' + std::to_string(camera + 1) + ',' + word + ',' + event + '\n';
  }
  void begin(const Step& step) {
    note(step.camera, step.word, "begin");
    if (step.word == "unbind") {
      write_word(std::string(kDriver) + "unbind", "vivid.0");
      bound_again_ns_ = now_ns() + step.amount * std::int64_t{1'000'000};
      return;
    }
    const char* const control = std::find_if(std::begin(kWords), std::end(kWords), [&](const Word& w) {
                                  return step.word == w.text;
                                })->control;
    VividDevice device(paths_[step.camera]);
    device.set_control(control, step.amount);
    if (step.word == "disconnect")
      held_[step.camera].emplace(Held{std::move(device), now_ns() + step.amount * std::int64_t{1'000'000}});
  }
  void end(std::size_t camera) {
    held_[camera].reset();
    note(camera, "disconnect", "end");
  }
  void bind() {
    bound_again_ns_.reset();
    write_word(std::string(kDriver) + "bind", "vivid.0");
    set_signals();
    note(0, "unbind", "end");
  }

  std::vector<std::string> paths_;
  std::vector<Step> steps_;
  double rate_hz_;
  std::vector<std::optional<Held>> held_;  // by camera
  std::optional<std::int64_t> bound_again_ns_;
  std::size_t next_ = 0;
  std::string log_;
};

int run(int argc, char** argv) {
  const std::vector<std::string> command = take_command(argc, argv);
  std::vector<std::string> paths;
  std::string script, log;
  double rate_hz = 60.0;
  CLI::App app("lets vivid's capture devices go wrong while a command captures from them");
  app.add_option("--device", paths, "such as /dev/video0")->required()->expected(1, 32);
  app.add_option("--rate", rate_hz, "frames per second, nearly")->check(CLI::Range(25.0, 200.0));
  app.add_option("--script", script, "lines MS CAMERA WORD [AMOUNT]");
  app.add_option("--log", log, "CSV of what was done when, written at the end");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    throw UsageError(error.what());
  }
  become_hardware();
  Faults faults(paths, script.empty() ? std::vector<Step>() : read_script(script, paths.size()), rate_hz);
  ReaderCommand reader(command, {});
  std::optional<std::int64_t> start_ns;
  while (!reader.ended()) {
    if (!start_ns && faults.all_stream()) start_ns = now_ns();
    if (start_ns) faults.do_due(now_ns() - *start_ns);
    nap();
  }
  if (!log.empty()) faults.write_log(log);
  return *reader.ended();
}

}  // namespace
}  // namespace glint::device

int main(int argc, char** argv) {
  return glint::device::run_program("vivid_faults", glint::device::run, argc, argv);
}
