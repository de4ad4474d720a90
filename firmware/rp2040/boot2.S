// SPDX-License-Identifier: MIT
// Second stage of the boot: the ROM checks these 256 bytes and runs them in RAM. They make the flash readable
// as memory with the plainest command (03h, one bit a clock, a quarter of the processor's), which every chip knows,
// and go on in the flash. make_uf2.py appends the checksum.
  .syntax unified
  .cpu cortex-m0plus
  .thumb
  .section .boot2, "ax"
  .global boot2
  .thumb_func
boot2:
  ldr r3, =0x18000000       // SSI
  movs r0, #0
  str r0, [r3, #0x08]       // SSIENR: off while it is changed
  movs r0, #4
  str r0, [r3, #0x14]       // BAUDR
  ldr r0, =0x001f0300       // CTRLR0: 32-bit words, "EEPROM read"
  str r0, [r3, #0x00]
  ldr r0, =0x03000218       // SPI_CTRLR0: command 03h of 8 bits, address of 24
  movs r1, #0xf4
  str r0, [r3, r1]
  movs r0, #0
  str r0, [r3, #0x04]       // CTRLR1: one word at a time
  movs r0, #1
  str r0, [r3, #0x08]       // on
  ldr r0, =0x10000100       // what start.S has there
  ldm r0!, {r1, r2}
  mov sp, r1
  bx r2
  .ltorg
