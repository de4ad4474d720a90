// SPDX-License-Identifier: MIT
// The machine's boards that wait in their bootloader, by libusb.
#include <libusb-1.0/libusb.h>

#include <array>
#include <optional>

#include "usb-sync/error.hpp"
#include "usb-sync/flasher.hpp"

namespace glint::sync {
namespace {

constexpr std::uint16_t kVendor = 0x2e8a, kProduct = 0x0003;
/// Longer than any sector takes to be erased.
constexpr unsigned kTimeout_ms = 10'000;

using Context = std::unique_ptr<libusb_context, decltype(&libusb_exit)>;
using Handle = std::unique_ptr<libusb_device_handle, decltype(&libusb_close)>;
using Config = std::unique_ptr<libusb_config_descriptor, decltype(&libusb_free_config_descriptor)>;

struct DeviceListDeleter {
  void operator()(libusb_device** devices) const noexcept { libusb_free_device_list(devices, 1); }
};
using DeviceList = std::unique_ptr<libusb_device*, DeviceListDeleter>;

Context usb() {
  libusb_context* context = nullptr;
  if (const int error = libusb_init(&context); error != LIBUSB_SUCCESS) {
    throw Error(std::string("USB cannot be used: ") + libusb_strerror(error));
  }
  return {context, &libusb_exit};
}

/// As the kernel names it: bus and ports.
std::string place_of(libusb_device* device) {
  std::array<std::uint8_t, 7> ports{};
  const int depth = libusb_get_port_numbers(device, ports.data(), static_cast<int>(ports.size()));
  std::string place = std::to_string(libusb_get_bus_number(device));
  for (int i = 0; i < depth; ++i) {
    place += (i == 0 ? "-" : ".") + std::to_string(ports[static_cast<std::size_t>(i)]);
  }
  return place;
}

template <class Visit>
void for_each_bootloader(libusb_context* context, Visit&& visit) {
  libusb_device** all = nullptr;
  const auto count = libusb_get_device_list(context, &all);
  if (count < 0)
    throw Error(std::string("USB devices cannot be listed: ") + libusb_strerror(static_cast<int>(count)));
  const DeviceList devices(all);
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    libusb_device_descriptor descriptor{};
    if (libusb_get_device_descriptor(all[i], &descriptor) != LIBUSB_SUCCESS) continue;
    if (descriptor.idVendor == kVendor && descriptor.idProduct == kProduct) visit(all[i], descriptor);
  }
}

/// The interface that speaks PICOBOOT, and its two endpoints.
struct Endpoints {
  int interface = 0;
  std::uint8_t in = 0, out = 0;
};

std::optional<Endpoints> picoboot_endpoints(libusb_device* device) {
  libusb_config_descriptor* read = nullptr;
  if (libusb_get_active_config_descriptor(device, &read) != LIBUSB_SUCCESS) return std::nullopt;
  const Config config(read, &libusb_free_config_descriptor);
  for (int i = 0; i < config->bNumInterfaces; ++i) {
    if (config->interface[i].num_altsetting < 1) continue;
    const libusb_interface_descriptor& interface = config->interface[i].altsetting[0];
    if (interface.bInterfaceClass != LIBUSB_CLASS_VENDOR_SPEC || interface.bNumEndpoints != 2) continue;
    Endpoints endpoints{interface.bInterfaceNumber, 0, 0};
    for (int e = 0; e < 2; ++e) {
      const std::uint8_t address = interface.endpoint[e].bEndpointAddress;
      ((address & LIBUSB_ENDPOINT_IN) != 0 ? endpoints.in : endpoints.out) = address;
    }
    if (endpoints.in != 0 && endpoints.out != 0) return endpoints;
  }
  return std::nullopt;
}

class LibusbPort final : public PicobootPort {
 public:
  LibusbPort(Context context, Handle handle, const Endpoints& endpoints)
      : context_(std::move(context)), handle_(std::move(handle)), endpoints_(endpoints) {}
  LibusbPort(const LibusbPort&) = delete;
  LibusbPort& operator=(const LibusbPort&) = delete;
  ~LibusbPort() override { libusb_release_interface(handle_.get(), endpoints_.interface); }

  Result send(std::span<const std::uint8_t> bytes) noexcept override {
    // libusb takes a pointer to what it does not change.
    auto* data = const_cast<std::uint8_t*>(bytes.data());
    return bulk(endpoints_.out, data, static_cast<int>(bytes.size()), static_cast<int>(bytes.size()));
  }

  Result receive(std::span<std::uint8_t> bytes) noexcept override {
    if (!bytes.empty()) {
      return bulk(endpoints_.in, bytes.data(), static_cast<int>(bytes.size()),
                  static_cast<int>(bytes.size()));
    }
    std::array<std::uint8_t, 64> packet;  // an empty one needs room, too
    return bulk(endpoints_.in, packet.data(), static_cast<int>(packet.size()), 0);
  }

