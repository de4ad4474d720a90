// SPDX-License-Identifier: MIT
// What host/capture finds, in words and in JSON.
#include "host/apps/camera_list.hpp"

#include <cstdio>
#include <string>

#include <nlohmann/json.hpp>

#include "host/capture/v4l2/camera_list.hpp"

namespace glint::apps {
namespace {

using Json = nlohmann::ordered_json;

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

std::string control_text(const CameraControl& control) {
  std::string text = control.word;
  if (control.type == ControlType::Button || control.type == ControlType::Other) return text;
  text += " = " + std::to_string(control.value);
  if (control.type == ControlType::Menu) {
    std::string items;
    for (const MenuItem& item : control.menu)
      items += (items.empty() ? "" : ", ") + std::to_string(item.value) + " " + item.name;
    text += " (" + items;
  } else {
    text += " (" + std::to_string(control.lowest) + " to " + std::to_string(control.highest);
    if (control.step > 1) text += " by " + std::to_string(control.step);
  }
  text += ", usually " + std::to_string(control.usual) + ")";
  if (control.inactive) text += ", inactive";
  if (control.read_only) text += ", cannot be set";
  return text;
}

void print(const CameraInfo& camera) {
  const DeviceIdentity& id = camera.identity;
  std::printf("%s", id.node.c_str());
  if (!camera.card.empty()) std::printf("  %s (%s)", camera.card.c_str(), camera.driver.c_str());
  std::printf("\n     device = \"%s\"\n", id.stable_name().c_str());
  if (id.usb) {
    std::printf("     USB port %s, %g Mbit/s, bus %u %s%s\n", id.usb->port.c_str(), id.usb->speed_mbit_s,
                id.usb->bus,
                camera.bus_neighbours.empty() ? "for itself"
                                              : ("shared with " + joined(camera.bus_neighbours)).c_str(),
                id.usb->serial.empty() ? "" : (", serial " + id.usb->serial).c_str());
  }
  if (!camera.problem.empty()) std::printf("     %s\n", camera.problem.c_str());
  for (const FormatOffer& format : camera.formats) {
    std::printf("     %s%s\n", describe({format}).c_str(), format.kind ? "" : "  (glint cannot read this)");
  }
  for (const CameraControl& control : camera.controls)
    std::printf("     %s\n", control_text(control).c_str());
}

Json size_json(FrameSize size) { return {{"width_px", size.width_px}, {"height_px", size.height_px}}; }

Json formats_json(const std::vector<FormatOffer>& formats) {
  Json all = Json::array();
  for (const FormatOffer& format : formats) {
    Json sizes = Json::array();
    for (const SizeOffer& size : format.sizes) {
      Json one = {{"smallest", size_json(size.smallest)}, {"largest", size_json(size.largest)}};
      if (!size.discrete()) one["step"] = size_json(size.step);
      one["rates_hz"] = size.rates.discrete_hz;
      if (size.rates.highest_hz > 0.0) {
        one["lowest_hz"] = size.rates.lowest_hz;
        one["highest_hz"] = size.rates.highest_hz;
      }
      sizes.push_back(std::move(one));
    }
    all.push_back({{"name", format.name},
                   {"description", format.description},
                   {"read_as", format.kind ? std::string(name_of(*format.kind)) : ""},
                   {"sizes", std::move(sizes)}});
  }
  return all;
}

const char* type_text(ControlType type) {
  switch (type) {
    case ControlType::Whole:
      return "whole";
    case ControlType::YesNo:
      return "yes_no";
    case ControlType::Menu:
      return "menu";
    case ControlType::Button:
      return "button";
    case ControlType::Other:
      break;
  }
  return "other";
}

Json controls_json(const std::vector<CameraControl>& controls) {
  Json all = Json::array();
  for (const CameraControl& control : controls) {
    Json menu = Json::array();
    for (const MenuItem& item : control.menu) menu.push_back({{"value", item.value}, {"name", item.name}});
    all.push_back({{"id", control.id},
                   {"name", control.word},
                   {"title", control.name},
                   {"type", type_text(control.type)},
                   {"lowest", control.lowest},
                   {"highest", control.highest},
                   {"step", control.step},
                   {"default", control.usual},
                   {"value", control.value},
                   {"inactive", control.inactive},
                   {"read_only", control.read_only},
                   {"menu", std::move(menu)}});
  }
  return all;
}

Json camera_json(const CameraInfo& camera) {
  const DeviceIdentity& id = camera.identity;
  Json one = {{"node", id.node},          {"device", id.stable_name()}, {"by_path", id.by_path},
              {"card", camera.card},      {"driver", camera.driver},    {"bus_info", camera.bus_info},
              {"problem", camera.problem}};
  if (id.usb) {
    one["usb"] = {{"port", id.usb->port},
                  {"bus", id.usb->bus},
                  {"speed_mbit_s", id.usb->speed_mbit_s},
                  {"serial", id.usb->serial},
                  {"shares_bus_with", camera.bus_neighbours}};
  }
  one["formats"] = formats_json(camera.formats);
  one["controls"] = controls_json(camera.controls);
  return one;
}

}  // namespace

void print_camera_list() {
  KernelCalls calls;
  const CameraList list = list_cameras(calls);
  std::printf("\ncameras\n");
  for (const CameraInfo& camera : list.cameras) print(camera);
  if (!list.problem.empty()) std::printf("%s\n", list.problem.c_str());
}

void add_camera_list(Json& json) {
  KernelCalls calls;
  const CameraList list = list_cameras(calls);
  json["cameras"] = Json::array();
  for (const CameraInfo& camera : list.cameras) json["cameras"].push_back(camera_json(camera));
  json["cameras_problem"] = list.problem;
}

}  // namespace glint::apps
