// SPDX-License-Identifier: MIT
// The machine's boards, by hidapi: its hidraw and its libusb back end alike.
#include <hidapi/hidapi.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "firmware/protocol/sync_report.h"
#include "usb-sync/error.hpp"
#include "usb-sync/hid_port.hpp"

namespace glint::sync {
namespace {

std::string narrow(const wchar_t* text) {
  std::string narrowed;
  for (; text != nullptr && *text != L'\0'; ++text) {
    narrowed += *text > L' ' - 1 && *text < L'\x7f' ? static_cast<char>(*text) : '?';
  }
  return narrowed;
}

class HidapiPort final : public HidPort {
 public:
  explicit HidapiPort(hid_device* device) noexcept : device_(device, &hid_close) {}

  int read(std::span<std::uint8_t> into, std::chrono::milliseconds longest) noexcept override {
    errno = 0;
    const int length =
        hid_read_timeout(device_.get(), into.data(), into.size(), static_cast<int>(longest.count()));
    return length < 0 && errno == EINTR ? 0 : length;  // a signal ends the wait, too
  }

  int get_feature(std::span<std::uint8_t> report) noexcept override {
    return hid_get_feature_report(device_.get(), report.data(), report.size());
  }

  bool set_feature(std::span<const std::uint8_t> report) noexcept override {
    return hid_send_feature_report(device_.get(), report.data(), report.size()) ==
           static_cast<int>(report.size());
  }

 private:
  std::unique_ptr<hid_device, decltype(&hid_close)> device_;
};

/// The libusb back end fills in no usage, and without permission no names either: what is known must fit. The
/// ids are shared with other people's experiments, so the name counts.
bool is_ours(const hid_device_info& device) {
  const bool name_fits = device.product_string == nullptr || *device.product_string == L'\0' ||
                         narrow(device.product_string) == GLINT_SYNC_PRODUCT;
  const bool page_fits = device.usage_page == 0 || device.usage_page == GLINT_SYNC_USAGE_PAGE;
  return name_fits && page_fits && device.interface_number <= 0;
}

class HidapiBus final : public HidBus {
 public:
  std::vector<FoundBoard> boards() override {
    const std::unique_ptr<hid_device_info, decltype(&hid_free_enumeration)> all(
        hid_enumerate(GLINT_SYNC_VENDOR_ID, GLINT_SYNC_PRODUCT_ID), &hid_free_enumeration);
    std::vector<FoundBoard> found;
    for (const hid_device_info* device = all.get(); device != nullptr; device = device->next) {
      if (is_ours(*device)) found.push_back({device->path, narrow(device->serial_number)});
    }
    std::sort(found.begin(), found.end(),
              [](const FoundBoard& one, const FoundBoard& other) { return one.serial < other.serial; });
    return found;
  }

  std::unique_ptr<HidPort> open(const FoundBoard& board) override {
    errno = 0;
    if (hid_device* device = hid_open_path(board.path.c_str())) return std::make_unique<HidapiPort>(device);
    const int why = errno;
    if (why == EACCES || why == EPERM) {
      throw Error(
          "no permission to open the sync board at " + board.path +
          ": copy 70-glint-sync.rules to /etc/udev/rules.d/, run `udevadm control --reload`, and plug "
          "the board in again");
    }
    throw Error("cannot open the sync board at " + board.path + " (" +
                (why != 0 ? std::strerror(why) : narrow(hid_error(nullptr))) +
                "): plug it in again; if that does not help, see that 70-glint-sync.rules is in "
                "/etc/udev/rules.d/");
  }
};

}  // namespace

HidBus& machine_hid_bus() {
  static HidapiBus bus;
  return bus;
}

}  // namespace glint::sync
