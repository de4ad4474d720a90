// SPDX-License-Identifier: MIT
// Small text files: read whole, written whole or not at all.
#include "host/files/text_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>

#include "host/base/error.hpp"

namespace glint {
namespace {

[[noreturn]] void fail(const std::filesystem::path& path, const std::string& what) {
  throw Error(path.string() + ": " + what);
}

std::string reason(int error_number) { return std::strerror(error_number); }

/// A file descriptor that closes itself.
class Descriptor {
 public:
  explicit Descriptor(int number) noexcept : number_(number) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() {
    if (number_ >= 0) ::close(number_);
  }
  int number() const noexcept { return number_; }
  /// 0, or errno: some file systems report a full disk only here.
  int close() noexcept {
    const int result = ::close(number_);
    number_ = -1;
    return result == 0 ? 0 : errno;
  }

 private:
  int number_;
};

/// 0, or errno.
int write_all(int descriptor, std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = ::write(descriptor, text.data(), text.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return errno;
    text.remove_prefix(static_cast<std::size_t>(written));
  }
  return ::fsync(descriptor) == 0 || errno == EINVAL || errno == EROFS ? 0 : errno;
}

/// 0, or errno; EEXIST where the target is there and must not be replaced.
int move_into_place(const char* from, const char* to, bool force) {
  if (force) return std::rename(from, to) == 0 ? 0 : errno;
  if (::renameat2(AT_FDCWD, from, AT_FDCWD, to, RENAME_NOREPLACE) == 0) return 0;
  if (errno != EINVAL && errno != ENOSYS) return errno;
  // This file system cannot promise it in one step.
  struct ::stat status {};
  if (::lstat(to, &status) == 0) return EEXIST;
  return std::rename(from, to) == 0 ? 0 : errno;
}

}  // namespace

std::string read_text_file(const std::filesystem::path& path, std::size_t max_bytes) {
  Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (file.number() < 0) fail(path, "cannot be read: " + reason(errno));
  std::string text;
  std::string part(64 * 1024, '\0');
  for (;;) {
    const ssize_t got = ::read(file.number(), part.data(), part.size());
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) fail(path, "cannot be read: " + reason(errno));
    if (got == 0) return text;
    text.append(part, 0, static_cast<std::size_t>(got));
    if (text.size() > max_bytes) {
      fail(path, "is larger than " + std::to_string(max_bytes) + " bytes; is it the right file?");
    }
  }
}

void write_text_file(const std::filesystem::path& path, std::string_view text, bool force) {
  const std::string exists = "exists already and is not overwritten; choose another name or give --force";
  struct ::stat status {};
  if (!force && ::lstat(path.c_str(), &status) == 0) fail(path, exists);

  const std::string temporary = path.string() + "." + std::to_string(::getpid()) + ".tmp";
  Descriptor file(::open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666));
  if (file.number() < 0) fail(path, "cannot be written: " + reason(errno));
  int error = write_all(file.number(), text);
  const int close_error = file.close();
  if (error == 0) error = close_error;
  if (error == 0) error = move_into_place(temporary.c_str(), path.c_str(), force);
  if (error == 0) return;
  ::unlink(temporary.c_str());
  fail(path, error == EEXIST && !force ? exists : "cannot be written: " + reason(error));
}

}  // namespace glint
