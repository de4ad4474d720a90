// SPDX-License-Identifier: MIT
// What the sync board and its host say to each other over USB HID: the only definition, for C11 and C++20.
#pragma once

#include <stdint.h>

// All reports are 56 bytes, report id included, little endian. Byte 0 is the report id, byte 1 the protocol's
// major number; a receiver refuses another one. Reserved bytes are 0 and ignored. Times are ticks of the
// board's 64-bit counter, which runs at glint_sync_info.tick_hz from power-up and never wraps in practice.
//
// Settings are staged: SET of RUN and of OUTPUTs changes nothing by itself. START begins a run with them;
// APPLY while running makes them take effect together, on the next frame that is not planned yet. Both check
// the whole plan; what they refuse, and any other SET refused, stalls, and STATUS says why (refusal,
// refusal_output, refusal_limit). A frame is what begins with one pulse of the common period; outputs are
// `delay` behind it.

#define GLINT_SYNC_PROTOCOL_MAJOR 1
#define GLINT_SYNC_PROTOCOL_MINOR 0

#define GLINT_SYNC_VENDOR_ID 0x1209  // pid.codes; 0x0001 is their id for tests
#define GLINT_SYNC_PRODUCT_ID 0x0001
#define GLINT_SYNC_PRODUCT "glint sync board"
#define GLINT_SYNC_USAGE_PAGE 0xff00  // vendor defined, usage 1

#define GLINT_SYNC_REPORT_BYTES 56
#define GLINT_SYNC_OUTPUTS 8   // bit i of an output mask is output i
#define GLINT_SYNC_TRIGGERS 4  // outputs 0-3 trigger cameras, 4-7 switch lights (strobes)
#define GLINT_SYNC_TRIGGERS_PER_REPORT 4

enum glint_sync_report_id {
  GLINT_SYNC_INPUT = 0x01,     // interrupt IN: glint_sync_input
  GLINT_SYNC_STATUS = 0x10,    // feature, GET: glint_sync_status
  GLINT_SYNC_RUN = 0x11,       // feature, GET and SET: glint_sync_run (what is staged)
  GLINT_SYNC_LIMITS = 0x13,    // feature, GET and SET: glint_sync_limits
  GLINT_SYNC_COMMAND = 0x14,   // feature, SET: glint_sync_command
  GLINT_SYNC_INFO = 0x15,      // feature, GET: glint_sync_info
  GLINT_SYNC_TIME = 0x16,      // feature, GET: glint_sync_time
  GLINT_SYNC_FETCH = 0x17,     // feature, SET: glint_sync_fetch; GET: that input report, or kind GONE
  GLINT_SYNC_SELFTEST = 0x18,  // feature, GET: glint_sync_selftest
  GLINT_SYNC_OUTPUT = 0x20     // feature, GET and SET: glint_sync_output; 0x20 + i is output i's (staged)
};

// What an input report tells; everything but TRIGGERS is an event.
enum glint_sync_kind {
  GLINT_SYNC_KIND_TRIGGERS = 0,  // one to four triggers; sent when the last of them has begun
  GLINT_SYNC_KIND_BOOTED = 1,    // first of an epoch; detail: glint_sync_reset
  GLINT_SYNC_KIND_STARTED = 2,   // tick, sequence: of the first frame to come (external: of the arming)
  GLINT_SYNC_KIND_STOPPED = 3,   // detail: glint_sync_stop | glint_sync_fault << 8; sequence: its frames
  GLINT_SYNC_KIND_APPLIED = 4,   // sequence: first frame with the new plan
  GLINT_SYNC_KIND_LOCKED = 5,    // supply too high, strobes are off; detail: mV
  GLINT_SYNC_KIND_REARMED = 6,   // supply is back; sequence: first frame with strobes; detail: mV
  GLINT_SYNC_KIND_GONE = 0xff    // answer to FETCH: no longer, or not yet, held; report_no: the oldest held
};

enum glint_sync_state {
  GLINT_SYNC_IDLE = 0,
  GLINT_SYNC_RUNNING = 1,
  GLINT_SYNC_WAITING = 2,  // for an external trigger
  GLINT_SYNC_TESTING = 3   // self-test
};

// Bits of glint_sync_input.flags and glint_sync_status.flags.
enum glint_sync_flags {
  GLINT_SYNC_FLAG_LOCKED = 1,   // supply lockout: strobes are held off
  GLINT_SYNC_FLAG_FAULT = 2,    // a fault stands (status.fault); START is refused until CLEAR
  GLINT_SYNC_FLAG_WATCHDOG = 4  // the watchdog ended the epoch before this one
};

