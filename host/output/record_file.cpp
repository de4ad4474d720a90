// SPDX-License-Identifier: MIT
// Rows of text into a file descriptor.
#include "host/output/record_file.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <new>
#include <system_error>

#include "host/base/error.hpp"

namespace glint {

namespace {

constexpr std::size_t kBlockBytes = std::size_t{64} * 1024;  // regular files are written in such blocks
constexpr std::size_t kFirstBufferBytes = 4 * kBlockBytes;   // a block and one tick of many points
constexpr std::size_t kLongestNumber = 400;                  // a double of 1e12 with many decimals fits

std::string reason(int error_number) { return std::generic_category().message(error_number); }

int open_for_rows(const std::string& path, bool force) {
  constexpr int kFlags = O_WRONLY | O_CREAT | O_CLOEXEC | O_NOCTTY;
  constexpr mode_t kMode = 0666;  // less the user's umask
  int fd = ::open(path.c_str(), kFlags | O_EXCL, kMode);
  if (fd >= 0) return fd;
  int why = errno;
  if (why == EEXIST) {
    struct stat info {};
    const bool known = ::stat(path.c_str(), &info) == 0;
    if (known && S_ISREG(info.st_mode) && !force) {
      throw Error(path + ": the file exists already; choose another name or add --force to replace it");
    }
    fd = ::open(path.c_str(), known && S_ISREG(info.st_mode) ? kFlags | O_TRUNC : kFlags, kMode);
    if (fd >= 0) return fd;
    why = errno;
  }
  const std::string what_to_do = why == ENOENT    ? "; make its folder first"
                                 : why == EISDIR  ? "; name a file in it"
                                 : why == EACCES  ? "; check the folder's permissions"
                                 : why == ENOTDIR ? "; a part of the path is a file"
                                                  : "";
  throw Error(path + ": cannot write: " + reason(why) + what_to_do);
}

}  // namespace

RecordFile::RecordFile(const std::string& path, bool force, std::string_view header)
    : shown_name_(path == "-" ? "standard output" : path) {
  owned_ = path != "-";
  // Everything that can throw comes before the file is opened, so that nothing is left open.
  buffer_.resize(kFirstBufferBytes);
  problem_.reserve(512);
  fd_ = owned_ ? open_for_rows(path, force) : STDOUT_FILENO;
  struct stat info {};
  const bool known = ::fstat(fd_, &info) == 0;
  regular_ = known && S_ISREG(info.st_mode);
  if (header.empty()) return;
  text(header);
  row_end_ = used_;
  write_rows();
  if (failed_) {
    close_file();
    throw Error(problem_);
  }
}

RecordFile::~RecordFile() { static_cast<void>(finish()); }

char* RecordFile::room(std::size_t bytes) noexcept {
  if (failed_) return nullptr;
  if (used_ + bytes > buffer_.size()) {
    try {
      buffer_.resize(2 * (used_ + bytes));
    } catch (const std::bad_alloc&) {
      fail("keep rows for", ENOMEM, 0);
      return nullptr;
    }
  }
  return buffer_.data() + used_;
}

RecordFile& RecordFile::text(std::string_view characters) noexcept {
  if (char* to = room(characters.size())) {
    std::copy(characters.begin(), characters.end(), to);
    used_ += characters.size();
  }
  return *this;
}

RecordFile& RecordFile::integer(std::int64_t value) noexcept {
  if (char* to = room(kLongestNumber)) {
    used_ += static_cast<std::size_t>(std::to_chars(to, to + kLongestNumber, value).ptr - to);
  }
  return *this;
}

RecordFile& RecordFile::unsigned_integer(std::uint64_t value) noexcept {
  if (char* to = room(kLongestNumber)) {
    used_ += static_cast<std::size_t>(std::to_chars(to, to + kLongestNumber, value).ptr - to);
  }
  return *this;
}

RecordFile& RecordFile::number(double value, int decimals, std::string_view if_not_finite) noexcept {
  if (!std::isfinite(value)) return text(if_not_finite);
  if (char* to = room(kLongestNumber)) {
    char* const end = to + kLongestNumber;
    const std::to_chars_result result =
        std::abs(value) < 1e12 ? std::to_chars(to, end, value, std::chars_format::fixed, decimals)
                               : std::to_chars(to, end, value);
    used_ += static_cast<std::size_t>(result.ptr - to);
  }
  return *this;
}

void RecordFile::end_row() noexcept {
  text("\n");
  if (failed_) {
    ++counters_.rows_lost;
    return;
  }
  row_end_ = used_;
  ++rows_buffered_;
}

SinkStatus RecordFile::status() noexcept {
  if (!failed_) return SinkStatus::Ok;
  if (told_) return SinkStatus::Lost;
  told_ = true;
  return SinkStatus::Failed;
}

SinkStatus RecordFile::end_group() noexcept {
  if (!regular_ || row_end_ >= kBlockBytes) write_rows();
  return status();
}

SinkStatus RecordFile::flush() noexcept {
  write_rows();
  return status();
}

void RecordFile::write_rows() noexcept {
  if (failed_ || row_end_ == 0) return;
  std::size_t done = 0;
  while (done < row_end_) {
    const ssize_t n = ::write(fd_, buffer_.data() + done, row_end_ - done);
    if (n > 0) {
      done += static_cast<std::size_t>(n);
      continue;
    }
    if (n < 0 && errno == EINTR) continue;
    if (n < 0 && errno == EAGAIN) {  // somebody made the terminal or pipe non-blocking
      pollfd wait{fd_, POLLOUT, 0};
      static_cast<void>(::poll(&wait, 1, -1));
      continue;
    }
    fail("write", n < 0 ? errno : ENOSPC, done);
    return;
  }
  counters_.rows_written += rows_buffered_;
  rows_buffered_ = 0;
  std::copy(buffer_.data() + row_end_, buffer_.data() + used_, buffer_.data());
  used_ -= row_end_;
  row_end_ = 0;
}

void RecordFile::fail(const char* doing, int error_number, std::size_t bytes_written) noexcept {
  failed_ = true;
  // Rows end with a line feed and hold no other, so the last one in what got through ends the last whole row.
  const char* const begin = buffer_.data();
  std::size_t kept = bytes_written;
  while (kept > 0 && begin[kept - 1] != '\n') --kept;
  const auto rows_kept =
      std::min(rows_buffered_, static_cast<std::uint64_t>(std::count(begin, begin + kept, '\n')));
  counters_.rows_written += rows_kept;
  counters_.rows_lost += rows_buffered_ - rows_kept;
  rows_buffered_ = 0;
  used_ = row_end_ = 0;
  const bool cut = !regular_ || kept == bytes_written || cut_back(bytes_written - kept);
  try {
    problem_ = shown_name_ + ": cannot " + doing + ": " + reason(error_number) + "; " +
               std::to_string(counters_.rows_written) + " whole rows are there, the rest is lost" +
               (cut ? "" : "; the last row may be incomplete");
  } catch (const std::bad_alloc&) {
    problem_ = "cannot write";  // fits without allocation
  }
}

bool RecordFile::cut_back(std::size_t bytes) noexcept {
  struct stat info {};
  const off_t position = ::lseek(fd_, 0, SEEK_CUR);
  // Standard output may be a file that others write to as well: cut only what is our own tail.
  if (position < 0 || ::fstat(fd_, &info) != 0 || info.st_size != position) return false;
  const off_t end = position - static_cast<off_t>(bytes);
  return ::ftruncate(fd_, end) == 0 && ::lseek(fd_, end, SEEK_SET) == end;
}

SinkStatus RecordFile::finish() noexcept {
  if (finished_) return problem_.empty() ? SinkStatus::Ok : SinkStatus::Lost;
  finished_ = true;
  write_rows();
  if (fd_ >= 0 && owned_) {
    // Network file systems and quotas report late: on close.
    const int fd = fd_;
    fd_ = -1;
    if (::close(fd) != 0 && errno != EINTR && !failed_) {
      regular_ = false;
      fail("close", errno, 0);
    }
  }
  const SinkStatus result = status();
  if (!failed_) {
    failed_ = told_ = true;  // closed: what comes now is lost
  }
  return result;
}

void RecordFile::close_file() noexcept {
  if (fd_ >= 0 && owned_) ::close(fd_);
  fd_ = -1;
}

}  // namespace glint
