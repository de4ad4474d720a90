#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Makes the file that a Pico takes by drag and drop.

    make_uf2.py IMAGE.bin OUT.uf2      IMAGE begins at the start of the flash with boot2's 256 bytes, the last
                                       four of which are set to the checksum that the ROM wants
"""
import struct
import sys

FLASH = 0x10000000
RP2040_FAMILY = 0xE48BFF56
HAS_FAMILY = 0x2000
PAYLOAD = 256


def boot2_checksum(data):
    """CRC-32 as the ROM computes it: polynomial 04c11db7, most significant bit first, not inverted."""
    crc = 0xFFFFFFFF
    for byte in data:
        crc ^= byte << 24
        for _ in range(8):
            crc = (crc << 1 ^ (0x04C11DB7 if crc & 0x80000000 else 0)) & 0xFFFFFFFF
    return crc


def with_checksum(image):
    if any(image[252:256]):
        raise SystemExit("make_uf2.py: boot2 is longer than 252 bytes")
    return image[:252] + struct.pack("<I", boot2_checksum(image[:252])) + image[256:]


def uf2(image):
    image += b"\0" * (-len(image) % PAYLOAD)
    count = len(image) // PAYLOAD
    for number in range(count):
        payload = image[number * PAYLOAD:(number + 1) * PAYLOAD]
        head = struct.pack("<8I", 0x0A324655, 0x9E5D5157, HAS_FAMILY, FLASH + number * PAYLOAD, PAYLOAD, number, count,
                           RP2040_FAMILY)
        yield head + payload + b"\0" * (476 - PAYLOAD) + struct.pack("<I", 0x0AB16F30)


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    with open(sys.argv[1], "rb") as file:
        image = with_checksum(file.read())
    with open(sys.argv[2], "wb") as file:
        file.writelines(uf2(image))


if __name__ == "__main__":
    main()
