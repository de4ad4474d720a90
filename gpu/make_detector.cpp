// SPDX-License-Identifier: MIT
// Which detector: from the word after --device to a back end.
#include <algorithm>
#include <cctype>

#include "gpu/detector.hpp"
#include "gpu/vulkan/detector_vulkan.hpp"

namespace glint::gpu {
namespace {

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

std::string listing(const std::vector<DeviceInfo>& devices) {
  std::string text = "there is: cpu";
  for (const DeviceInfo& d : devices) {
    text += "; " + std::to_string(d.index) + " = " + d.name +
            (d.usable ? "" : " (not usable: " + d.why_not_usable + ")");
  }
  return text;
}

bool is_index(const std::string& text) {
  return !text.empty() && text.size() < 5 &&
         std::all_of(text.begin(), text.end(), [](unsigned char c) { return std::isdigit(c); });
}

const DeviceInfo* choose(const std::vector<DeviceInfo>& devices, const std::string& wanted) {
  if (wanted == "auto") {
    const auto best =
        std::min_element(devices.begin(), devices.end(), [](const DeviceInfo& a, const DeviceInfo& b) {
          const auto rank = [](const DeviceInfo& d) {
            return !d.usable                ? 9
                   : d.type == "discrete"   ? 0
                   : d.type == "integrated" ? 1
                   : d.type == "virtual"    ? 2
                   : d.software             ? 4
                                            : 3;
          };
          return rank(a) < rank(b);
        });
    return best == devices.end() || !best->usable ? nullptr : &*best;
  }
  const std::string needle = lower(wanted);
  for (const DeviceInfo& d : devices) {
    if (is_index(wanted) ? std::to_string(d.index) == wanted
                         : lower(d.uuid) == needle || lower(d.name).find(needle) != std::string::npos) {
      return &d;
    }
  }
  return nullptr;
}

}  // namespace

DeviceInfo find_device(const std::string& device) {
  std::string problem;
  const std::vector<DeviceInfo> devices = list_devices(&problem);
  if (devices.empty()) {
    throw Error("no Vulkan device: " + problem + "; --device cpu tracks without one");
  }
  const DeviceInfo* found = choose(devices, device);
  if (found == nullptr) throw Error("no device \"" + device + "\"; " + listing(devices));
  if (!found->usable) throw Error("device \"" + found->name + "\" cannot be used: " + found->why_not_usable);
  return *found;
}

std::unique_ptr<Detector> make_detector(const std::string& device, std::span<const CameraFormat> cameras,
                                        const DetectorOptions& options) {
  if (device == "cpu") return make_cpu_detector(cameras, options);
  return make_vulkan_detector(find_device(device), cameras, options);
}

}  // namespace glint::gpu
