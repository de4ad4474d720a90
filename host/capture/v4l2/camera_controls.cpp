// SPDX-License-Identifier: MIT
// Controls through the extended control calls.
#include "host/capture/v4l2/camera_controls.hpp"

#include <linux/videodev2.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <optional>

#include "host/base/error.hpp"
#include "host/capture/v4l2/camera_formats.hpp"

namespace glint {
namespace {

constexpr std::size_t kMostControls = 512;
constexpr std::int64_t kMostMenuItems = 256;

ControlType type_of(std::uint32_t type) noexcept {
  switch (type) {
    case V4L2_CTRL_TYPE_INTEGER:
    case V4L2_CTRL_TYPE_INTEGER64:
    case V4L2_CTRL_TYPE_BITMASK:
      return ControlType::Whole;
    case V4L2_CTRL_TYPE_BOOLEAN:
      return ControlType::YesNo;
    case V4L2_CTRL_TYPE_MENU:
    case V4L2_CTRL_TYPE_INTEGER_MENU:
      return ControlType::Menu;
    case V4L2_CTRL_TYPE_BUTTON:
      return ControlType::Button;
    default:
      return ControlType::Other;
  }
}

/// One control through one call; 0 or -errno.
int transfer(DeviceNode& node, unsigned long request, const CameraControl& control, std::int64_t& value) {
  v4l2_ext_control one{};
  one.id = control.id;
  if (control.wide) {
    one.value64 = value;
  } else {
    one.value = static_cast<std::int32_t>(value);
  }
  v4l2_ext_controls all{};
  all.which = V4L2_CTRL_WHICH_CUR_VAL;
  all.count = 1;
  all.controls = &one;
  const int result = node.ioctl(request, &all);
  if (result < 0) return result;
  const bool is_unsigned = control.highest > INT32_MAX;  // bit masks
  value = control.wide  ? std::int64_t{one.value64}
          : is_unsigned ? std::int64_t{static_cast<std::uint32_t>(one.value)}
                        : std::int64_t{one.value};
  return 0;
}

std::vector<MenuItem> list_menu(DeviceNode& node, const CameraControl& control, bool numbers) {
  std::vector<MenuItem> items;
  const std::int64_t last = std::min(control.highest, control.lowest + kMostMenuItems - 1);
  for (std::int64_t n = std::max<std::int64_t>(control.lowest, 0); n <= last; ++n) {
    v4l2_querymenu entry{};
    entry.id = control.id;
    entry.index = static_cast<std::uint32_t>(n);
    if (node.ioctl(VIDIOC_QUERYMENU, &entry) < 0) continue;  // menus have gaps
    items.push_back({n, numbers ? std::to_string(std::int64_t{entry.value})
                                : driver_text(entry.name, sizeof entry.name)});
  }
  return items;
}

std::string words_of(const std::vector<CameraControl>& controls) {
  std::string text;
  for (const CameraControl& control : controls) text += (text.empty() ? "" : ", ") + control.word;
  return text.empty() ? "none" : text;
}

std::string menu_text(const CameraControl& control) {
  std::string text;
  for (const MenuItem& item : control.menu)
    text += (text.empty() ? "" : ", ") + std::to_string(item.value) + " \"" + item.name + "\"";
  return text;
}

/// The number that a setting stands for; nothing, and `problem`, if the control cannot take it.
std::optional<std::int64_t> number_for(const CameraControl& control, const ControlSetting& setting,
                                       std::string& problem) {
  std::optional<std::int64_t> number;
  if (const auto* whole = std::get_if<std::int64_t>(&setting.value)) {
    number = *whole;
  } else {
    const std::string word = control_word(std::get<std::string>(setting.value));
    for (const MenuItem& item : control.menu) {
      if (control_word(item.name) == word) number = item.value;
    }
    if (control.type == ControlType::YesNo && (word == "true" || word == "false")) number = word == "true";
  }
  const bool in_menu = control.type != ControlType::Menu ||
                       (number && std::any_of(control.menu.begin(), control.menu.end(),
                                              [&](const MenuItem& item) { return item.value == *number; }));
  if (control.type == ControlType::Menu && !in_menu) {
    problem = "must be one of " + menu_text(control);
    return std::nullopt;
  }
  if (!number) {
    problem = "must be a number";
    return std::nullopt;
  }
  if (control.type == ControlType::Button) return number;
  // The difference as unsigned: it may be larger than the largest signed number.
  const bool on_step = control.step <= 1 ||
                       (static_cast<std::uint64_t>(*number) - static_cast<std::uint64_t>(control.lowest)) %
                               static_cast<std::uint64_t>(control.step) ==
                           0;
  if (*number < control.lowest || *number > control.highest || !on_step) {
    problem = "must be " + std::to_string(control.lowest) + " to " + std::to_string(control.highest) +
              (control.step > 1 ? " in steps of " + std::to_string(control.step) : "") + ", not " +
              std::to_string(*number);
    return std::nullopt;
  }
  return number;
}

auto find(const std::vector<CameraControl>& controls, const ControlSetting& setting) {
  const std::string word = control_word(setting.name);
  return std::find_if(controls.begin(), controls.end(),
                      [&](const CameraControl& control) { return control.word == word; });
}

std::string unknown_text(const std::vector<CameraControl>& controls) {
  return "is unknown to this camera; it has: " + words_of(controls);
}

/// Why it did not work; "" if it did.
std::string set_one(DeviceNode& node, const CameraControl& control, std::int64_t wanted) {
  std::int64_t value = wanted;
  const int result = transfer(node, VIDIOC_S_EXT_CTRLS, control, value);
  if (result < 0) return std::string("was refused: ") + std::strerror(-result);
  if (control.type == ControlType::Button) return "";
  if (transfer(node, VIDIOC_G_EXT_CTRLS, control, value) == 0 && value != wanted)
    return "was set to " + std::to_string(wanted) + ", but reads " + std::to_string(value);
  return "";
}

}  // namespace

std::string control_word(std::string_view name) {
  std::string word;
  for (const char c : name) {
    const bool letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
    if (letter || (c >= '0' && c <= '9')) {
      word += letter ? static_cast<char>(c | 0x20) : c;
    } else if (!word.empty() && word.back() != '_') {
      word += '_';
    }
  }
  if (!word.empty() && word.back() == '_') word.pop_back();
  return word;
}

std::vector<CameraControl> list_controls(DeviceNode& node) {
  std::vector<CameraControl> controls;
  std::uint32_t last = 0;
  while (controls.size() < kMostControls) {
    v4l2_query_ext_ctrl entry{};
    entry.id = last | V4L2_CTRL_FLAG_NEXT_CTRL;
    if (node.ioctl(VIDIOC_QUERY_EXT_CTRL, &entry) < 0 || entry.id <= last) break;
    last = entry.id;
    if ((entry.flags & V4L2_CTRL_FLAG_DISABLED) != 0 || entry.type == V4L2_CTRL_TYPE_CTRL_CLASS) continue;
    CameraControl control;
    control.id = entry.id;
    control.name = driver_text(entry.name, sizeof entry.name);
    control.word = control_word(control.name);
    control.type = type_of(entry.type);
    control.wide = entry.type == V4L2_CTRL_TYPE_INTEGER64;
    control.lowest = entry.minimum;
    control.highest = entry.maximum;
    control.step = static_cast<std::int64_t>(std::min<std::uint64_t>(entry.step, INT64_MAX));
    control.usual = control.value = entry.default_value;
    control.inactive = (entry.flags & V4L2_CTRL_FLAG_INACTIVE) != 0;
    control.read_only = (entry.flags & V4L2_CTRL_FLAG_READ_ONLY) != 0;
    if (control.type == ControlType::Menu)
      control.menu = list_menu(node, control, entry.type == V4L2_CTRL_TYPE_INTEGER_MENU);
    if (control.type != ControlType::Button && control.type != ControlType::Other)
      (void)transfer(node, VIDIOC_G_EXT_CTRLS, control, control.value);
    controls.push_back(std::move(control));
  }
  return controls;
}

std::string setting_problem(const std::vector<CameraControl>& controls, const ControlSetting& setting) {
  const auto found = find(controls, setting);
  if (found == controls.end()) return "control " + setting.name + " " + unknown_text(controls);
  std::string problem = found->read_only ? "cannot be set" : "";
  if (problem.empty()) (void)number_for(*found, setting, problem);
  return problem.empty() ? "" : "control " + found->word + " " + problem;
}

void set_controls(DeviceNode& node, const std::vector<ControlSetting>& settings) {
  if (settings.empty()) return;
  const std::vector<CameraControl> controls = list_controls(node);
  std::string problems;
  const auto complain = [&problems](const std::string& name, const std::string& text) {
    problems += (problems.empty() ? "control " : "\ncontrol ") + name + " " + text;
  };
  struct Again {
    const CameraControl* control;
    std::int64_t value;
  };
  std::vector<Again> again;
  for (const ControlSetting& setting : settings) {
    const auto found = find(controls, setting);
    if (found == controls.end()) {
      complain(setting.name, unknown_text(controls));
      continue;
    }
    std::string problem;
    const std::optional<std::int64_t> value = number_for(*found, setting, problem);
    if (!value) {
      complain(found->word, problem);
    } else if (!set_one(node, *found, *value).empty()) {
      again.push_back({&*found, *value});
    }
  }
  for (const auto& [control, value] : again) {
    const std::string problem = set_one(node, *control, value);
    if (!problem.empty()) {
      complain(control->word, problem + (control->inactive ? "; another control makes it inactive" : ""));
    }
  }
  if (!problems.empty()) throw Error(problems);
}

}  // namespace glint
