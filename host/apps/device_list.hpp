// SPDX-License-Identifier: MIT
// The list of devices, as people see it.
#pragma once

namespace glint::apps {

/// All Vulkan devices and the CPU, to standard output.
void print_device_list();

}  // namespace glint::apps