// Bits of glint_sync_input.trigger_flags.
enum glint_sync_trigger_flags {
  GLINT_SYNC_TRIGGER_DARK = 1,      // the code leaves this one dark: strobes off or short
  GLINT_SYNC_TRIGGER_EXTERNAL = 2,  // begun by an edge at sync in; its tick was measured
  GLINT_SYNC_TRIGGER_LOCKED = 4,    // strobes were held off by the supply lockout
  GLINT_SYNC_TRIGGER_HELD = 8,  // a strobe was left out, because it would have come too soon after its last
  GLINT_SYNC_TRIGGER_LAST = 16  // last of a burst
};

enum glint_sync_stop {
  GLINT_SYNC_STOP_COMMAND = 0,
  GLINT_SYNC_STOP_BURST_END = 1,
  GLINT_SYNC_STOP_HOST_GONE = 2,  // no word for keepalive_ms, or the bus was suspended or reset
  GLINT_SYNC_STOP_FAULT = 3
};

enum glint_sync_fault {
  GLINT_SYNC_FAULT_NONE = 0,
  GLINT_SYNC_FAULT_UNDERRUN = 1,  // the next pulse was not ready in time; outputs stayed low
  GLINT_SYNC_FAULT_STALLED = 2,   // a pulse that should have begun has not
  GLINT_SYNC_FAULT_SUPPLY = 3     // the supply cannot be measured (no samples)
};

enum glint_sync_reset {
  GLINT_SYNC_RESET_POWER = 0,
  GLINT_SYNC_RESET_WATCHDOG = 1,
  GLINT_SYNC_RESET_COMMAND = 2
};

// Why the last SET was refused; refusal_limit is the limit that it broke, in the unit of the setting.
enum glint_sync_refusal {
  GLINT_SYNC_REFUSED_NOTHING = 0,
  GLINT_SYNC_REFUSED_FORMAT = 1,  // length, protocol number or a value that has no meaning
  GLINT_SYNC_REFUSED_REPORT = 2,  // no such report, or not to be set
  GLINT_SYNC_REFUSED_STATE = 3,   // not in this state (START while running, self-test while running)
  GLINT_SYNC_REFUSED_FAULT = 4,   // a fault stands: CLEAR first
  GLINT_SYNC_REFUSED_MAGIC = 5,   // RESET and BOOTLOADER want their number
  GLINT_SYNC_REFUSED_PERIOD_SHORT = 6,
  GLINT_SYNC_REFUSED_PERIOD_LONG = 7,
  GLINT_SYNC_REFUSED_DELAY = 8,  // not below the period
  GLINT_SYNC_REFUSED_WIDTH_SHORT = 9,
  GLINT_SYNC_REFUSED_WIDTH_LONG = 10,    // see glint_sync_output
  GLINT_SYNC_REFUSED_STROBE_WIDTH = 11,  // above the cap
  GLINT_SYNC_REFUSED_STROBE_DUTY = 12,   // above the cap; limit in permille
  GLINT_SYNC_REFUSED_POLARITY = 13,  // a strobe's is the jumper's (limit: 1 = low); others: not while running
  GLINT_SYNC_REFUSED_PHASE = 14,     // not below every_n
  GLINT_SYNC_REFUSED_CODE = 15,      // group out of range; limit: the nearest allowed one
  GLINT_SYNC_REFUSED_LOCKOUT = 16,   // limits: above the cap, mV
  GLINT_SYNC_REFUSED_NO_OUTPUT = 17,  // no output is enabled, or there is none of that number
  GLINT_SYNC_REFUSED_SUPPLY = 18,     // self-test of a strobe during lockout
  GLINT_SYNC_REFUSED_REARM = 19       // limits: above the cap, or not far enough below lockout_mv, mV
};

enum glint_sync_command_code {
  GLINT_SYNC_COMMAND_STOP = 0,  // after the frame that is under way
  GLINT_SYNC_COMMAND_START = 1,
  GLINT_SYNC_COMMAND_APPLY = 2,
  GLINT_SYNC_COMMAND_CLEAR = 3,       // the fault
  GLINT_SYNC_COMMAND_KEEP_ALIVE = 4,  // any report that the host gets or sets counts as well
  GLINT_SYNC_COMMAND_SELFTEST = 5,    // argument: output, wired to sync in
  GLINT_SYNC_COMMAND_RESET = 6,       // argument: GLINT_SYNC_MAGIC_RESET
  GLINT_SYNC_COMMAND_BOOTLOADER = 7  // argument: GLINT_SYNC_MAGIC_BOOTLOADER; the board comes back as a drive
};
#define GLINT_SYNC_MAGIC_RESET 0x7e57b0a2u
#define GLINT_SYNC_MAGIC_BOOTLOADER 0xb007f1a5u

