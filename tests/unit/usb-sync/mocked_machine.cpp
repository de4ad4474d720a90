// SPDX-License-Identifier: MIT
#include "tests/unit/usb-sync/mocked_machine.hpp"

#include <fcntl.h>
#include <linux/hidraw.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <stdexcept>

namespace glint::testing {
namespace {

/// Throws what umockdev has against it.
template <class Call>
void checked(Call&& call) {
  GError* error = nullptr;
  if (call(&error)) return;
  const std::string text = error != nullptr ? error->message : "umockdev failed";
  g_clear_error(&error);
  throw std::runtime_error(text);
}

}  // namespace

MockedMachine::MockedMachine()
    : testbed_(umockdev_testbed_new()),
      handler_(UMOCKDEV_IOCTL_BASE(g_object_new(UMOCKDEV_TYPE_IOCTL_BASE, nullptr))) {
  g_signal_connect(handler_, "handle-ioctl", G_CALLBACK(&MockedMachine::answer), this);
}

MockedMachine::~MockedMachine() {
  g_object_unref(handler_);
  g_object_unref(testbed_);
}

bool MockedMachine::available() {
  const char* preloaded = std::getenv("LD_PRELOAD");
  return preloaded != nullptr && std::string(preloaded).find("libumockdev-preload") != std::string::npos;
}

std::string MockedMachine::usb_path(int number) {
  return "/devices/pci0000:00/0000:00:14.0/usb1/1-" + std::to_string(number + 1);
}

void MockedMachine::plug(int number, const Device& device) {
  const std::string digit = std::to_string(number), usb = usb_path(number);
  const std::string interface = usb + "/1-" + std::to_string(number + 1) + ":1.0";
  const std::string hid = interface + "/0003:1209:" + device.product_id + ".000" + digit;
  // One byte of report 1 in, 55 bytes; the same as a feature report 16.
  const std::string descriptor =
      "06" + device.usage_page + "0901a101150026ff00750885019537090181028510953709 01b102c0";
  std::string hex;
  for (const char c : descriptor) {
    if (c != ' ') hex += c;
  }
  const std::string text =
      "P: " + usb +
      "\nE: SUBSYSTEM=usb\nE: DEVTYPE=usb_device\nA: idVendor=1209\\n\nA: idProduct=" + device.product_id +
      "\\n\nA: serial=" + device.serial + "\\n\nA: product=" + device.product +
      "\\n\nA: manufacturer=glint\\n\nA: bcdDevice=0100\\n\n\nP: " + interface +
      "\nE: SUBSYSTEM=usb\nE: DEVTYPE=usb_interface\nA: bInterfaceNumber=00\\n\n\nP: " + hid +
      "\nE: SUBSYSTEM=hid\nE: HID_ID=0003:00001209:0000" + device.product_id +
      "\nE: HID_NAME=" + device.product + "\nE: HID_UNIQ=" + device.serial + "\nH: report_descriptor=" + hex +
      "\n\nP: " + hid + "/hidraw/hidraw" + digit + "\nN: hidraw" + digit +
      "\nE: SUBSYSTEM=hidraw\nE: DEVNAME=" + node(number) + "\nL: device=../..\n\n";
  checked([&](GError** error) { return umockdev_testbed_add_from_string(testbed_, text.c_str(), error); });
  checked([&](GError** error) {
    return umockdev_testbed_attach_ioctl(testbed_, node(number).c_str(), handler_, error);
  });
}

/// Who has it open sees a hang-up, as with a device that is gone.
void MockedMachine::unplug(int number) {
  on_get = on_set = [](Bytes) { return -1; };
  const int nothing = open("/dev/null", O_RDWR | O_CLOEXEC);
  dup2(nothing, umockdev_testbed_get_dev_fd(testbed_, node(number).c_str()));
  close(nothing);
  umockdev_testbed_remove_device(testbed_, ("/sys" + usb_path(number)).c_str());
}

void MockedMachine::send(int number, std::span<const std::uint8_t> report) {
  const int master = umockdev_testbed_get_dev_fd(testbed_, node(number).c_str());
  if (write(master, report.data(), report.size()) != static_cast<ssize_t>(report.size())) {
    throw std::runtime_error("cannot write to " + node(number));
  }
}

gboolean MockedMachine::answer(UMockdevIoctlBase*, UMockdevIoctlClient* client, gpointer self) {
  auto& machine = *static_cast<MockedMachine*>(self);
  const gulong request = umockdev_ioctl_client_get_request(client);
  const bool size = request == HIDIOCGRDESCSIZE;  // hidapi asks whether this is a HID device at all
  const bool set = _IOC_TYPE(request) == 'H' && _IOC_NR(request) == _IOC_NR(HIDIOCSFEATURE(0));
  const bool get = _IOC_TYPE(request) == 'H' && _IOC_NR(request) == _IOC_NR(HIDIOCGFEATURE(0));
  if (!size && !set && !get) return FALSE;
  UMockdevIoctlData* data =
      umockdev_ioctl_data_resolve(umockdev_ioctl_client_get_arg(client), 0, _IOC_SIZE(request), nullptr);
  std::vector<std::uint8_t> report(data->data, data->data + data->data_len);
  const int result = size ? 0 : set ? machine.on_set(report) : machine.on_get(report);
  if (get) umockdev_ioctl_data_update(data, 0, report.data(), static_cast<gint>(report.size()));
  g_object_unref(data);
  const int done = set && result >= 0 ? static_cast<int>(report.size()) : result;
  umockdev_ioctl_client_complete(client, done, done < 0 ? EPIPE : 0);
  return TRUE;
}

}  // namespace glint::testing
