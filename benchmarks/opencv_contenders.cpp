// SPDX-License-Identifier: MIT
// OpenCV pipelines, image by image. All images live in state that is kept from tick to tick, so that none is
// allocated anew.
#include "benchmarks/opencv_contenders.hpp"

#include <memory>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "gpu/cpu/workers.hpp"

namespace glint::benchmarks {
namespace {

constexpr double kThesisThreshold = 200.0;

/// One camera: what is known before the first frame, and the images in between.
struct Camera {
  cv::Mat background, matrix, distortion, map1, map2;
  cv::Mat difference, undistorted, blurred, bright;
  std::vector<std::vector<cv::Point>> contours;
  std::vector<cv::Point2d> centres, undistorted_centres;
};

std::size_t find_centres(Camera& camera, cv::Mat& bright) {
  cv::findContours(bright, camera.contours, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_NONE);
  camera.centres.clear();
  for (const auto& contour : camera.contours) {
    const cv::Moments m = cv::moments(contour);
    if (m.m00 > 0.0) {
      camera.centres.emplace_back(m.m10 / m.m00, m.m01 / m.m00);
    } else {  // a line or a point has no area inside its contour
      camera.centres.emplace_back(contour.front());
    }
  }
  return camera.centres.size();
}

std::size_t blur_and_find(Camera& camera) {
  cv::GaussianBlur(camera.undistorted, camera.blurred, cv::Size(5, 5), 0.0);
  cv::threshold(camera.blurred, camera.bright, kThesisThreshold, 255.0, cv::THRESH_BINARY);
  return find_centres(camera, camera.bright);
}

std::size_t thesis(Camera& camera, const cv::Mat& frame) {
  cv::subtract(frame, camera.background, camera.difference);
  cv::undistort(camera.difference, camera.undistorted, camera.matrix, camera.distortion);
  return blur_and_find(camera);
}

std::size_t thesis_with_maps(Camera& camera, const cv::Mat& frame) {
  cv::subtract(frame, camera.background, camera.difference);
  cv::remap(camera.difference, camera.undistorted, camera.map1, camera.map2, cv::INTER_LINEAR);
  return blur_and_find(camera);
}

std::size_t lean(Camera& camera, const cv::Mat& frame, double margin) {
  cv::subtract(frame, camera.background, camera.difference);
  cv::threshold(camera.difference, camera.bright, margin, 255.0, cv::THRESH_BINARY);
  const std::size_t found = find_centres(camera, camera.bright);
  if (found > 0) {
    cv::undistortPoints(camera.centres, camera.undistorted_centres, camera.matrix, camera.distortion);
  }
  return found;
}

/// The cameras of a scene, worked through by one thread or more.
class Pipeline {
 public:
  using Step = std::function<std::size_t(Camera&, const cv::Mat&)>;

  Pipeline(const Scene& scene, unsigned threads, Step step)
      : scene_(scene),
        step_(std::move(step)),
        found_(scene.options().cameras),
        workers_(threads - 1, 1, scene.options().cameras, &Pipeline::work, this) {
    const SceneOptions& o = scene.options();
    const int rows = static_cast<int>(o.height_px), columns = static_cast<int>(o.width_px);
    const std::vector<gpu::CameraFormat> formats = scene.formats();
    for (unsigned i = 0; i < o.cameras; ++i) {
      Camera& camera = cameras_.emplace_back();
      camera.background = cv::Mat(rows, columns, CV_8UC1);
      std::copy(scene.background(i).begin(), scene.background(i).end(), camera.background.data);
      const gpu::Lens& lens = formats[i].lens;
      camera.matrix =
          (cv::Mat_<double>(3, 3) << lens.fx_px, 0, lens.cx_px, 0, lens.fy_px, lens.cy_px, 0, 0, 1);
      camera.distortion = cv::Mat(lens.k1_k2_p1_p2_k3, true);
      cv::initUndistortRectifyMap(camera.matrix, camera.distortion, cv::Mat(), camera.matrix, {columns, rows},
                                  CV_16SC2, camera.map1, camera.map2);
    }
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
  std::vector<Camera> cameras_;
  std::vector<std::size_t> found_;
  gpu::Workers workers_;
};

}  // namespace

std::vector<Contender> opencv_contenders(const Scene& scene) {
  cv::setNumThreads(1);  // threads are ours: one camera each is quicker than splitting images
  const double margin = scene.options().margin;
  const std::vector<std::pair<std::string, Pipeline::Step>> ways = {
      {"OpenCV, thesis", thesis},
      {"OpenCV, thesis with precomputed maps", thesis_with_maps},
      {"OpenCV, lean",
       [margin](Camera& camera, const cv::Mat& frame) { return lean(camera, frame, margin); }}};
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
