// SPDX-License-Identifier: MIT
// What happens at which cycle: alarms in order, and the clock that rp2040js' peripherals ask for the time.

export const CYCLE_NS = 8; // 125 MHz

/** One callback that may wait for one moment. Made by EventQueue.create_alarm(). */
class Alarm {
  constructor(queue, callback) {
    this.queue = queue;
    this.callback = callback;
    this.cycle = Infinity;
    this.next = null;
    this.scheduled = false;
  }

  /** Waits for that cycle, or for now if it is past; forgets the moment it waited for before. */
  at(cycle) {
    if (this.scheduled) this.queue.unlink(this);
    this.queue.link(this, Math.max(cycle, this.queue.now));
  }

  /** rp2040js' way: so many nanoseconds from now. */
  schedule(nanos) {
    this.at(this.queue.now + Math.max(0, Math.ceil(nanos / CYCLE_NS - 1e-6)));
  }

  cancel() {
    if (this.scheduled) this.queue.unlink(this);
  }
}

/** Alarms by cycle; those of the same cycle in the order in which they were set. */
export class EventQueue {
  constructor() {
    this.now = 0; // cycle of what is being done
    this.first = null;
    this.next = Infinity; // cycle of the first alarm
    this.limit = Infinity; // the processor runs up to here; lowered when something is to happen earlier
  }

  create_alarm(callback) {
    return new Alarm(this, callback);
  }

  /** Calls back once, at that cycle. */
  at(cycle, callback) {
    const alarm = new Alarm(this, callback);
    alarm.at(cycle);
    return alarm;
  }

  link(alarm, cycle) {
    alarm.cycle = cycle;
    alarm.scheduled = true;
    let before = null;
    let after = this.first;
    while (after !== null && after.cycle <= cycle) {
      before = after;
      after = after.next;
    }
    alarm.next = after;
    if (before === null) {
      this.first = alarm;
      this.next = cycle;
      this.wake(cycle);
    } else {
      before.next = alarm;
    }
  }

  unlink(alarm) {
    if (this.first === alarm) {
      this.first = alarm.next;
      this.next = this.first === null ? Infinity : this.first.cycle;
    } else {
      let before = this.first;
      while (before.next !== alarm) before = before.next;
      before.next = alarm.next;
    }
    alarm.next = null;
    alarm.scheduled = false;
  }

  /** The processor must stop at this cycle and let events happen. */
  wake(cycle) {
    if (cycle < this.limit) this.limit = cycle;
  }

  /** Lets the first alarm happen. */
  run_first() {
    const alarm = this.first;
    this.unlink(alarm);
    this.now = alarm.cycle;
    alarm.callback();
  }
}

/** The queue as the clock of one life of the chip: at its reset all alarms that were made through it are dropped. */
export class ChipClock {
  constructor(queue) {
    this.queue = queue;
    this.alarms = [];
  }

  get nanos() {
    return this.queue.now * CYCLE_NS;
  }

  get micros() {
    return this.nanos / 1000;
  }

  createAlarm(callback) {
    const alarm = this.queue.create_alarm(callback);
    this.alarms.push(alarm);
    return alarm;
  }

  drop_alarms() {
    for (const alarm of this.alarms) alarm.cancel();
  }
}
