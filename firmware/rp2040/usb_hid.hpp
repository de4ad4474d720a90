// SPDX-License-Identifier: MIT
// The USB device: control requests on endpoint 0, input reports on endpoint 1.
#pragma once

#include "firmware/core/sync_device.hpp"

namespace glint::rp2040 {

/// All calls come from interrupts of one priority.
class UsbHid {
 public:
  /// `serial` becomes the serial number, in hexadecimal.
  UsbHid(board::SyncDevice& device, const uint8_t (&serial)[8]);

  /// Shows the device to the host.
  void attach();
  void detach();
  /// The interrupt; `arrived` is when it began.
  void on_interrupt(uint64_t arrived);
  /// Hands the next input report to the controller, if it has room.
  void send_reports();
  /// What a command asked for; once.
  board::Request take_request();

 private:
  struct Setup {
    uint8_t type, request;
    uint16_t value, index, length;
  };

  void on_bus_reset();
  void on_setup(uint64_t arrived);
  void on_buffers(uint64_t now);
  bool handle(const Setup& setup, uint64_t arrived);
  bool handle_standard(const Setup& setup);
  bool handle_hid(const Setup& setup, uint64_t arrived);
  bool send_descriptor(const Setup& setup);
  bool send_string(unsigned index, uint16_t length);
  bool send(const uint8_t* bytes, uint32_t size, uint16_t wanted);
  void send_packet();
  void stall();
  void arm_in(uint32_t size);

  board::SyncDevice& device_;
  char serial_[17]{};
  board::Request request_ = board::Request::None;

  alignas(4) uint8_t outgoing_[160]{};  // of the control transfer under way
  uint32_t size_ = 0, sent_ = 0;
  bool more_ = false;        // a further packet follows, perhaps an empty one
  bool zero_ended_ = false;  // shorter than asked: a full last packet is followed by an empty one
  uint32_t ep0_data1_ = 0;   // of the next packet
  uint32_t expected_ = 0;    // bytes of the report that the host is sending; 0: none
  uint8_t expected_id_ = 0;  // of that report
  int new_address_ = -1;
  uint8_t configuration_ = 0;
  uint8_t idle_rate_ = 0;
  bool ep1_halted_ = false;
  bool ep1_busy_ = false;
  uint32_t ep1_data1_ = 0;
};

}  // namespace glint::rp2040
