// SPDX-License-Identifier: MIT
// From the flash into RAM: everything else runs from there, so that no cache decides how long it takes.
  .syntax unified
  .cpu cortex-m0plus
  .thumb

  .section .start, "ax"
  .word stack_top
  .word start
  .thumb_func
start:
  ldr r0, =ram_image        // copy code and data
  ldr r1, =ram_begin
  ldr r2, =ram_end
1: cmp r1, r2
  bhs 2f
  ldm r0!, {r3}
  stm r1!, {r3}
  b 1b
2: ldr r1, =zero_begin
  ldr r2, =zero_end
  movs r3, #0
3: cmp r1, r2
  bhs 4f
  stm r1!, {r3}
  b 3b
4: ldr r0, =vectors
  ldr r1, =0xe000ed08       // VTOR
  str r0, [r1]
  ldr r0, =main
  bx r0
  .ltorg

  .section .vectors, "a"
  .global vectors
  .balign 256
vectors:
  .word stack_top
  .word start
  .word dead                // NMI
  .word dead                // hard fault
  .fill 7, 4, 0
  .word dead                // SVCall
  .fill 2, 4, 0
  .word dead                // PendSV
  .word dead                // SysTick
  .word on_timer_interrupt  // 0
  .rept 4
  .word dead
  .endr
  .word on_usb_interrupt    // 5
  .rept 7
  .word dead
  .endr
  .word on_pin_interrupt    // 13
  .rept 8
  .word dead
  .endr
  .word on_adc_interrupt    // 22
  .rept 3
  .word dead
  .endr
  .word on_edge_interrupt   // 26
  .rept 5
  .word dead
  .endr

// Nothing is to be done but to wait for the watchdog; outputs go low by themselves when nobody feeds them.
  .section .text.dead, "ax"
  .thumb_func
dead:
  b dead
