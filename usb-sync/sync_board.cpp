// SPDX-License-Identifier: MIT
#include "usb-sync/sync_board.hpp"

#include <algorithm>
#include <cctype>
#include <cstring>
#include <thread>

#include "usb-sync/board_text.hpp"

namespace glint::sync {
namespace {

bool same_serial(std::string_view one, std::string_view other) {
  return std::equal(one.begin(), one.end(), other.begin(), other.end(),
                    [](unsigned char a, unsigned char b) { return std::tolower(a) == std::tolower(b); });
}

std::string serials_of(const std::vector<FoundBoard>& boards) {
  std::string text;
  for (const FoundBoard& board : boards) {
    text += (text.empty() ? "" : ", ") + (board.serial.empty() ? board.path : board.serial);
  }
  return text;
}

FoundBoard chosen(const std::vector<FoundBoard>& boards, std::string_view serial) {
  if (boards.empty()) {
    throw NoBoard(
        "no sync board is plugged in: connect it by USB; a new one must be flashed first (glint sync flash "
        "FILE.uf2)");
  }
  if (!serial.empty()) {
    for (const FoundBoard& board : boards) {
      if (same_serial(board.serial, serial)) return board;
    }
    throw NoBoard("no sync board with serial number " + std::string(serial) +
                  " is plugged in; there is: " + serials_of(boards));
  }
  if (boards.size() > 1) {
    throw Error("several sync boards are plugged in: say which by its serial number: " + serials_of(boards));
  }
  return boards.front();
}

[[noreturn]] void throw_other_protocol(int major) {
  const std::string both = "the sync board speaks protocol " + std::to_string(major) +
                           ", this program speaks " + std::to_string(GLINT_SYNC_PROTOCOL_MAJOR) + ": ";
  if (major < GLINT_SYNC_PROTOCOL_MAJOR) {
    throw Error(
        both +
        "plug it in with its BOOTSEL button held, and flash the firmware that came with this program (glint "
        "sync flash FILE.uf2)");
  }
  throw Error(
      both +
      "use a newer glint, or plug it in with its BOOTSEL button held, and flash the firmware that came with "
      "this one (glint sync flash FILE.uf2)");
}

glint_sync_command command_report(std::uint8_t code, std::uint32_t argument) noexcept {
  glint_sync_command report{};
  report.report_id = GLINT_SYNC_COMMAND;
  report.protocol = GLINT_SYNC_PROTOCOL_MAJOR;
  report.command = code;
  report.argument = argument;
  return report;
}

template <class Wire>
std::span<const std::uint8_t> bytes_of(const Wire& report) noexcept {
  static_assert(sizeof(Wire) == GLINT_SYNC_REPORT_BYTES);
  return {reinterpret_cast<const std::uint8_t*>(&report), sizeof report};
}

template <class Wire>
Wire as(std::span<const std::uint8_t, GLINT_SYNC_REPORT_BYTES> bytes) noexcept {
  Wire wire;
  std::memcpy(&wire, bytes.data(), sizeof wire);
  return wire;
}

}  // namespace

std::vector<FoundBoard> find_boards(HidBus& bus) { return bus.boards(); }

SyncBoard SyncBoard::open(std::string_view serial, HidBus& bus) {
  return SyncBoard(bus.open(chosen(bus.boards(), serial)));
}

SyncBoard::SyncBoard(std::unique_ptr<HidPort> port) : port_(std::move(port)), info_(read_info()) {}

Info SyncBoard::read_info() {
  const Report report = get(GLINT_SYNC_INFO, "say who it is");
  if (report[1] != GLINT_SYNC_PROTOCOL_MAJOR) throw_other_protocol(report[1]);
  if (const auto info = parse_info(report)) return *info;
  throw Error("the sync board says nonsense about itself: flash it anew (glint sync flash FILE.uf2)");
}

Status SyncBoard::status() {
  if (const auto status = try_status()) return *status;
  throw_gone("say how it is");
}

Limits SyncBoard::limits() {
  const char* what = "say its limits";
  if (const auto limits = parse_limits(get(GLINT_SYNC_LIMITS, what), info_.tick_hz)) return *limits;
  throw_gone(what);
}

Limits SyncBoard::set_limits(const Limits& wanted) {
  set(to_report(wanted, info_.tick_hz), "take the limits");
  return limits();
}

BoardPlan SyncBoard::staged() {
  const char* what = "say its plan";
  PlanReports reports;
  reports.run = as<glint_sync_run>(get(GLINT_SYNC_RUN, what));
  for (std::size_t i = 0; i < kOutputs; ++i) {
    const auto id = static_cast<std::uint8_t>(GLINT_SYNC_OUTPUT + i);
    reports.outputs[i] = as<glint_sync_output>(get(id, what));
  }
  return from_reports(reports, info_.tick_hz);
}

BoardPlan SyncBoard::stage(const BoardPlan& plan) {
  const char* what = "take the plan";
  const PlanReports reports = to_reports(plan, info_.tick_hz);
  set(reports.run, what);
  for (const glint_sync_output& output : reports.outputs) set(output, what);
  return from_reports(reports, info_.tick_hz);
}

void SyncBoard::start() { command(GLINT_SYNC_COMMAND_START, 0, "start"); }

void SyncBoard::apply() { command(GLINT_SYNC_COMMAND_APPLY, 0, "change the run"); }

BoardPlan SyncBoard::start(const BoardPlan& plan) {
  BoardPlan staged = stage(plan);
  start();
  return staged;
}

BoardPlan SyncBoard::apply(const BoardPlan& plan) {
  BoardPlan staged = stage(plan);
  apply();
  return staged;
}

void SyncBoard::stop() { command(GLINT_SYNC_COMMAND_STOP, 0, "stop"); }

Status SyncBoard::end_run() {
  constexpr std::chrono::milliseconds kLook{5};
  constexpr std::chrono::seconds kLongest{35};
  stop();
  const HostTime deadline = HostClock::now() + kLongest;
  while (true) {
    const Status now = status();
    if (now.state == RunState::Idle) return now;
    if (HostClock::now() > deadline)
      throw Error("the run on the sync board " + info_.serial + " does not end: glint sync reset");
    std::this_thread::sleep_for(kLook);
  }
}

void SyncBoard::clear_fault() { command(GLINT_SYNC_COMMAND_CLEAR, 0, "clear the fault"); }

SelfTestResult SyncBoard::self_test(std::size_t output) {
  constexpr std::chrono::milliseconds kLook{20};
  constexpr std::chrono::seconds kLongest{2};
  command(GLINT_SYNC_COMMAND_SELFTEST, static_cast<std::uint32_t>(output), "test itself");
  const HostTime deadline = HostClock::now() + kLongest;
  while (true) {
    std::this_thread::sleep_for(kLook);
    const SelfTestResult result = self_test_result();
    if (result.state == SelfTestResult::State::Done) return result;
    if (HostClock::now() > deadline) {
      throw Error("the self-test of the sync board does not end; status says: " +
                  std::string(state_text(status().state)));
    }
  }
}

SelfTestResult SyncBoard::self_test_result() {
  const char* what = "say how its test went";
  if (const auto result = parse_selftest(get(GLINT_SYNC_SELFTEST, what), info_.tick_hz)) return *result;
  throw_gone(what);
}

void SyncBoard::reset() { command_and_leave(GLINT_SYNC_COMMAND_RESET, GLINT_SYNC_MAGIC_RESET, "reset"); }

void SyncBoard::enter_bootloader() {
  command_and_leave(GLINT_SYNC_COMMAND_BOOTLOADER, GLINT_SYNC_MAGIC_BOOTLOADER, "enter its bootloader");
}

ReadResult SyncBoard::read(std::chrono::milliseconds longest) noexcept {
  std::array<std::uint8_t, 64> bytes;  // a packet: longer than any report, so that overlong ones show
  ReadResult result;
  const int length = port_->read(bytes, longest);
  result.arrival = HostClock::now();
  if (length == 0) return result;
  if (length < 0) {
    result.kind = ReadResult::Kind::Gone;
    return result;
  }
  const std::size_t received = std::min(static_cast<std::size_t>(length), bytes.size());
  const ParsedReport parsed = parse_input(std::span(bytes).first(received), GLINT_SYNC_INPUT);
  result.kind = parsed.flaw == Flaw::None ? ReadResult::Kind::Report : ReadResult::Kind::Flawed;
  result.flaw = parsed.flaw;
  result.report = parsed.report;
  return result;
}

std::optional<TimeAnswer> SyncBoard::ask_time() noexcept {
  const HostTime asked = HostClock::now();
  const auto report = try_get(GLINT_SYNC_TIME);
  const HostTime answered = HostClock::now();
  if (!report || (*report)[1] != GLINT_SYNC_PROTOCOL_MAJOR) return std::nullopt;
  const auto time = as<glint_sync_time>(*report);
  return TimeAnswer{asked, answered, time.tick, time.epoch};
}

std::optional<InputReport> SyncBoard::fetch(std::uint32_t report_no) noexcept {
  constexpr int kTries = 3;  // another program may ask for another one in between
  glint_sync_fetch wanted{};
  wanted.report_id = GLINT_SYNC_FETCH;
  wanted.protocol = GLINT_SYNC_PROTOCOL_MAJOR;
  wanted.report_no = report_no;
  for (int i = 0; i < kTries; ++i) {
    if (!port_->set_feature(bytes_of(wanted))) return std::nullopt;
    const auto answer = try_get(GLINT_SYNC_FETCH);
    if (!answer) return std::nullopt;
    const ParsedReport parsed = parse_input(*answer, GLINT_SYNC_FETCH);
    if (parsed.flaw != Flaw::None) continue;
    if (parsed.report.report_no == report_no || std::holds_alternative<NotHeld>(parsed.report.content)) {
      return parsed.report;
    }
  }
  return std::nullopt;
}

std::optional<Status> SyncBoard::try_status() noexcept {
  const auto report = try_get(GLINT_SYNC_STATUS);
  return report ? parse_status(*report) : std::nullopt;
}

std::optional<SyncBoard::Report> SyncBoard::try_get(std::uint8_t id) noexcept {
  Report report{};
  report[0] = id;
  const int length = port_->get_feature(report);
  if (length != static_cast<int>(report.size()) || report[0] != id) return std::nullopt;
  return report;
}

SyncBoard::Report SyncBoard::get(std::uint8_t id, const char* what) {
  if (const auto report = try_get(id)) return *report;
  throw_gone(what);
}

template <class Wire>
void SyncBoard::set(const Wire& report, const char* what) {
  if (!port_->set_feature(bytes_of(report))) throw_why(what);
}

void SyncBoard::command(std::uint8_t code, std::uint32_t argument, const char* what) {
  set(command_report(code, argument), what);
}

/// The board may be gone before it has said that it obeys.
void SyncBoard::command_and_leave(std::uint8_t code, std::uint32_t argument, const char* what) {
  try {
    command(code, argument, what);
  } catch (const BoardGone&) {
  }
}

/// A setting failed: either the board refused it, and knows why, or it is gone.
void SyncBoard::throw_why(const char* what) {
  const auto status = try_status();
  if (!status || status->refusal == GLINT_SYNC_REFUSED_NOTHING) throw_gone(what);
  throw Refused("the sync board will not " + std::string(what) + ": " + refusal_text(*status, info_.tick_hz),
                status->refusal, status->refusal_output);
}

void SyncBoard::throw_gone(const char* what) const {
  throw BoardGone("the sync board" + (info_.serial.empty() ? "" : " " + info_.serial) + " does not " + what +
                  ": it was unplugged or reset, or hangs; plug it in again");
}

}  // namespace glint::sync
