// SPDX-License-Identifier: MIT
// Listing and opening by name.
#include <algorithm>
#include <array>
#include <fstream>
#include <string>

#include "host/base/check.hpp"
#include "host/capture/v4l2/camera_list.hpp"
#include "tests/fuzz/chosen_camera.hpp"
#include "tests/fuzz/v4l2_trials.hpp"
#include "tests/unit/capture/fake_sysfs.hpp"
#include "tests/unit/capture/spoilt_calls.hpp"

namespace glint::test {
namespace {

std::string text_from(ByteChoices& choices) {
  const auto bytes = choices.take(choices.below(32));
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

void overwrite(const std::filesystem::path& file, const std::string& text) {
  std::ofstream(file, std::ios::binary | std::ios::trunc) << text;
}

bool printable(const std::string& text) {
  return std::none_of(text.begin(), text.end(), [](char c) { return static_cast<unsigned char>(c) < 0x20; });
}

class UsbCameras {
 public:
  UsbCameras() {
    tree_.add_usb(0, "1-1", "A", true);
    tree_.add_usb(2, "1-2", "B");
  }
  void change(ByteChoices& choices) const {
    const std::filesystem::path usb = tree_.roots().sys / "devices/pci0000:00/0000:00:14.0/usb1";
    overwrite(usb / "1-1/serial", text_from(choices));
    overwrite(usb / "1-1/busnum", text_from(choices));
    overwrite(usb / "1-2/speed", text_from(choices));
    overwrite(usb / "1-2/1-2:1.0/video4linux/video2/index", text_from(choices));
  }
  const FakeSysfs& tree() const { return tree_; }

 private:
  FakeSysfs tree_;
};

}  // namespace

void try_list(ByteChoices& choices) {
  static const UsbCameras usb;
  const DeviceRoots roots = usb.tree().roots();
  usb.change(choices);
  FakeV4l2 driver;
  for (const unsigned node : {0u, 1u, 2u}) choose_camera(choices, driver.add(usb.tree().node(node)));
  SpoiltCalls calls(driver, choices, kSpoilt);
  const CameraList list = list_cameras(calls, roots);
  GLINT_CHECK(list.cameras.empty() != list.problem.empty());
  for (const CameraInfo& camera : list.cameras) {
    const DeviceIdentity& identity = camera.identity;
    GLINT_CHECK(printable(identity.stable_name()) && (!identity.usb || printable(identity.usb->serial)));
    GLINT_CHECK(printable(camera.card) && printable(camera.driver) && printable(camera.bus_info));
    GLINT_CHECK(!describe(camera.formats).empty() && printable(describe(camera.formats)));
    for (const CameraControl& control : camera.controls) {
      GLINT_CHECK(printable(control.name) && control_word(control.word) == control.word);
      (void)setting_problem(camera.controls, {control.name, control.value});
      (void)setting_problem(camera.controls, {control.word, text_from(choices)});
    }
  }
  const std::string device = choices.one_of(std::array<std::string, 4>{
      text_from(choices), "serial:" + text_from(choices), usb.tree().node(2), "usb:1-1"});
  try {
    const OpenCamera opened = open_camera(calls, roots, device);
    GLINT_CHECK(driver.open_nodes() == 1 && opened.node.descriptor() >= 0);
  } catch (const Error& error) {
    GLINT_CHECK(error.what()[0] != '\0');
  }
  GLINT_CHECK(driver.open_nodes() == 0);
}

}  // namespace glint::test
