// SPDX-License-Identifier: MIT
// The sync board: chip, logic and USB joined; interrupts do the work, the processor sleeps in between.
#include "firmware/core/sync_device.hpp"
#include "firmware/rp2040/chip.hpp"
#include "firmware/rp2040/pins.hpp"
#include "firmware/rp2040/pio_pulses.hpp"
#include "firmware/rp2040/registers.hpp"
#include "firmware/rp2040/ticks.hpp"
#include "firmware/rp2040/usb_hid.hpp"

namespace glint::rp2040 {
namespace {

constexpr uint32_t kWatchdog_us = 200'000;
/// Whatever was to be done at a time must have been done that long after, or the watchdog is not fed.
constexpr uint64_t kOverdue = board::ticks_of_us(50'000);
/// From a command that ends glint to its end, so that the host gets its answer.
constexpr uint64_t kFarewell = board::ticks_of_us(20'000);

bool read_strap() {
  pads::pin(kPinStrobesLow).write(pads::kInputEnable | pads::kSchmitt | pads::kPullUp);
  io::control(kPinStrobesLow).write(static_cast<uint32_t>(io::Function::Sio));
  for (const uint32_t since = now_us(); now_us() - since < 100;) {
  }
  return (sio::kIn.read() & bit(kPinStrobesLow)) == 0;
}

board::Identity identify() {
  board::Identity identity{};
  const Boot boot = take_boot();
  read_flash_serial(identity.serial);
  identity.epoch = boot.epoch;
  identity.reset_reason = boot.reason;
  identity.strobes_active_low = read_strap();
  identity.firmware_version = GLINT_FIRMWARE_VERSION;
  identity.build = GLINT_FIRMWARE_BUILD;
  return identity;
}

/// Made once, in main(); the interrupts find it through its address.
class App {
 public:
  App()
      : identity_(identify()),
        pulses_(identity_.strobes_active_low),
        device_(pulses_, identity_, now_tick()),
        usb_(device_, identity_.serial) {}

  [[noreturn]] void run();
  void on_timer() {
    timer::kRaised.write(bit(0));
    device_.on_timer(now_tick());
    after_event();
  }
  void on_usb(uint32_t fine) {
    usb_.on_interrupt(full_tick(fine));
    const board::Request request = usb_.take_request();
    if (request != board::Request::None) {
      request_ = request;
      farewell_ = now_tick() + kFarewell;
    }
    after_event();
  }
  void on_adc();
  /// Comes at once, also amid another interrupt: notes the time, no more.
  void on_pin() {
    edge_ = pulses_.take_edge();
    cortex::kPend.write(bit(kIrqEdge));
  }
  void on_edge() {
    device_.on_edge(edge_);
    after_event();
  }

 private:
  void start_adc();
  void start_interrupts();
  void after_event();
  bool healthy(uint64_t now) const { return due_ == board::SyncDevice::kNever || now < due_ + kOverdue; }

  board::Identity identity_;
  PioPulses pulses_;
  board::SyncDevice device_;
  UsbHid usb_;
  uint64_t due_ = board::SyncDevice::kNever;
  uint64_t edge_ = 0;
  board::Request request_ = board::Request::None;
  uint64_t farewell_ = board::SyncDevice::kNever;
};

App* g_app;

void App::run() {
  g_app = this;
  sio::kOutEnableSet.write(bit(kPinLed));
  io::control(kPinLed).write(static_cast<uint32_t>(io::Function::Sio));
  start_adc();
  start_interrupts();
  usb_.attach();
  start_watchdog(kWatchdog_us);
  for (;;) {
    const uint64_t now = now_tick();
    // Half a number, where an interrupt came in between, is put right in the next round.
    if (healthy(now)) feed_watchdog();
    if (request_ != board::Request::None && now >= farewell_) {
      asm volatile("cpsid i" ::: "memory");
      pulses_.halt();
      usb_.detach();
      if (request_ == board::Request::Bootloader) start_bootloader();
      reset_chip();
    }
    // Interrupts stay on, so that an edge at sync in is timed at once; the supply's come 10,000 times a
    // second, so that nothing is slept over.
    asm volatile("wfi" ::: "memory");
  }
}

void App::start_adc() {
  pads::pin(kPinSupply).write(pads::kOutputDisable);  // neither pull nor digital input
  adc::kControl.write(adc::kEnable | kAdcSupply << 12);
  while ((adc::kControl.read() & adc::kReady) == 0) {
  }
  adc::kFifoControl.write(adc::kFifoEnable | adc::threshold(2));
  adc::kDivider.write((48'000'000 / board::SupplyMonitor::kSampleHz - 1) << 8);
  adc::kInterruptEnable.write(1);
  adc::kControl.set(adc::kStartMany);
}

void App::on_adc() {
  const uint64_t now = now_tick();
  while ((adc::kFifoControl.read() & adc::kEmpty) == 0) {
    const uint32_t sample = adc::kFifo.read() & 0xfff;
    device_.on_supply(static_cast<uint16_t>(sample * kSupplyFullScale_mv >> 12), now);
  }
  after_event();
}

void App::start_interrupts() {
  // An edge at sync in is timed before all others; the others do not interrupt each other.
  constexpr uint32_t kSecond = 0x40;
  constexpr unsigned kSeconds[] = {kIrqTimer0, kIrqUsb, kIrqAdc, kIrqEdge};
  for (const unsigned irq : kSeconds) {
    const Register priority = cortex::priority(irq);
    priority.write(priority.read() | kSecond << (irq % 4 * 8));
  }
  timer::kInterruptEnable.write(bit(0));
  cortex::kInterruptSet.write(bit(kIrqTimer0) | bit(kIrqUsb) | bit(kIrqIoBank0) | bit(kIrqAdc) |
                              bit(kIrqEdge));
}

/// Sets the alarm, sends what there is to send, shows the state.
void App::after_event() {
  usb_.send_reports();
  const uint64_t due = device_.next_due();
  if (due != due_) {
    due_ = due;
    if (device_.running())
      sio::kOutSet.write(bit(kPinLed));
    else
      sio::kOutClear.write(bit(kPinLed));
    timer::kArmed.write(bit(0));
  }
  if (due == board::SyncDevice::kNever || (timer::kArmed.read() & bit(0)) != 0) return;
  const uint64_t now = now_tick();
  const uint32_t wait = due > now ? static_cast<uint32_t>(due - now) : 0;
  if (wait == 0) {
    cortex::kPend.write(bit(kIrqTimer0));
    return;
  }
  const uint32_t target = now_us() + wait / kTicksPerUs + 1;
  timer::kAlarm0.write(target);
  // It only fires when the timer becomes equal: had that passed already, it would in an hour.
  if (static_cast<int32_t>(target - now_us()) <= 0) {
    timer::kArmed.write(bit(0));
    cortex::kPend.write(bit(kIrqTimer0));
  }
}

}  // namespace
}  // namespace glint::rp2040

using glint::rp2040::g_app;

extern "C" {
void on_timer_interrupt() { g_app->on_timer(); }
void on_usb_interrupt() { g_app->on_usb(glint::rp2040::fine_tick()); }
void on_pin_interrupt() { g_app->on_pin(); }
void on_adc_interrupt() { g_app->on_adc(); }
void on_edge_interrupt() { g_app->on_edge(); }

int main() {
  glint::rp2040::start_clocks();
  glint::rp2040::start_ticks();
  static glint::rp2040::App app;
  app.run();
}
}