typedef struct glint_sync_input {
  uint8_t report_id;  // GLINT_SYNC_INPUT, or GLINT_SYNC_FETCH where it answers a FETCH
  uint8_t protocol;
  uint8_t kind;        // glint_sync_kind
  uint8_t flags;       // glint_sync_flags
  uint32_t epoch;      // another number after each reset of the board
  uint32_t report_no;  // 0, 1, 2 ... within the epoch
  uint16_t run;        // 1, 2, ... within the epoch; 0 before the first
  uint16_t supply_mv;  // of the lights, averaged over some milliseconds
  uint64_t tick;       // TRIGGERS: beginning of the first one's frame; else when it happened
  uint32_t sequence;   // TRIGGERS: number of the first one, counted from 0 in each run
  uint32_t detail;     // by kind
  uint8_t count;       // TRIGGERS: 1 to 4, else 0
  uint8_t queued;      // reports that wait behind this one
  uint16_t unsent;     // reports of this epoch that the host did not take in time; FETCH has them
  uint32_t step_ticks[GLINT_SYNC_TRIGGERS_PER_REPORT - 1];  // from the trigger before: second to fourth
  uint8_t outputs[GLINT_SYNC_TRIGGERS_PER_REPORT];          // mask of those that fired
  uint8_t trigger_flags[GLINT_SYNC_TRIGGERS_PER_REPORT];    // glint_sync_trigger_flags
} glint_sync_input;

typedef struct glint_sync_status {
  uint8_t report_id;
  uint8_t protocol;
  uint8_t state;  // glint_sync_state
  uint8_t flags;  // glint_sync_flags
  uint32_t epoch;
  uint32_t next_report_no;
  uint16_t run;
  uint16_t supply_mv;
  uint64_t now_tick;
  uint32_t sequence;          // frames of this run that have begun
  uint32_t applied_sequence;  // first frame of the plan in force
  uint32_t unsent;            // as in glint_sync_input
  uint32_t ignored_edges;     // frames of this run after which sync in was sooner than the period allows
  uint8_t fault;              // glint_sync_fault
  uint8_t refusal;            // glint_sync_refusal of the last SET; SETs that are accepted clear it
  uint8_t refusal_output;     // 0-7, or 0xff where it is not about an output
  uint8_t reset_reason;       // glint_sync_reset
  uint32_t refusal_limit;
  uint32_t
      held_strobes;     // pulses with GLINT_SYNC_TRIGGER_HELD in this run; 0 unless the firmware is at fault
  uint16_t lockouts;    // in this epoch
  uint8_t stop_reason;  // glint_sync_stop of the last run
  uint8_t reserved;
} glint_sync_status;

enum glint_sync_run_flags {
  GLINT_SYNC_RUN_EXTERNAL = 1,     // edges at sync in begin frames, not more often than period_ticks
  GLINT_SYNC_RUN_SYNC_OUT = 2,     // sync out repeats output 0
  GLINT_SYNC_RUN_FALLING_EDGE = 4  // with EXTERNAL: falling edges instead
};

typedef struct glint_sync_run {
  uint8_t report_id;
  uint8_t protocol;
  uint8_t flags;  // glint_sync_run_flags
  uint8_t reserved1;
  uint32_t period_ticks;
  uint32_t pulses;            // frames of the run; 0: endless, 1: single shot
  uint32_t code_seed;         // see pulse_code.h
  uint16_t code_group;        // 18 to 1024; 0: no frame is dark
  uint16_t keepalive_ms;      // 0: runs without its host
  uint32_t dark_width_ticks;  // of strobes in dark frames; 0: off
  uint32_t reserved[8];
} glint_sync_run;

enum glint_sync_output_flags { GLINT_SYNC_OUTPUT_ENABLED = 1, GLINT_SYNC_OUTPUT_ACTIVE_LOW = 2 };

// delay < period; width + least gap <= period; delay + width <= 1.5 period, or where frames begin with edges
// at sync in, <= period - least gap.
typedef struct glint_sync_output {
  uint8_t report_id;
  uint8_t protocol;
  uint8_t flags;    // glint_sync_output_flags
  uint8_t every_n;  // fires in frames with sequence % every_n == phase; 1: in all
  uint8_t phase;
  uint8_t reserved1[3];
  uint32_t delay_ticks;  // from the frame's beginning to the active edge
  uint32_t width_ticks;
  uint32_t reserved[10];
} glint_sync_output;

