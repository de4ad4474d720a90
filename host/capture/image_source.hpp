// SPDX-License-Identifier: MIT
// Frame sets from stored images, videos and network cameras.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "host/frames/source.hpp"

namespace glint {

struct ImageSourceOptions {
  /// Names in the order that is wanted, normally the rig's; empty: all cameras found, in natural order.
  std::vector<std::string> camera_names;
  /// What the frames must measure, parallel to camera_names; empty, or 0x0 for one camera: any size.
  std::vector<FrameSize> camera_sizes;
  /// Frame sets per second, for recordings that store no time; 0: unknown (see open_image_source).
  double rate_hz = 0.0;
  double open_timeout_s = 5.0;  ///< network: until the first image of each camera
  double silence_s = 3.0;       ///< network: a camera without data for so long is reported and not waited for
  void check(std::vector<std::string>& problems) const;  ///< appends "source.rate_hz must be >= 0", ...
};

/// Opens what stands behind `images:`. `location` is one of
///
///  - a folder with one sub-folder of numbered PGM, PNG, TIFF, JPEG or BMP files per camera. The last number
///  in the file
///    name that tells the files apart is the exposure: files of equal number belong together, a number that
///    one camera lacks is a missing frame, and the number becomes FrameSet::trigger. Where all numbers are
///    multiples of a step apart (0, 10, 20, ...), the numbers between are not expected;
///  - a folder with one video file per camera (its stem is the camera's name) or one sub-folder with one
///  video each;
///    frame n of each belongs to exposure n, from 0;
///  - several of these or of network cameras, comma-separated, one per camera: `name=PATH-OR-URL` or without
///  the name,
///    then cam1, cam2, ... or, if there are as many as camera_names, those in their order. A comma inside an
///    address is written %2C. Stored and network cameras do not mix.
///
/// Stored recordings wait (live() is false) and lose nothing. A frame that cannot be decoded, or has another
/// size than the camera's first, is left out of its set, counted as damaged and named in problem(). Exposure
/// time: `frames.csv` in the folder if it is there (see frame_log.hpp), else a video's own time stamps, else
/// number of steps / rate_hz; without any rate 30 Hz is assumed for that, said in problem(), and rate_hz() is
/// 0.
///
/// Network cameras (live() is true) are not synchronised: each is decoded by a thread of its own, the newest
/// image wins (an image replaced before it was taken is counted as late), a set holds what arrived within
/// about one frame period, and its time is the arrival of the earliest of them. A camera that stops does not
/// stop the others. While no camera gives anything read() returns an empty set every second; it ends when all
/// have hung up. Passwords in addresses are never repeated in messages.
///
/// Colour becomes luma, video range becomes full range, deeper images are scaled to 8 bits (said in
/// problem()). Throws Error: nothing there, names or sizes that do not match (both sides are listed), the
/// first frame of a camera unreadable, no image from a network camera in time.
std::unique_ptr<FrameSource> open_image_source(const std::string& location,
                                               const ImageSourceOptions& options);

}  // namespace glint
