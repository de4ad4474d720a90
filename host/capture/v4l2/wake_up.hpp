// SPDX-License-Identifier: MIT
// Lets one thread sleep until any of several others has something, or a moment has come. No lock.
#pragma once

#include "host/base/ids.hpp"

namespace glint {

class WakeUp {
 public:
  WakeUp();  ///< throws Error
  ~WakeUp();
  WakeUp(const WakeUp&) = delete;
  WakeUp& operator=(const WakeUp&) = delete;

  /// Any thread. A call before wait_until() is not lost.
  void wake() noexcept;
  void wait_until(Timestamp until) noexcept;

 private:
  int descriptor_ = -1;
};

}  // namespace glint
