// SPDX-License-Identifier: MIT
// A video file as the recording of one camera: frame n, from 0, is exposure n.
#include "host/base/error.hpp"
#include "host/capture/recording.hpp"
#include "host/capture/video_decoder.hpp"

namespace glint {
namespace {

class VideoRecording final : public Recording {
 public:
  explicit VideoRecording(const std::filesystem::path& file)
      : path_(file.string()), decoder_(path_, {}), size_(decoder_.size()) {}

  FrameSize size() const noexcept override { return size_; }
  double rate_hz() const noexcept override { return decoder_.rate_hz(); }
  const std::string& first_path() const noexcept override { return path_; }
  const std::vector<std::uint64_t>& numbers() const noexcept override { return numbers_; }
  bool deep() const noexcept override { return deep_; }
  const std::string& problem() const noexcept override { return problem_; }

  std::optional<std::uint64_t> next_number() override {
    if (!decoded_) {
      step_ = decoder_.next();
      decoded_ = true;
      if (step_ == VideoDecoder::Step::End) say_why_it_ended();
    }
    if (step_ == VideoDecoder::Step::End) return std::nullopt;
    return number_;
  }

  std::optional<double> next_time_s() const override {
    return step_ == VideoDecoder::Step::Frame ? decoder_.time_s() : std::nullopt;
  }

  bool take(const GreyTarget& target) override {
    const std::string frame = path_ + ": frame " + std::to_string(number_);
    skip();
    if (step_ != VideoDecoder::Step::Frame) {
      problem_ = frame + " is damaged: " + decoder_.problem();
      return false;
    }
    const FrameSize size = decoder_.size();
    if (size.width_px != size_.width_px || size.height_px != size_.height_px) {
      problem_ = frame + " is " + std::to_string(size.width_px) + "x" + std::to_string(size.height_px) +
                 ", but the first is " + std::to_string(size_.width_px) + "x" +
                 std::to_string(size_.height_px);
      return false;
    }
    deep_ = deep_ || decoder_.deep();
    if (decoder_.copy_to(target)) return true;
    problem_ = frame + ": " + decoder_.problem();
    return false;
  }

  void skip() override {
    ++number_;
    decoded_ = false;
  }

 private:
  void say_why_it_ended() {
    problem_.clear();
    const std::uint64_t promised = decoder_.frames_promised();
    if (promised > number_) {
      problem_ = path_ + ": ends after " + std::to_string(number_) + " frames, its header promises " +
                 std::to_string(promised);
    }
    if (!decoder_.problem().empty() && promised > number_) problem_ += " (" + decoder_.problem() + ")";
  }

  std::string path_, problem_;
  VideoDecoder decoder_;
  FrameSize size_;
  std::vector<std::uint64_t> numbers_;
  std::uint64_t number_ = 0;
  VideoDecoder::Step step_ = VideoDecoder::Step::End;
  bool decoded_ = false, deep_ = false;
};

}  // namespace

std::unique_ptr<Recording> open_video_recording(const std::filesystem::path& file) {
  return std::make_unique<VideoRecording>(file);
}

}  // namespace glint
