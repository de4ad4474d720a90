// SPDX-License-Identifier: MIT
// Rows of text into a file or a pipe: buffered, without allocation once warm, and never half a row.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace glint {

enum class SinkStatus : std::uint8_t {
  Ok,
  Failed,  ///< this call failed, for good: problem() says why. Returned once.
  Lost,    ///< it failed earlier; these rows are counted as lost
};

struct SinkCounters {
  std::uint64_t rows_written = 0;  ///< whole rows handed to the operating system
  std::uint64_t rows_lost = 0;     ///< rows that did not get there
};

/// Thread-bound. A row is built with text(), integer() and number() and ends with end_row(). Regular
/// files are written in blocks; pipes, terminals and devices after every end_group(). When a write
/// fails, a regular file is cut back to its last whole row and nothing more is written. The program
/// must ignore SIGPIPE for a broken pipe to come back as a status.
class RecordFile {
 public:
  /// "-" is standard output. An existing regular file is refused unless `force`. `header` is written
  /// at once and is no row. Throws Error.
  RecordFile(const std::string& path, bool force, std::string_view header = {});
  ~RecordFile();
  RecordFile(const RecordFile&) = delete;
  RecordFile& operator=(const RecordFile&) = delete;

  RecordFile& text(std::string_view characters) noexcept;
  RecordFile& integer(std::int64_t value) noexcept;
  RecordFile& unsigned_integer(std::uint64_t value) noexcept;
  /// Fixed notation; beyond 1e12 the shortest exact one. `if_not_finite` stands for NaN and infinity.
  RecordFile& number(double value, int decimals, std::string_view if_not_finite) noexcept;
  void end_row() noexcept;

  /// What belongs together is complete: time to write if it is due.
  [[nodiscard]] SinkStatus end_group() noexcept;
  [[nodiscard]] SinkStatus flush() noexcept;
  /// Writes the rest and closes. Later rows are lost and counted.
  [[nodiscard]] SinkStatus finish() noexcept;

  const SinkCounters& counters() const noexcept { return counters_; }
  /// Why it failed, with the file's name; empty while all is well.
  const std::string& problem() const noexcept { return problem_; }

 private:
  char* room(std::size_t bytes) noexcept;
  SinkStatus status() noexcept;
  void write_rows() noexcept;
  void fail(const char* doing, int error_number, std::size_t bytes_written) noexcept;
  bool cut_back(std::size_t bytes) noexcept;
  void close_file() noexcept;

  std::string shown_name_;
  int fd_ = -1;
  bool owned_ = false, regular_ = false, failed_ = false, told_ = false, finished_ = false;
  std::vector<char> buffer_;
  std::size_t used_ = 0, row_end_ = 0;  // bytes in buffer_, and those of whole rows
  std::uint64_t rows_buffered_ = 0;
  SinkCounters counters_;
  std::string problem_;
};

}  // namespace glint
