// SPDX-License-Identifier: MIT
#include "firmware/rp2040/usb_hid.hpp"

#include "firmware/core/bytes.hpp"
#include "firmware/rp2040/registers.hpp"
#include "firmware/rp2040/usb_descriptors.hpp"

namespace glint::rp2040 {
namespace {

constexpr uint32_t kPacket = 64;

/// Whole words: up to three bytes more than asked for are copied.
void to_controller(uint32_t address, const uint8_t* bytes, uint32_t size) {
  auto* target = reinterpret_cast<volatile uint32_t*>(static_cast<uintptr_t>(address));
  const auto* source = reinterpret_cast<const uint32_t*>(bytes);
  for (uint32_t i = 0; i < (size + 3) / 4; ++i) target[i] = source[i];
}

void from_controller(uint8_t* bytes, uint32_t address, uint32_t size) {
  auto* target = reinterpret_cast<uint32_t*>(bytes);
  const auto* source = reinterpret_cast<volatile const uint32_t*>(static_cast<uintptr_t>(address));
  for (uint32_t i = 0; i < (size + 3) / 4; ++i) target[i] = source[i];
}

/// The controller may look as soon as it is available, so that is said last; it runs at another clock, and
/// wants the rest to be there for some cycles (datasheet, 4.1.2.5.1).
void give(const Register& buffer, uint32_t value) {
  buffer.write(value);
  asm volatile("nop\nnop\nnop\nnop\nnop\nnop\nnop\nnop\nnop\nnop\nnop\nnop" ::: "memory");
  buffer.write(value | usb::kAvailable);
}

enum Standard : uint8_t {
  kGetStatus = 0,
  kClearFeature = 1,
  kSetFeature = 3,
  kSetAddress = 5,
  kGetDescriptor = 6,
  kGetConfiguration = 8,
  kSetConfiguration = 9,
  kGetInterface = 10,
  kSetInterface = 11
};
enum Hid : uint8_t { kGetReport = 1, kGetIdle = 2, kSetReport = 9, kSetIdle = 10 };
enum Descriptor : uint8_t {
  kDevice = 1,
  kConfiguration = 2,
  kString = 3,
  kHidDescriptor = 0x21,
  kReport = 0x22
};
constexpr uint8_t kFeatureReport = 3;
constexpr uint8_t kEndpoint1In = 0x81;

}  // namespace

UsbHid::UsbHid(board::SyncDevice& device, const uint8_t (&serial)[8]) : device_(device) {
  for (unsigned i = 0; i < 16; ++i) {
    const unsigned digit = serial[i / 2] >> (i % 2 == 0 ? 4 : 0) & 0xf;
    serial_[i] = static_cast<char>(digit < 10 ? '0' + digit : 'A' + digit - 10);
  }
}

void UsbHid::attach() {
  auto* memory = reinterpret_cast<volatile uint32_t*>(static_cast<uintptr_t>(usb::kMemory));
  for (unsigned i = 0; i < 1024; ++i) memory[i] = 0;
  usb::kMuxing.write(usb::kToPhy | usb::kSoftConnect);
  usb::kPower.write(usb::kVbusDetect | usb::kVbusOverride);
  usb::kMainControl.write(usb::kControllerEnable);
  usb::kSieControl.write(usb::kInterruptPerBuffer);
  usb::kInterruptEnable.write(usb::kBufferInterrupt | usb::kBusResetInterrupt | usb::kSuspendInterrupt |
                              usb::kSetupInterrupt);
  usb::kEp1InControl.write(usb::kEndpointEnable | usb::kEndpointPerBuffer | usb::kEndpointInterrupt |
                           usb::kEp1Offset);
  usb::kSieControl.set(usb::kPullUp);
}

void UsbHid::detach() { usb::kSieControl.clear(usb::kPullUp); }

board::Request UsbHid::take_request() {
  const board::Request request = request_;
  request_ = board::Request::None;
  return request;
}

void UsbHid::on_interrupt(uint64_t arrived) {
  const uint32_t raised = usb::kInterrupts.read();
  // What is left of the transfer before must not answer this one.
  if ((raised & usb::kSetupInterrupt) != 0) usb::kEp0InBuffer.write(0);
  // Buffers first: the status of one transfer may stand beside the SETUP of the next.
  if ((raised & usb::kBufferInterrupt) != 0) on_buffers(arrived);
  if ((raised & usb::kSetupInterrupt) != 0) {
    usb::kSieStatus.clear(usb::kStatusSetup);
    on_setup(arrived);
  }
  if ((raised & usb::kBusResetInterrupt) != 0) {
    usb::kSieStatus.clear(usb::kStatusBusReset);
    on_bus_reset();
    device_.on_bus_lost(arrived);
  }
  if ((raised & usb::kSuspendInterrupt) != 0) {
    usb::kSieStatus.clear(usb::kStatusSuspended);
    device_.on_bus_lost(arrived);
  }
}

void UsbHid::on_bus_reset() {
  usb::kAddress.write(0);
  new_address_ = -1;
  configuration_ = 0;
  expected_ = 0;
  more_ = false;
  ep1_busy_ = ep1_halted_ = false;
  ep1_data1_ = 0;
  usb::kEp1InBuffer.write(0);
}

void UsbHid::on_setup(uint64_t arrived) {
  alignas(4) uint8_t bytes[8];
  from_controller(bytes, usb::kMemory, sizeof bytes);
  const auto half = [&bytes](unsigned at) { return static_cast<uint16_t>(bytes[at] | bytes[at + 1] << 8); };
  const Setup setup{bytes[0], bytes[1], half(2), half(4), half(6)};
  ep0_data1_ = usb::kData1;
  expected_ = 0;
  more_ = false;
  new_address_ = -1;
  usb::kEp0InBuffer.write(0);
  usb::kEp0OutBuffer.write(0);
  if (!handle(setup, arrived)) stall();
}

bool UsbHid::handle(const Setup& setup, uint64_t arrived) {
  switch (setup.type & 0x60) {
    case 0x00:
      return handle_standard(setup);
    case 0x20:
      return handle_hid(setup, arrived);
    default:
      return false;
  }
}

bool UsbHid::handle_standard(const Setup& setup) {
  const bool to_endpoint = (setup.type & 0x1f) == 2;
  const bool to_ep1 = to_endpoint && setup.index == kEndpoint1In;
  switch (setup.request) {
    case kGetDescriptor:
      return send_descriptor(setup);
    case kSetAddress:
      new_address_ = setup.value & 0x7f;  // from the end of this transfer on
      arm_in(0);
      return true;
    case kSetConfiguration:
      if (setup.value > 1) return false;
      configuration_ = static_cast<uint8_t>(setup.value);
      ep1_data1_ = 0;
      ep1_busy_ = ep1_halted_ = false;
      usb::kEp1InBuffer.write(0);
      arm_in(0);
      return true;
    case kGetConfiguration:
      return send(&configuration_, 1, setup.length);
    case kGetInterface: {
      const uint8_t alternate = 0;
      return send(&alternate, 1, setup.length);
    }
    case kSetInterface:
      if (setup.value != 0) return false;
      arm_in(0);
      return true;
    case kGetStatus: {
      const uint8_t status[2] = {static_cast<uint8_t>(to_ep1 && ep1_halted_), 0};
      return send(status, sizeof status, setup.length);
    }
    case kClearFeature:
    case kSetFeature:
      if (!to_ep1 || setup.value != 0) return false;
      ep1_halted_ = setup.request == kSetFeature;
      ep1_busy_ = false;
      ep1_data1_ = 0;
      usb::kEp1InBuffer.write(ep1_halted_ ? usb::kStall : 0);
      arm_in(0);
      return true;
    default:
      return false;
  }
}

bool UsbHid::handle_hid(const Setup& setup, uint64_t arrived) {
  const auto kind = static_cast<uint8_t>(setup.value >> 8), id = static_cast<uint8_t>(setup.value);
  switch (setup.request) {
    case kGetReport: {
      alignas(8) uint8_t report[GLINT_SYNC_REPORT_BYTES];
      if (kind != kFeatureReport || !device_.get_report(id, report, arrived, arrived)) return false;
      return send(report, sizeof report, setup.length);
    }
    case kSetReport:
      // A report of another length is refused by the device, with the reason; one packet is all that is
      // taken.
      if (kind != kFeatureReport || setup.length == 0 || setup.length > kPacket) return false;
      expected_ = setup.length;
      expected_id_ = id;
      give(usb::kEp0OutBuffer, usb::kLast | usb::kData1 | kPacket);
      return true;
    case kSetIdle:
      idle_rate_ = static_cast<uint8_t>(setup.value >> 8);  // reports come when there is something to say
      arm_in(0);
      return true;
    case kGetIdle:
      return send(&idle_rate_, 1, setup.length);
    default:
      return false;
  }
}

bool UsbHid::send_descriptor(const Setup& setup) {
  namespace d = usb_descriptors;
  switch (setup.value >> 8) {
    case kDevice:
      return send(d::kDevice.data, d::kDevice.kLength, setup.length);
    case kConfiguration:
      return send(d::kConfiguration.data, d::kConfiguration.kLength, setup.length);
    case kHidDescriptor:
      return send(d::kConfiguration.data + d::kHidOffset, 9, setup.length);
    case kReport:
      return send(d::kReport.data, d::kReport.kLength, setup.length);
    case kString:
      return send_string(setup.value & 0xff, setup.length);
    default:
      return false;
  }
}

bool UsbHid::send_string(unsigned index, uint16_t length) {
  alignas(4) uint8_t bytes[2 + 2 * 32] = {4, kString, 0x09, 0x04};  // index 0: English
  if (index == 0) return send(bytes, 4, length);
  const char* const texts[] = {usb_descriptors::kManufacturer, usb_descriptors::kProduct, serial_};
  if (index > 3) return false;
  uint32_t size = 2;
  for (const char* text = texts[index - 1]; *text != 0 && size < sizeof bytes; ++text, size += 2) {
    bytes[size] = static_cast<uint8_t>(*text);
    bytes[size + 1] = 0;
  }
  bytes[0] = static_cast<uint8_t>(size);
  return send(bytes, size, length);
}

bool UsbHid::send(const uint8_t* bytes, uint32_t size, uint16_t wanted) {
  zero_ended_ = size < wanted;
  size_ = size < wanted ? size : wanted;
  board::copy_bytes(outgoing_, bytes, size_);
  sent_ = 0;
  send_packet();
  // The host's empty packet that ends the transfer may come as soon as it has what it wants.
  give(usb::kEp0OutBuffer, usb::kLast | usb::kData1 | kPacket);
  return true;
}

void UsbHid::send_packet() {
  const uint32_t left = size_ - sent_;
  const uint32_t size = left < kPacket ? left : kPacket;
  to_controller(usb::kEp0Data, outgoing_ + sent_, size);
  sent_ += size;
  more_ = sent_ < size_ || (size == kPacket && zero_ended_);
  arm_in(size);
}

void UsbHid::arm_in(uint32_t size) {
  give(usb::kEp0InBuffer, usb::kFull | usb::kLast | ep0_data1_ | size);
  ep0_data1_ ^= usb::kData1;
}

void UsbHid::stall() {
  usb::kStallArm.set(3);
  usb::kEp0InBuffer.write(usb::kStall);
  usb::kEp0OutBuffer.write(usb::kStall);
}

void UsbHid::on_buffers(uint64_t now) {
  constexpr uint32_t kEp0In = bit(0), kEp0Out = bit(1), kEp1In = bit(2);
  const uint32_t done = usb::kBufferStatus.read();
  usb::kBufferStatus.clear(done);
  if ((done & kEp0In) != 0) {
    if (new_address_ >= 0) {
      usb::kAddress.write(static_cast<uint32_t>(new_address_));
      new_address_ = -1;
    }
    if (more_) send_packet();
  }
  if ((done & kEp0Out) != 0 && expected_ == 0) {
    // The host has what it wanted, even if its acknowledgement was lost.
    usb::kEp0InBuffer.write(0);
    more_ = false;
  } else if ((done & kEp0Out) != 0) {
    const uint32_t size = usb::kEp0OutBuffer.read() & usb::kLengthMask;
    alignas(8) uint8_t report[kPacket];
    from_controller(report, usb::kEp0Data, size);
    const bool whole = size == expected_ && report[0] == expected_id_;
    expected_ = 0;
    if (device_.set_report(report, whole ? size : 0, now, request_))
      arm_in(0);
    else
      stall();
  }
  if ((done & kEp1In) != 0) ep1_busy_ = false;
}

void UsbHid::send_reports() {
  if (configuration_ == 0 || ep1_busy_ || ep1_halted_) return;
  const glint_sync_input* report = device_.take_report();
  if (report == nullptr) return;
  to_controller(usb::kEp1Data, reinterpret_cast<const uint8_t*>(report), sizeof *report);
  ep1_busy_ = true;
  give(usb::kEp1InBuffer, usb::kFull | usb::kLast | ep1_data1_ | static_cast<uint32_t>(sizeof *report));
  ep1_data1_ ^= usb::kData1;
}

}  // namespace glint::rp2040
