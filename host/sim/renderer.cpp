// SPDX-License-Identifier: MIT
// Puts markers, backdrop and noise together.
#include "host/sim/renderer.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "host/sim/faults.hpp"

namespace glint::sim {
namespace {

bool overlap(const PixelBox& a, const PixelBox& b) noexcept {
  return a.x_min_px <= b.x_max_px && b.x_min_px <= a.x_max_px && a.y_min_px <= b.y_max_px &&
         b.y_min_px <= a.y_max_px;
}

/// Twelve random bits at a time out of words of 64.
class Bits12 {
 public:
  explicit Bits12(Random& random) : random_(random) {}
  std::uint64_t next() noexcept {
    if (left_ == 0) {
      word_ = random_.bits();
      left_ = 5;
    }
    --left_;
    const std::uint64_t bits = word_ & 4095u;
    word_ >>= 12;
    return bits;
  }

 private:
  Random& random_;
  std::uint64_t word_ = 0;
  unsigned left_ = 0;
};

}  // namespace

Renderer::Renderer(const Scene& scene)
    : scene_(scene),
      noise_(scene.options()),
      painter_(scene),
      views_(scene.markers()),
      light_(std::size_t{scene.options().width_px} * scene.options().height_px) {
  for (std::uint32_t c = 0; c < scene.cameras(); ++c) backdrops_.emplace_back(scene, c, noise_, normal_);
}

void Renderer::render(std::uint32_t camera, std::uint64_t tick, std::uint8_t* pixels,
                      std::uint32_t stride_bytes, BufferMemory& memory) {
  const std::uint32_t taken_by = scene_.behind(camera, tick);
  const Backdrop& backdrop = backdrops_[taken_by];
  if (memory.backdrop != taken_by) {  // two cameras were swapped: nothing of the buffer is of use
    memory.backdrop = taken_by;
    memory.stripe.fill(BufferMemory::kUnknown);
  }
  restore(backdrop, tick, pixels, stride_bytes, memory);
  collect_light(camera, tick, memory.drawn);

  const std::uint32_t width = scene_.options().width_px;
  Random random(stream_seed(scene_.options().seed, Stream::FrameNoise, camera, tick));
  Bits12 bits(random);
  for (const PixelBox& box : memory.drawn) {
    for (int y = box.y_min_px; y <= box.y_max_px; ++y) {
      const auto row = static_cast<std::uint32_t>(y);
      const std::uint16_t* mean = backdrop.mean_row(row);
      float* light = light_.data() + std::size_t{row} * width;
      std::uint8_t* out = pixels + std::size_t{row} * stride_bytes;
      for (int x = box.x_min_px; x <= box.x_max_px; ++x) {
        const float grey = static_cast<float>(mean[x]) * Backdrop::kMeanStep + light[x];
        out[x] = to_pixel(grey + std::sqrt(noise_.variance_grey2(grey)) * normal_[bits.next()]);
      }
      std::fill(light + box.x_min_px, light + box.x_max_px + 1, 0.0f);
    }
  }
  add_blinks(camera, tick, pixels, stride_bytes, memory.drawn);
}

void Renderer::add_blinks(std::uint32_t camera, std::uint64_t tick, std::uint8_t* pixels,
                          std::uint32_t stride_bytes, std::vector<PixelBox>& boxes) const {
  Blinks blinks(scene_.options(), camera, tick);
  for (std::uint32_t i = 0; i < blinks.count(); ++i) {
    const Blink blink = blinks.next();
    const PixelBox box{blink.x_px, blink.y_px, blink.x_px + blink.size_px - 1,
                       blink.y_px + blink.size_px - 1};
    for (int y = box.y_min_px; y <= box.y_max_px; ++y) {
      std::uint8_t* row = pixels + static_cast<std::size_t>(y) * stride_bytes;
      for (int x = box.x_min_px; x <= box.x_max_px; ++x) row[x] = std::max(row[x], blink.grey);
    }
    boxes.push_back(box);
  }
}

void Renderer::restore(const Backdrop& backdrop, std::uint64_t tick, std::uint8_t* pixels,
                       std::uint32_t stride_bytes, BufferMemory& memory) const {
  const std::uint32_t width = scene_.options().width_px, height = scene_.options().height_px;
  std::array<bool, Backdrop::kStripes> changes{};
  for (std::uint32_t s = 0; s < Backdrop::kStripes; ++s) {
    const std::uint8_t wanted = backdrop.frame_of(tick, s);
    changes[s] = memory.stripe[s] != wanted;
    memory.stripe[s] = wanted;
    if (!changes[s]) continue;
    const std::uint32_t end = std::min(height, (s + 1) * backdrop.stripe_rows());
    for (std::uint32_t y = s * backdrop.stripe_rows(); y < end; ++y) {
      std::memcpy(pixels + std::size_t{y} * stride_bytes, backdrop.row(wanted, y), width);
    }
  }
  for (const PixelBox& box : memory.drawn) {
    const auto bytes = static_cast<std::size_t>(box.x_max_px - box.x_min_px + 1);
    for (int y = box.y_min_px; y <= box.y_max_px; ++y) {
      const auto row = static_cast<std::uint32_t>(y);
      const std::uint32_t stripe = row / backdrop.stripe_rows();
      if (changes[stripe]) continue;
      std::memcpy(pixels + std::size_t{row} * stride_bytes + box.x_min_px,
                  backdrop.row(memory.stripe[stripe], row) + box.x_min_px, bytes);
    }
  }
  memory.drawn.clear();
}

void Renderer::collect_light(std::uint32_t camera, std::uint64_t tick, std::vector<PixelBox>& boxes) {
  boxes.clear();
  if (scene_.dark(tick)) return;
  scene_.views(camera, tick, views_);
  const std::uint32_t width = scene_.options().width_px;
  for (std::uint32_t m = 0; m < scene_.markers(); ++m) {
    const Patch* patch = painter_.paint(camera, tick, m, views_, false);
    if (patch == nullptr) continue;
    for (int y = 0; y < patch->height_px(); ++y) {
      float* light =
          light_.data() + static_cast<std::size_t>(patch->y_min_px() + y) * width + patch->x_min_px();
      const float* row = patch->row(y);
      for (int x = 0; x < patch->width_px(); ++x) light[x] += row[x];
    }
    boxes.push_back({patch->x_min_px(), patch->y_min_px(), patch->x_min_px() + patch->width_px() - 1,
                     patch->y_min_px() + patch->height_px() - 1});
  }
  merge_overlapping(boxes);
}

void Renderer::merge_overlapping(std::vector<PixelBox>& boxes) const {
  // Each pixel must be drawn once; a merged box may reach a third one, hence the restart.
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    for (std::size_t j = i + 1; j < boxes.size();) {
      if (!overlap(boxes[i], boxes[j])) {
        ++j;
        continue;
      }
      boxes[i] = {
          std::min(boxes[i].x_min_px, boxes[j].x_min_px), std::min(boxes[i].y_min_px, boxes[j].y_min_px),
          std::max(boxes[i].x_max_px, boxes[j].x_max_px), std::max(boxes[i].y_max_px, boxes[j].y_max_px)};
      boxes[j] = boxes.back();
      boxes.pop_back();
      j = i + 1;
    }
  }
}

std::vector<float> Renderer::light(std::uint32_t camera, std::uint64_t tick) {
  std::vector<PixelBox> boxes;
  collect_light(camera, tick, boxes);
  std::vector<float> copy = light_;
  std::fill(light_.begin(), light_.end(), 0.0f);
  return copy;
}

}  // namespace glint::sim
