// SPDX-License-Identifier: MIT
// fork and exec with both outputs in temporary files.
#include "tests/system/run_glint.hpp"

#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <thread>

#include "tests/support/temp_dir.hpp"

namespace glint::test {
namespace {

std::string text_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

[[noreturn]] void become_glint(const std::vector<std::string>& arguments, const RunOptions& options,
                               const std::string& out, const std::string& err) {
  const int to_out = open(out.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  const int to_err = open(err.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  dup2(to_out, STDOUT_FILENO);
  dup2(to_err, STDERR_FILENO);
  for (const std::string& variable : options.environment) putenv(strdup(variable.c_str()));
  const char* const program = options.program.empty() ? GLINT_PROGRAM : options.program.c_str();
  std::vector<char*> argv{strdup(program)};
  for (const std::string& argument : arguments) argv.push_back(strdup(argument.c_str()));
  argv.push_back(nullptr);
  execv(program, argv.data());
  _exit(127);
}

}  // namespace

Outcome run_glint(const std::vector<std::string>& arguments, const RunOptions& options) {
  const TempDir folder;
  const std::string out =
      options.standard_output.empty() ? (folder.path() / "out").string() : options.standard_output;
  const std::string err = (folder.path() / "err").string();
  const pid_t child = fork();
  if (child < 0) throw std::runtime_error("fork failed");
  if (child == 0) become_glint(arguments, options, out, err);
  if (options.interrupt_after_s > 0.0) {
    std::this_thread::sleep_for(std::chrono::duration<double>(options.interrupt_after_s));
    kill(child, SIGINT);
  }
  int status = 0;
  waitpid(child, &status, 0);
  Outcome outcome;
  outcome.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  if (options.standard_output.empty()) outcome.out = text_of(out);
  outcome.err = text_of(err);
  return outcome;
}

}  // namespace glint::test
