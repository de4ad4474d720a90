// SPDX-License-Identifier: MIT
#include "firmware/rp2040/pio_pulses.hpp"

#include "firmware/rp2040/pins.hpp"
#include "firmware/rp2040/pulse_program.hpp"
#include "firmware/rp2040/ticks.hpp"

namespace glint::rp2040 {
namespace {

constexpr unsigned kMachines = 4;  // a PIO block
/// From the fine tick read to the gate seen by the state machines: load and store, bridge to the slow bus,
/// synchroniser. Found in the simulator; silicon may differ by some ticks, the same for all outputs.
constexpr uint32_t kGateTicks = 6;
/// From the start of the interrupt to where it reads the tick, less what the state machines need to see an
/// edge.
constexpr uint32_t kEdgeTicks = 25;
constexpr uint32_t kFifoJoinReceive = bit(31);

const Pio& block_of(unsigned output) { return kPio[output / kMachines]; }
unsigned machine_of(unsigned output) { return output % kMachines; }
unsigned pin_of(unsigned output) {
  return output < kMachines ? kPinTrigger0 + output : kPinStrobe0 + output - kMachines;
}
/// The last machine of the other block measures; what it makes otherwise rests meanwhile.
unsigned measuring_output(int measured) {
  return measured < static_cast<int>(kMachines) ? 2 * kMachines - 1 : kMachines - 1;
}

uint32_t fifo_stalled(const Pio& pio) { return pio.fifo_debug().read() >> 24 & 0xf; }

/// Also empties both FIFOs: changing how they are joined does.
void set_up_machine(const Pio& pio, unsigned sm, uint32_t first, uint32_t last, uint32_t jump_pin,
                    uint32_t pins) {
  pio.control().clear(bit(sm));
  pio.clock_divider(sm).write(1u << 16);
  pio.execute_control(sm).write(jump_pin << 24 | last << 12 | first << 7);
  pio.shift_control(sm).write(kFifoJoinReceive);
  pio.shift_control(sm).write(0);
  pio.pin_control(sm).write(pins);
  pio.control().set(bit(sm + 4) | bit(sm + 8));
  pio.execute(sm).write(pulse_program::jump(pulse_program::kAlways, first));
}

uint32_t pulse_pins(unsigned output, bool sync_out) {
  constexpr uint32_t kOneSideSet = 1u << 29, kOneSet = 1u << 26;
  uint32_t pins = kOneSideSet | pin_of(output) << 10;
  if (sync_out) pins |= kOneSet | kPinSyncOut << 5;
  return pins;
}

/// The machine's SET drives the pin low and makes it an output, before the pin listens to it.
void drive_low(const Pio& pio, unsigned sm, unsigned pin) {
  constexpr uint32_t kOneSet = 1u << 26;
  pio.pin_control(sm).write(kOneSet | pin << 5);
  pio.execute(sm).write(pulse_program::kSetPinsLow);
  pio.execute(sm).write(pulse_program::kSetPinsOut);
}

void make_pin(unsigned pin, io::Function function, uint32_t pad) {
  pads::pin(pin).write(pad);
  io::control(pin).write(static_cast<uint32_t>(function));
}

}  // namespace

PioPulses::PioPulses(bool strobes_active_low) : active_low_(strobes_active_low ? 0xf0 : 0) {
  constexpr uint32_t kPad = pads::kDrive4mA | pads::kSchmitt | pads::kInputEnable;
  for (const Pio& pio : kPio)
    for (unsigned i = 0; i < pulse_program::kMeasureLength; ++i)
      pio.instruction_memory(pulse_program::kMeasureStart + i).write(pulse_program::measure(i));
  for (unsigned i = 0; i < GLINT_SYNC_OUTPUTS; ++i) drive_low(block_of(i), machine_of(i), pin_of(i));
  drive_low(kPio[0], 0, kPinSyncOut);
  override_outputs();
  for (unsigned i = 0; i < GLINT_SYNC_OUTPUTS; ++i)
    io::control(pin_of(i)).write_field(
        0x1f, static_cast<uint32_t>(i < kMachines ? io::Function::Pio0 : io::Function::Pio1));
  for (unsigned i = 0; i < GLINT_SYNC_OUTPUTS; ++i) pads::pin(pin_of(i)).write(kPad);
  make_pin(kPinSyncOut, io::Function::Pio0, kPad);
  make_pin(kPinSyncIn, io::Function::None, kPad | pads::kPullDown | pads::kOutputDisable);
  make_pin(kPinGate, io::Function::None, kPad | pads::kPullDown | pads::kOutputDisable);
  halt();
}

void PioPulses::prepare(const Setup& setup) {
  halt();
  setup_ = setup;
  active_low_ = setup.active_low;
  override_outputs();
  used_ = fresh_ = 0xff;
  pulsed_ = 0;
  low_taken_ = false;
  const unsigned gate_pin = setup.external ? kPinSyncIn : kPinGate;
  for (const Pio& pio : kPio)
    for (unsigned i = 0; i < pulse_program::kPulseLength; ++i)
      pio.instruction_memory(i).write(pulse_program::pulse(i, gate_pin));
  for (unsigned i = 0; i < GLINT_SYNC_OUTPUTS; ++i) start_machine(i);
  if (setup.measured >= 0) start_measuring();
  for (const Pio& pio : kPio) pio.control().set(0xf);
}

void PioPulses::start_machine(unsigned output) {
  set_up_machine(block_of(output), machine_of(output), 0, pulse_program::kPulseLength - 1, 0,
                 pulse_pins(output, output == 0 && setup_.sync_out));
}

void PioPulses::start_measuring() {
  const unsigned output = measuring_output(setup_.measured);
  used_ &= static_cast<uint8_t>(~bit(output));
  const bool inverted = (active_low_ & bit(static_cast<unsigned>(setup_.measured))) != 0;
  io::override_in(kPinSyncIn, inverted ? io::Override::Invert : io::Override::Normal);
  set_up_machine(block_of(output), machine_of(output), pulse_program::kMeasureStart,
                 pulse_program::kMeasureStart + pulse_program::kMeasureLength - 1, kPinSyncIn, 0);
}

void PioPulses::feed(unsigned output, uint32_t low, uint32_t width) {
  const uint8_t mask = static_cast<uint8_t>(1u << output);
  if ((used_ & mask) == 0) return;
  uint32_t beside = (pulsed_ & mask) != 0 ? pulse_program::kLowAfterPulse : pulse_program::kLowAfterNone;
  if (setup_.external)
    beside = 0;
  else if ((fresh_ & mask) != 0)
    beside = pulse_program::kLowAfterGate;
  fresh_ &= static_cast<uint8_t>(~mask);
  pulsed_ = static_cast<uint8_t>(width != 0 ? pulsed_ | mask : pulsed_ & ~mask);
  const Register words = block_of(output).transmit(machine_of(output));
  words.write(low - beside);
  words.write(width == 0 ? 0 : width - pulse_program::kWidthBeside);
}

unsigned PioPulses::waiting_words(unsigned output) const {
  if ((used_ & bit(output)) == 0) return 0;
  return block_of(output).fifo_levels().read() >> (8 * machine_of(output)) & 0xf;
}

bool PioPulses::ran_dry() const {
  return ((fifo_stalled(kPio[0]) | fifo_stalled(kPio[1]) << kMachines) & used_) != 0;
}

uint64_t PioPulses::open_gate() {
  // Machines stalled until they were fed, as they should.
  for (const Pio& pio : kPio) pio.fifo_debug().write(0xfu << 24);
  const uint32_t open = io::control(kPinGate).read() | static_cast<uint32_t>(io::Override::High)
                                                           << io::kInShift;
  asm volatile("cpsid i" ::: "memory");
  const uint32_t fine = fine_tick();
  io::control(kPinGate).write(open);
  asm volatile("cpsie i" ::: "memory");
  return full_tick(fine) + kGateTicks;
}

bool PioPulses::arm(bool& missed) {
  const bool falling = setup_.falling_edge;
  const uint32_t edge = falling ? io::edge_low(kPinSyncIn) : io::edge_high(kPinSyncIn);
  missed = (io::raised(kPinSyncIn).read() & edge) != 0;
  io::raised(kPinSyncIn).write(edge);
  const bool high = (io::status(kPinSyncIn).read() & io::kFromPad) != 0;
  if (high != falling) return false;
  // The gate first: an edge in between fires at once, and is timed as soon as the interrupt may come.
  io::override_in(kPinSyncIn, falling ? io::Override::Invert : io::Override::Normal);
  io::interrupt_enable(kPinSyncIn).set(edge);
  return true;
}

bool PioPulses::disarm() {
  const uint32_t edges = io::edge_low(kPinSyncIn) | io::edge_high(kPinSyncIn);
  const bool taken = (io::interrupt_enable(kPinSyncIn).read() & edges) == 0;
  // First the interrupt, so that it does not change the gate in between.
  io::interrupt_enable(kPinSyncIn).clear(edges);
  io::override_in(kPinSyncIn, io::Override::Low);
  // The machines know whether they went through before it closed.
  if (taken || kPio[0].address(0).read() <= pulse_program::kWaitLine) return taken;
  io::interrupt_enable(kPinSyncIn)
      .set(setup_.falling_edge ? io::edge_low(kPinSyncIn) : io::edge_high(kPinSyncIn));
  return true;
}

uint64_t PioPulses::take_edge() {
  const uint32_t fine = fine_tick();
  io::override_in(kPinSyncIn, io::Override::Low);
  io::interrupt_enable(kPinSyncIn).clear(io::edge_low(kPinSyncIn) | io::edge_high(kPinSyncIn));
  io::raised(kPinSyncIn).write(io::edge_low(kPinSyncIn) | io::edge_high(kPinSyncIn));
  return full_tick(fine) - kEdgeTicks;
}

void PioPulses::halt() {
  for (const Pio& pio : kPio) pio.control().clear(0xf);
  io::override_in(kPinGate, io::Override::Low);
  io::override_in(kPinSyncIn, io::Override::Low);
  io::interrupt_enable(kPinSyncIn).clear(io::edge_low(kPinSyncIn) | io::edge_high(kPinSyncIn));
  io::raised(kPinSyncIn).write(io::edge_low(kPinSyncIn) | io::edge_high(kPinSyncIn));
  // Side-set level 0 on each output, and its sync out.
  for (unsigned i = 0; i < GLINT_SYNC_OUTPUTS; ++i) {
    const Pio& pio = block_of(i);
    pio.execute_control(machine_of(i)).write(0);
    pio.pin_control(machine_of(i)).write(pulse_pins(i, i == 0));
    pio.execute(machine_of(i)).write(pulse_program::kSetPinsLow);
  }
}

void PioPulses::hold_strobes(bool hold) {
  hold_strobes_ = hold;
  override_outputs();
}

void PioPulses::override_outputs() {
  for (unsigned i = 0; i < GLINT_SYNC_OUTPUTS; ++i) {
    const bool low = (active_low_ & bit(i)) != 0;
    const bool held = hold_strobes_ && i >= kMachines;
    const io::Override idle = low ? io::Override::High : io::Override::Low;
    const io::Override driven = low ? io::Override::Invert : io::Override::Normal;
    io::override_out(pin_of(i), held ? idle : driven);
  }
  const bool low = (active_low_ & 1) != 0;
  io::override_out(kPinSyncOut, low ? io::Override::Invert : io::Override::Normal);
}

bool PioPulses::take_measured(uint32_t& low, uint32_t& width) {
  if (setup_.measured < 0) return false;
  const unsigned output = measuring_output(setup_.measured);
  const Register words = block_of(output).receive(machine_of(output));
  const auto waits = [&] {
    return (block_of(output).fifo_levels().read() >> (8 * machine_of(output) + 4) & 0xf) != 0;
  };
  if (!low_taken_) {
    if (!waits()) return false;
    measured_low_ = words.read() * pulse_program::kMeasureResolution + pulse_program::kMeasureLow;
    low_taken_ = true;
  }
  if (!waits()) return false;
  low = measured_low_;
  width = words.read() * pulse_program::kMeasureResolution + pulse_program::kMeasureHigh;
  low_taken_ = false;
  return true;
}

uint32_t PioPulses::measure_resolution() const { return pulse_program::kMeasureResolution; }

}  // namespace glint::rp2040
