// SPDX-License-Identifier: MIT
// Devices of a USB/IP server at the kernel's virtual USB ports while a command runs.
//   usbip_attach --port N [--host ADDRESS] [--busid ID]... [--first-port N] -- COMMAND ARGUMENT...
// COMMAND starts when all of them have been plugged in once; devices that go and come back are plugged in
// again. Ends when COMMAND does, and as it did. The server is tests/board/usbip_server.js; 10.0.2.2 is the
// host of a guest in QEMU.
#include <poll.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/base/error.hpp"
#include "tests/device/program/program.hpp"
#include "tests/device/reader_command/reader_command.hpp"
#include "tests/device/usbip_attach/remote_device.hpp"

namespace glint::device {
namespace {

/// Waits until a device has something to say, at most 50 ms, and lets all do what is due.
void serve(std::vector<std::unique_ptr<RemoteDevice>>& devices) {
  std::vector<pollfd> polls;
  polls.reserve(devices.size());
  for (const auto& device : devices) {
    const short events = device->plugged() ? POLLRDHUP : POLLIN;
    polls.push_back({device->socket(), events, 0});
  }
  constexpr int kPatience_ms = 50;
  poll(polls.data(), polls.size(), kPatience_ms);
  for (const auto& device : devices) device->step();
}

int run(int argc, char** argv) {
  const std::vector<std::string> command = take_command(argc, argv);
  Exporter exporter{"10.0.2.2", 0};
  std::vector<std::string> busids;
  unsigned first_port = 0;
  CLI::App app;
  app.add_option("--host", exporter.host);
  app.add_option("--port", exporter.port)->required();
  app.add_option("--busid", busids);
  app.add_option("--first-port", first_port);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    throw UsageError(error.what());
  }
  if (busids.empty()) busids = {"1-1"};
  std::vector<std::unique_ptr<RemoteDevice>> devices;
  devices.reserve(busids.size());
  for (const std::string& busid : busids)
    devices.push_back(
        std::make_unique<RemoteDevice>(exporter, busid, first_port + static_cast<unsigned>(devices.size())));
  const auto is_plugged = [](const auto& device) { return device->plugged(); };
  while (!std::all_of(devices.begin(), devices.end(), is_plugged)) serve(devices);
  ReaderCommand reader(command, {});
  std::optional<int> code;
  while (!(code = reader.ended())) serve(devices);
  return *code;
}

}  // namespace
}  // namespace glint::device

int main(int argc, char** argv) {
  return glint::device::run_program("usbip_attach", glint::device::run, argc, argv);
}
