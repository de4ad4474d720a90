// SPDX-License-Identifier: MIT
// The CPU detector with kernels of one's choice: what make_cpu_detector() uses, and tests and benchmarks.
#pragma once

#include <memory>
#include <span>

#include "gpu/cpu/row_kernels.hpp"
#include "gpu/detector.hpp"

namespace glint::gpu {

std::unique_ptr<Detector> make_cpu_detector(std::span<const CameraFormat> cameras,
                                            const DetectorOptions& options, const RowKernels& kernels);

}  // namespace glint::gpu
