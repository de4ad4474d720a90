// SPDX-License-Identifier: MIT
// The command that reads the devices which a program of this folder plays.
#pragma once

#include <sys/types.h>

#include <optional>
#include <string>
#include <vector>

namespace glint::device {

/// The hardware that the caller stands for does not queue behind other programs: real-time priority for the
/// caller, not for its children. Says so on standard error when refused.
void become_hardware();

/// What follows `--`, cut off the arguments. Throws UsageError when there is nothing.
std::vector<std::string> take_command(int& argc, char** argv);

/// Started, and killed at the end where it still runs.
class ReaderCommand {
 public:
  /// Throws Error. `environment`: NAME=VALUE, beside this program's.
  ReaderCommand(std::vector<std::string> words, const std::vector<std::string>& environment);
  ~ReaderCommand();
  ReaderCommand(const ReaderCommand&) = delete;
  ReaderCommand& operator=(const ReaderCommand&) = delete;

  /// Its exit code, 128 + signal when it was killed; nothing while it runs.
  std::optional<int> ended() noexcept;

 private:
  pid_t process_ = 0;
  std::optional<int> code_;
};

}  // namespace glint::device
