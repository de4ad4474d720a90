// SPDX-License-Identifier: MIT
// posix_spawn and waitpid.
#include "tests/device/reader_command/reader_command.hpp"

#include <sched.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string_view>

#include "host/base/error.hpp"

namespace glint::device {

void become_hardware() {
  sched_param priority{};
  priority.sched_priority = 50;
  if (sched_setscheduler(0, SCHED_FIFO | SCHED_RESET_ON_FORK, &priority) != 0)
    std::fprintf(stderr, "no real-time priority: %s\n", std::strerror(errno));
}

std::vector<std::string> take_command(int& argc, char** argv) {
  char** const end = argv + argc;
  char** const mark =
      std::find_if(argv, end, [](const char* word) { return std::string_view(word) == "--"; });
  if (end - mark < 2) throw UsageError("no command after --");
  argc = static_cast<int>(mark - argv);
  return {mark + 1, end};
}

ReaderCommand::ReaderCommand(std::vector<std::string> words, const std::vector<std::string>& environment) {
  std::vector<std::string> all = environment;
  for (char** variable = environ; *variable != nullptr; ++variable) all.emplace_back(*variable);
  const auto pointers = [](std::vector<std::string>& texts) {
    std::vector<char*> list;
    for (std::string& text : texts) list.push_back(text.data());
    list.push_back(nullptr);
    return list;
  };
  const std::vector<char*> argv = pointers(words), envp = pointers(all);
  if (const int reason = posix_spawnp(&process_, argv[0], nullptr, nullptr, argv.data(), envp.data());
      reason != 0)
    throw Error(words[0] + ": cannot be started: " + std::strerror(reason));
}

ReaderCommand::~ReaderCommand() {
  if (ended()) return;
  kill(process_, SIGKILL);
  waitpid(process_, nullptr, 0);
}

std::optional<int> ReaderCommand::ended() noexcept {
  int status = 0;
  if (!code_ && waitpid(process_, &status, WNOHANG) == process_)
    code_ = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return code_;
}

}  // namespace glint::device
