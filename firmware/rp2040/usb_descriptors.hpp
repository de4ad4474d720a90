// SPDX-License-Identifier: MIT
// What the board says of itself on the bus: a HID device with a report for each id of the protocol.
#pragma once

#include <stdint.h>

#include "firmware/protocol/sync_report.h"

namespace glint::rp2040::usb_descriptors {

template <unsigned kSize>
struct Bytes {
  uint8_t data[kSize]{};
  static constexpr uint16_t kLength = kSize;
};

constexpr uint8_t low(unsigned value) { return static_cast<uint8_t>(value & 0xff); }
constexpr uint8_t high(unsigned value) { return static_cast<uint8_t>(value >> 8); }

inline constexpr uint8_t kFeatures[] = {
    GLINT_SYNC_STATUS,     GLINT_SYNC_RUN,        GLINT_SYNC_LIMITS,     GLINT_SYNC_COMMAND,
    GLINT_SYNC_INFO,       GLINT_SYNC_TIME,       GLINT_SYNC_FETCH,      GLINT_SYNC_SELFTEST,
    GLINT_SYNC_OUTPUT,     GLINT_SYNC_OUTPUT + 1, GLINT_SYNC_OUTPUT + 2, GLINT_SYNC_OUTPUT + 3,
    GLINT_SYNC_OUTPUT + 4, GLINT_SYNC_OUTPUT + 5, GLINT_SYNC_OUTPUT + 6, GLINT_SYNC_OUTPUT + 7};

/// Vendor-defined page, usage 1; every report is bytes of 0 to 255.
constexpr auto make_report() {
  constexpr uint8_t kHead[] = {0x06,
                               low(GLINT_SYNC_USAGE_PAGE),
                               high(GLINT_SYNC_USAGE_PAGE),
                               0x09,
                               1,
                               0xa1,
                               1,
                               0x15,
                               0,
                               0x26,
                               0xff,
                               0,
                               0x75,
                               8,
                               0x95,
                               GLINT_SYNC_REPORT_BYTES - 1};
  constexpr unsigned kReport = 6;
  Bytes<sizeof kHead + kReport*(1 + sizeof kFeatures) + 1> bytes;
  unsigned at = 0;
  for (const uint8_t value : kHead) bytes.data[at++] = value;
  const auto add = [&](uint8_t id, uint8_t kind) {
    const uint8_t values[kReport] = {0x85, id, 0x09, 1, kind, 0x02};
    for (const uint8_t value : values) bytes.data[at++] = value;
  };
  add(GLINT_SYNC_INPUT, 0x81);
  for (const uint8_t id : kFeatures) add(id, 0xb1);
  bytes.data[at] = 0xc0;
  return bytes;
}
inline constexpr auto kReport = make_report();

inline constexpr Bytes<18> kDevice{{18, 1, 0x00, 0x02, 0, 0, 0, 64, low(GLINT_SYNC_VENDOR_ID),
                                    high(GLINT_SYNC_VENDOR_ID), low(GLINT_SYNC_PRODUCT_ID),
                                    high(GLINT_SYNC_PRODUCT_ID), GLINT_SYNC_PROTOCOL_MINOR,
                                    GLINT_SYNC_PROTOCOL_MAJOR, 1, 2, 3, 1}};
inline constexpr unsigned kHidOffset = 18;
inline constexpr Bytes<34> kConfiguration{{9,
                                           2,
                                           34,
                                           0,
                                           1,
                                           1,
                                           0,
                                           0x80,
                                           50,  // bus powered, 100 mA
                                           9,
                                           4,
                                           0,
                                           0,
                                           1,
                                           3,
                                           0,
                                           0,
                                           0,  // interface: HID, no boot protocol
                                           9,
                                           0x21,
                                           0x11,
                                           0x01,
                                           0,
                                           1,
                                           0x22,
                                           low(kReport.kLength),
                                           high(kReport.kLength),
                                           7,
                                           5,
                                           0x81,
                                           3,
                                           64,
                                           0,
                                           1}};  // endpoint 1 IN, interrupt, every millisecond

inline constexpr const char* kManufacturer = "glint";
inline constexpr const char* kProduct = GLINT_SYNC_PRODUCT;

}  // namespace glint::rp2040::usb_descriptors
