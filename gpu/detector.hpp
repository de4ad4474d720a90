// SPDX-License-Identifier: MIT
// Pixels in, blobs out: the one interface behind which the Vulkan and the CPU detector stand.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "shaders/interface/blob_record.h"

namespace glint::gpu {

using shaders::BlobRecord;

/// Set-up failed; the text says what, on which device, and what to do.
class Error : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

enum class PixelFormat : std::uint8_t { Grey8 };

/// A learnt background is in steps of a 256th of a grey level.
inline constexpr unsigned kBackgroundStepsPerGrey = 256;

/// Borrowed pixels, row by row. `pixels == nullptr` means: this camera has no frame in this set.
struct ImageView {
  const std::uint8_t* pixels = nullptr;
  std::uint32_t width_px = 0, height_px = 0, stride_bytes = 0;
  PixelFormat format = PixelFormat::Grey8;
  /// What each pixel shows where no marker is, width_px a row, see BackgroundLearner; nullptr: not known.
  /// Detectors do not need it, they have limits.
  const std::uint16_t* background = nullptr;
};

/// Pinhole with OpenCV's radial-tangential distortion.
struct Lens {
  double fx_px = 1.0, fy_px = 1.0, cx_px = 0.0, cy_px = 0.0;
  std::array<double, 5> k1_k2_p1_p2_k3{};
};

struct CameraFormat {
  std::uint32_t width_px = 0, height_px = 0;
  Lens lens;
};

inline constexpr std::uint32_t kMaxCameras = 32;
/// Largest image: 2^24 pixels keep a grey sum in 32 bits.
inline constexpr std::uint64_t kMaxPixels = std::uint64_t{1} << 24;

/// How frames reach the GPU. Auto: import host memory where the device reads it at full speed, else upload.
enum class FramePath : std::uint8_t { Auto, Import, Copy, Upload };

struct DetectorOptions {
  std::uint32_t min_area_px = 1;
  std::uint32_t max_area_px = 0xffffffffu;
  std::uint32_t max_blobs_per_camera = 8192;  ///< more are counted and flagged as overflow
  unsigned threads = 2;                       ///< CPU detector only: workers, the caller included
  unsigned depth = 2;                         ///< frame sets that may be submitted and not yet collected
  FramePath frame_path = FramePath::Auto;     ///< Vulkan only
  /// Vulkan only: set it to run with the validation layer (core, GPU-assisted, synchronization); it is called
  /// with every message. Slow; for tests.
  std::function<void(const std::string&)> on_validation_message;
};

/// Blobs of one camera, sorted by (y_min_px, x_min_px, area_px, sum).
struct CameraBlobs {
  std::span<const BlobRecord> blobs;
  std::uint32_t found =
      0;  ///< components that passed the area filter, kept or not; with overflow a lower bound
  bool overflow =
      false;  ///< not all were kept: which ones is unspecified. Also when a blob is too large for the device
};

struct StageTime {
  const char* name = "";
  double seconds = 0.0;
};

/// Valid until the next collect() or the end of the detector.
struct BlobBatch {
  std::vector<CameraBlobs> cameras;
  std::vector<StageTime> stages;  ///< GPU: timestamp queries around every dispatch; CPU: wall time
};

enum class RunStatus : std::uint8_t {
  Ok,
  Busy,        ///< submit: `depth` sets are in flight; collect first
  Idle,        ///< collect: nothing was submitted
  BadImage,    ///< an image's size is not the camera's
  DeviceLost,  ///< the GPU is gone, or an earlier submission failed; see last_error()
  Timeout,     ///< the GPU did not answer within 10 s
};

/// Thread-bound: one thread submits and collects.
class Detector {
 public:
  virtual ~Detector() = default;

  /// What runs: "cpu (2 threads, AVX2)" or the Vulkan device's name.
  virtual const std::string& device_name() const noexcept = 0;

  /// Sets the limit image of a camera: a pixel is bright if value > limit. `limit` holds
  /// width_px * height_px bytes; 255 masks a pixel for good. Until it is called nothing is bright. Not while
  /// sets are in flight. Throws Error.
  virtual void set_limit(std::uint32_t camera, std::span<const std::uint8_t> limit) = 0;

  /// Offers memory out of which images will be submitted, so that they need not be copied. The
  /// memory must outlive the detector. Rows with stride_bytes % 16 == 0 at 16-byte aligned addresses
  /// inside it are read in place where the device can. Returns whether it can.
  virtual bool adopt_frame_memory(std::span<std::byte> memory) = 0;

  /// Starts moving one camera's frame to the device before the rest of the set is there. Optional:
  /// submit() moves what was not.
  virtual void upload(std::uint32_t camera, const ImageView& image) noexcept = 0;

  /// Starts detection on one frame set: images[camera]. The pixels stay lent until that set is collected.
  [[nodiscard]] virtual RunStatus submit(std::span<const ImageView> images) noexcept = 0;

  /// Waits for the oldest set in flight and gives its blobs.
  [[nodiscard]] virtual RunStatus collect(BlobBatch& batch) noexcept = 0;

  /// What went wrong last, for the person at the terminal.
  virtual const std::string& last_error() const noexcept = 0;
};

/// Plain loops; the definition of correct. Slow.
std::unique_ptr<Detector> make_reference_detector(std::span<const CameraFormat> cameras,
                                                  const DetectorOptions& options);
/// SIMD, runs and union-find on the CPU: the fallback and the honest baseline.
std::unique_ptr<Detector> make_cpu_detector(std::span<const CameraFormat> cameras,
                                            const DetectorOptions& options);

/// A heap of a device's memory.
struct MemoryHeap {
  std::uint64_t size_bytes = 0;
  bool device_local = false, multi_instance = false;
  bool host_visible = false;  ///< some memory type in it is
};

/// A Vulkan device as `glint devices` lists it.
struct DeviceInfo {
  std::uint32_t index = 0;
  std::string name, driver_name, driver_info, uuid,
      type;                          ///< type: discrete, integrated, virtual, software, other
  std::string driver_uuid, pci_bus;  ///< pci_bus: "0000:01:00.0"; empty where the driver does not tell
  std::uint32_t vendor_id = 0, device_id = 0, api_major = 0, api_minor = 0, api_patch = 0;
  std::uint32_t driver_version = 0;  ///< packed as the vendor likes it
  std::uint32_t driver_id = 0;       ///< VkDriverId; 0: the driver does not tell
  std::string driver_id_name;        ///< "MesaLlvmpipe"
  std::string conformance_version;   ///< of the Vulkan test suite: "1.3.1.1"
  std::uint32_t subgroup_size = 0, max_workgroup_invocations = 0;
  std::uint64_t max_texel_buffer_elements = 0, device_memory_bytes = 0;
  std::vector<MemoryHeap> heaps;
  double timestamp_period_ns = 0.0;
  bool software = false, imports_host_memory = false, usable = false;
  std::string why_not_usable;
};

/// All Vulkan devices; empty without a driver. Never throws for a missing driver: `problem` says why it is
/// empty.
std::vector<DeviceInfo> list_devices(std::string* problem = nullptr);

/// The usable device that "auto", an index, a UUID or part of a name stands for. Throws Error that lists what
/// there is.
DeviceInfo find_device(const std::string& device);

/// device: "auto" (hardware before software), "cpu", an index, a UUID, or part of a name. Throws Error
/// that lists what there is.
std::unique_ptr<Detector> make_detector(const std::string& device, std::span<const CameraFormat> cameras,
                                        const DetectorOptions& options);

}  // namespace glint::gpu
