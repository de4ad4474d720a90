// SPDX-License-Identifier: MIT
// A camera's controls (exposure, gain, trigger mode, ...) by name.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "host/capture/v4l2/device_calls.hpp"

namespace glint {

enum class ControlType : std::uint8_t { Whole, YesNo, Menu, Button, Other };

struct MenuItem {
  std::int64_t value = 0;
  std::string name;
};

struct CameraControl {
  std::uint32_t id = 0;
  std::string name;  ///< the driver's: "Exposure Time, Absolute"
  std::string word;  ///< as settings write it: "exposure_time_absolute"
  ControlType type = ControlType::Other;
  std::int64_t lowest = 0, highest = 0, step = 1, usual = 0, value = 0;
  std::vector<MenuItem> menu;
  bool wide = false;      ///< of 64 bits
  bool inactive = false;  ///< has no effect as other controls are set now
  bool read_only = false;
};

std::vector<CameraControl> list_controls(DeviceNode& node);

/// A control as a person wants it. Menus take the item's name or number, switches 0, 1, or true and false.
struct ControlSetting {
  std::string name;
  std::variant<std::int64_t, std::string> value;
};

/// Letters in lower case, everything between letters and digits one underscore.
std::string control_word(std::string_view name);

/// Why a camera with these controls cannot take the setting, as far as its lists tell; "" if it can.
std::string setting_problem(const std::vector<CameraControl>& controls, const ControlSetting& setting);

/// Sets them in order; those that are refused because of another one (exposure while it is automatic) are
/// tried once more after the others. Throws Error, one line for each that is unknown (with all there are),
/// out of range or refused.
void set_controls(DeviceNode& node, const std::vector<ControlSetting>& settings);

}  // namespace glint
