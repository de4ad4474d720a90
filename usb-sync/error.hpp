// SPDX-License-Identifier: MIT
// What is thrown before the loop runs: one line for the person at the terminal.
#pragma once

#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>

namespace glint::sync {

/// Something outside the program is wrong. The text names the board, file or device and what to do.
class Error : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// No board is plugged in, or none with the serial number that was asked for.
class NoBoard : public Error {
  using Error::Error;
};

/// The board does not answer any more: unplugged, reset or hung. It may come back.
class BoardGone : public Error {
  using Error::Error;
};

/// The board refused a setting or a command. The text says which output, which limit and what to do.
class Refused : public Error {
 public:
  Refused(const std::string& text, std::uint8_t reason, std::optional<int> output)
      : Error(text), reason_(reason), output_(output) {}
  /// glint_sync_refusal.
  std::uint8_t reason() const noexcept { return reason_; }
  /// 0 .. 7; nothing where it is not about one output.
  std::optional<int> output() const noexcept { return output_; }

 private:
  std::uint8_t reason_;
  std::optional<int> output_;
};

}  // namespace glint::sync
