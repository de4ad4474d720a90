// SPDX-License-Identifier: MIT
// Runs a command and writes down what it says on standard error, and when.
//   stamp_lines FILE COMMAND ARGUMENT...
// Each line of FILE is a time of CLOCK_MONOTONIC in nanoseconds, a blank, and a line of the command. Ends as
// the command did; if that was badly, repeats what it said.
#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <string>

#include "host/base/error.hpp"
#include "tests/device/program/program.hpp"
#include "tests/device/reader_command/reader_command.hpp"

namespace glint::device {
namespace {

std::string now_ns() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return std::to_string(std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec);
}

/// Starts the command with its standard error in a pipe; returns the end that is read from.
int start(char** argv, pid_t& process) {
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) throw Error(std::string("pipe: ") + std::strerror(errno));
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, ends[1], STDERR_FILENO);
  const int reason = posix_spawnp(&process, argv[0], &actions, nullptr, argv, environ);
  posix_spawn_file_actions_destroy(&actions);
  close(ends[1]);
  if (reason != 0) throw Error(std::string(argv[0]) + ": cannot be started: " + std::strerror(reason));
  return ends[0];
}

/// Everything that comes, each line with the time of its first byte.
std::string stamped(int from) {
  std::string text;
  char chunk[4096];
  for (ssize_t got; (got = read(from, chunk, sizeof chunk)) > 0;) {
    for (ssize_t n = 0; n < got; ++n) {
      if (text.empty() || text.back() == '\n') text += now_ns() + ' ';
      text += chunk[n];
    }
  }
  return text;
}

int run(int argc, char** argv) {
  if (argc < 3) throw UsageError("needs FILE COMMAND ARGUMENT...");
  become_hardware();
  pid_t process = 0;
  const int from = start(argv + 2, process);
  const std::string text = stamped(from);
  close(from);
  int status = 0;
  while (waitpid(process, &status, 0) < 0 && errno == EINTR) {
  }
  const int code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  if (code != 0) std::fputs(text.c_str(), stderr);
  std::FILE* const file = std::fopen(argv[1], "w");
  const bool written = file != nullptr && std::fputs(text.c_str(), file) >= 0;
  if (file == nullptr || std::fclose(file) != 0 || !written)
    throw Error(std::string(argv[1]) + ": cannot be written");
  return code;
}

}  // namespace
}  // namespace glint::device

int main(int argc, char** argv) {
  return glint::device::run_program("stamp_lines", glint::device::run, argc, argv);
}