  Result reset_interface() noexcept override {
    constexpr std::uint8_t kInterfaceReset = 0x41;
    libusb_clear_halt(handle_.get(), endpoints_.in);
    libusb_clear_halt(handle_.get(), endpoints_.out);
    return outcome(control(LIBUSB_ENDPOINT_OUT, kInterfaceReset, {}), 0, 0);
  }

  Result command_status(std::span<std::uint8_t, 16> status) noexcept override {
    constexpr std::uint8_t kCommandStatus = 0x42;
    const int length = control(LIBUSB_ENDPOINT_IN, kCommandStatus, status);
    return outcome(length < 0 ? length : LIBUSB_SUCCESS, length, 16);
  }

 private:
  int control(libusb_endpoint_direction direction, std::uint8_t request,
              std::span<std::uint8_t> data) noexcept {
    const auto type =
        static_cast<std::uint8_t>(static_cast<int>(direction) | static_cast<int>(LIBUSB_REQUEST_TYPE_VENDOR) |
                                  static_cast<int>(LIBUSB_RECIPIENT_INTERFACE));
    return libusb_control_transfer(handle_.get(), type, request, 0,
                                   static_cast<std::uint16_t>(endpoints_.interface), data.data(),
                                   static_cast<std::uint16_t>(data.size()), kTimeout_ms);
  }

  Result bulk(std::uint8_t endpoint, std::uint8_t* data, int length, int expected) noexcept {
    int moved = 0;
    const int error = libusb_bulk_transfer(handle_.get(), endpoint, data, length, &moved, kTimeout_ms);
    return outcome(error, moved, expected);
  }

  static Result outcome(int error, int moved, int expected) noexcept {
    switch (error) {
      case LIBUSB_SUCCESS:
        return moved == expected ? Result::Done : Result::Stalled;
      case LIBUSB_ERROR_PIPE:
        return Result::Stalled;
      case LIBUSB_ERROR_TIMEOUT:
        return Result::TimedOut;
      default:
        return Result::Gone;
    }
  }

  Context context_;
  Handle handle_;
  Endpoints endpoints_;
};

}  // namespace

std::vector<FoundBootloader> find_bootloaders() {
  const Context context = usb();
  std::vector<FoundBootloader> found;
  for_each_bootloader(context.get(), [&](libusb_device* device, const libusb_device_descriptor&) {
    found.push_back({place_of(device)});
  });
  return found;
}

std::unique_ptr<PicobootPort> open_bootloader(std::string_view place) {
  Context context = usb();
  libusb_device* chosen = nullptr;
  std::string places;
  int count = 0;
  for_each_bootloader(context.get(), [&](libusb_device* device, const libusb_device_descriptor&) {
    const std::string here = place_of(device);
    places += (places.empty() ? "" : ", ") + here;
    if (!place.empty() && here != place) return;
    ++count;
    if (chosen == nullptr) chosen = libusb_ref_device(device);
  });
  const std::unique_ptr<libusb_device, decltype(&libusb_unref_device)> owner(chosen, &libusb_unref_device);
  if (chosen == nullptr) {
    throw Error(places.empty()
                    ? "no board waits in its bootloader: hold BOOTSEL while plugging it in"
                    : "no board waits in its bootloader at " + std::string(place) + "; there is: " + places);
  }
  if (count > 1) throw Error("several boards wait in their bootloader: say which by its place: " + places);

  const std::string name = "the bootloader at " + place_of(chosen);
  const auto endpoints = picoboot_endpoints(chosen);
  if (!endpoints) throw Error(name + " has no PICOBOOT interface: it is not that of an RP2040");
  libusb_device_handle* opened = nullptr;
  if (const int error = libusb_open(chosen, &opened); error == LIBUSB_ERROR_ACCESS) {
    throw Error(
        "no permission to open " + name +
        ": copy 70-glint-sync.rules to /etc/udev/rules.d/, run `udevadm control --reload`, and plug the "
        "board in again");
  } else if (error != LIBUSB_SUCCESS) {
    throw Error(name + " cannot be opened: " + libusb_strerror(error));
  }
  Handle handle(opened, &libusb_close);
  if (const int error = libusb_claim_interface(handle.get(), endpoints->interface);
      error == LIBUSB_ERROR_BUSY) {
    throw Error(name + " is in use by another program (picotool?): end it");
  } else if (error != LIBUSB_SUCCESS) {
    throw Error(name + " cannot be taken: " + libusb_strerror(error));
  }
  return std::make_unique<LibusbPort>(std::move(context), std::move(handle), *endpoints);
}

}  // namespace glint::sync
