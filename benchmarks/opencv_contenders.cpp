// SPDX-License-Identifier: MIT
// OpenCV pipelines, image by image, and their threads.
#include "benchmarks/opencv_contenders.hpp"

#include <memory>
#include <utility>

#include "benchmarks/opencv_steps.hpp"
#include "gpu/cpu/workers.hpp"

namespace glint::benchmarks {
namespace {

/// The cameras of a scene, worked through by one thread or more.
class Pipeline {
 public:
  using Step = std::function<std::size_t(OpenCvCamera&, const cv::Mat&)>;

  Pipeline(const Scene& scene, unsigned threads, Step step)
      : scene_(scene),
        step_(std::move(step)),
        found_(scene.options().cameras),
        workers_(threads - 1, 1, scene.options().cameras, &Pipeline::work, this) {
    const std::vector<gpu::CameraFormat> formats = scene.formats();
    for (unsigned i = 0; i < scene.options().cameras; ++i)
      cameras_.emplace_back(formats[i], scene.background(i));
  }

  std::size_t run(unsigned tick) {
    tick_ = tick;
    workers_.start();
    workers_.finish(0);
    std::size_t sum = 0;
    for (const std::size_t found : found_) sum += found;
    return sum;
  }

 private:
  static void work(void* context, unsigned, unsigned item) noexcept {
    Pipeline& self = *static_cast<Pipeline*>(context);
    const SceneOptions& o = self.scene_.options();
    const cv::Mat frame(static_cast<int>(o.height_px), static_cast<int>(o.width_px), CV_8UC1,
                        self.scene_.pixels(self.tick_, item), self.scene_.stride_bytes());
    self.found_[item] = self.step_(self.cameras_[item], frame);
  }

  const Scene& scene_;
  Step step_;
  unsigned tick_ = 0;
  std::vector<OpenCvCamera> cameras_;
  std::vector<std::size_t> found_;
  gpu::Workers workers_;
};

}  // namespace

std::vector<Contender> opencv_contenders(const Scene& scene) {
  cv::setNumThreads(1);  // threads are ours: one camera each is quicker than splitting images
  const double margin = scene.options().margin;
  const std::vector<std::pair<std::string, Pipeline::Step>> ways = {
      {"OpenCV, thesis", &OpenCvCamera::thesis},
      {"OpenCV, thesis with precomputed maps", &OpenCvCamera::thesis_with_maps},
      {"OpenCV, lean",
       [margin](OpenCvCamera& camera, const cv::Mat& frame) { return camera.lean(frame, margin); }}};
  std::vector<Contender> contenders;
  for (const auto& [name, step] : ways) {
    for (const unsigned threads : {1u, 2u}) {
      const auto pipeline = std::make_shared<Pipeline>(scene, threads, step);
      contenders.push_back({name + ", " + std::to_string(threads) + (threads == 1 ? " thread" : " threads"),
                            [pipeline](unsigned tick) { return pipeline->run(tick); }});
    }
  }
  return contenders;
}

}  // namespace glint::benchmarks
