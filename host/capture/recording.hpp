// SPDX-License-Identifier: MIT
// The stored frames of one camera, in order: numbered image files, or a video.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/capture/grey_target.hpp"

namespace glint {

class Recording {
 public:
  virtual ~Recording() = default;
  /// Of its first frame, which is readable: the makers below throw Error if it is not.
  virtual FrameSize size() const noexcept = 0;
  virtual double rate_hz() const noexcept = 0;  ///< 0: not stored
  /// The path of the first frame or the video, for messages.
  virtual const std::string& first_path() const noexcept = 0;
  /// The numbers of all frames in order, where they are known beforehand.
  virtual const std::vector<std::uint64_t>& numbers() const noexcept = 0;

  /// Number of the frame that comes next, nothing at the end. Videos decode it here.
  virtual std::optional<std::uint64_t> next_number() = 0;
  /// Its own time stamp, counted from the first frame; after next_number().
  virtual std::optional<double> next_time_s() const = 0;
  /// Takes the next frame: writes it to `target`, which has size(), and goes on. False if it is damaged or
  /// has another size: problem() says why, naming the file.
  virtual bool take(const GreyTarget& target) = 0;
  /// Goes on without decoding more than needed.
  virtual void skip() = 0;
  /// Whether any frame so far had more than 8 bits a pixel.
  virtual bool deep() const noexcept = 0;
  /// Of take(), or at the end why it came early ("" if it did not).
  virtual const std::string& problem() const noexcept = 0;
};

/// The image files among `files`; those whose names hold no number are appended to `ignored`. Throws Error if
/// two have the same number, none has one, or the first cannot be decoded.
std::unique_ptr<Recording> open_still_recording(std::vector<std::filesystem::path> files,
                                                std::vector<std::string>& ignored);
/// Throws Error.
std::unique_ptr<Recording> open_video_recording(const std::filesystem::path& file);

}  // namespace glint