// SET lowers the limits, or raises them again up to the firmware's own caps; the read-only ones are ignored.
typedef struct glint_sync_limits {
  uint8_t report_id;
  uint8_t protocol;
  uint16_t lockout_mv;  // strobes go off above it; cap 14000
  uint16_t rearm_mv;    // and come back below it; cap 13800, at least 100 mV below lockout_mv
  uint16_t
      strobe_max_duty_permille;  // share of time that a strobe may be on, from each rise to the next; cap 25
  uint32_t strobe_max_width_ticks;  // cap 300 us
  uint32_t min_period_ticks;        // read only
  uint32_t max_period_ticks;        // read only
  uint32_t min_width_ticks;         // read only
  uint32_t min_gap_ticks;           // read only: from the end of an output's pulse to its next
  uint32_t reserved[7];
} glint_sync_limits;

typedef struct glint_sync_command {
  uint8_t report_id;
  uint8_t protocol;
  uint8_t command;  // glint_sync_command_code
  uint8_t reserved1;
  uint32_t argument;
  uint32_t reserved[12];
} glint_sync_command;

typedef struct glint_sync_info {
  uint8_t report_id;
  uint8_t protocol;        // GLINT_SYNC_PROTOCOL_MAJOR: the one field at the same place in every version
  uint8_t protocol_minor;  // grows with additions
  uint8_t outputs;
  uint8_t triggers;
  uint8_t strobes_active_low;  // as the jumper says: 0 or 1
  uint16_t reserved1;
  uint32_t firmware_version;  // major << 16 | minor << 8 | patch
  uint32_t tick_hz;
  uint32_t held_reports;  // how many input reports FETCH can go back
  uint32_t epoch;
  uint8_t serial[8];  // of the flash chip; the USB serial number is its hexadecimal form
  char build[24];     // name of the commit, zero-terminated
} glint_sync_info;

typedef struct glint_sync_time {
  uint8_t report_id;
  uint8_t protocol;
  uint16_t reserved1;
  uint32_t epoch;
  uint64_t tick;     // when the request reached the board
  uint32_t queries;  // answered in this epoch, this one included
  uint32_t reserved[9];
} glint_sync_time;

typedef struct glint_sync_fetch {
  uint8_t report_id;
  uint8_t protocol;
  uint16_t reserved1;
  uint32_t report_no;
  uint32_t reserved[12];
} glint_sync_fetch;

enum glint_sync_selftest_state {
  GLINT_SYNC_SELFTEST_NONE = 0,
  GLINT_SYNC_SELFTEST_RUNNING = 1,
  GLINT_SYNC_SELFTEST_DONE = 2  // seen == 0: no wire from that output to sync in
};

typedef struct glint_sync_selftest {
  uint8_t report_id;
  uint8_t protocol;
  uint8_t state;  // glint_sync_selftest_state
  uint8_t output;
  uint32_t sent;
  uint32_t seen;  // pulses measured at sync in
  uint32_t resolution_ticks;
  uint32_t width_ticks;  // as sent
  uint32_t least_width_ticks;
  uint32_t most_width_ticks;
  uint32_t period_ticks;  // as sent
  uint32_t least_period_ticks;
  uint32_t most_period_ticks;
  uint32_t reserved[4];
} glint_sync_selftest;

#ifdef __cplusplus
#define GLINT_SYNC_ASSERT_SIZE(type) static_assert(sizeof(type) == GLINT_SYNC_REPORT_BYTES, #type)
#else
#define GLINT_SYNC_ASSERT_SIZE(type) _Static_assert(sizeof(type) == GLINT_SYNC_REPORT_BYTES, #type)
#endif
GLINT_SYNC_ASSERT_SIZE(glint_sync_input);
GLINT_SYNC_ASSERT_SIZE(glint_sync_status);
GLINT_SYNC_ASSERT_SIZE(glint_sync_run);
GLINT_SYNC_ASSERT_SIZE(glint_sync_output);
GLINT_SYNC_ASSERT_SIZE(glint_sync_limits);
GLINT_SYNC_ASSERT_SIZE(glint_sync_command);
GLINT_SYNC_ASSERT_SIZE(glint_sync_info);
GLINT_SYNC_ASSERT_SIZE(glint_sync_time);
GLINT_SYNC_ASSERT_SIZE(glint_sync_fetch);
GLINT_SYNC_ASSERT_SIZE(glint_sync_selftest);
#undef GLINT_SYNC_ASSERT_SIZE
