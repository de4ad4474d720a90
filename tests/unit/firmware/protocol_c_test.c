/* SPDX-License-Identifier: MIT */
/* The protocol as a C compiler sees it. */
#include <stddef.h>

#include "firmware/protocol/pulse_code.h"
#include "firmware/protocol/sync_report.h"

const size_t glint_offsets_in_c[] = {
    offsetof(glint_sync_input, report_no),
    offsetof(glint_sync_input, tick),
    offsetof(glint_sync_input, step_ticks),
    offsetof(glint_sync_input, trigger_flags),
    offsetof(glint_sync_status, now_tick),
    offsetof(glint_sync_status, refusal_limit),
    offsetof(glint_sync_run, code_seed),
    offsetof(glint_sync_output, width_ticks),
    offsetof(glint_sync_limits, min_period_ticks),
    offsetof(glint_sync_info, build),
    offsetof(glint_sync_time, tick),
    offsetof(glint_sync_selftest, most_period_ticks),
    ~(size_t)0};
