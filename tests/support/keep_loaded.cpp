// SPDX-License-Identifier: MIT
// For sanitized test programs that load a Vulkan driver: the driver stays loaded to the end, so that
// LeakSanitizer can put a name to what it leaked itself, and those leaks are not ours.

extern "C" int dlclose(void*) noexcept { return 0; }

extern "C" const char* __lsan_default_suppressions() {
  return "leak:libvulkan\nleak:libVkLayer\nleak:libLLVM\nleak:libgallium\n";
}
