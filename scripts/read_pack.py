#!/usr/bin/env python3
"""Reads a cairn pack as docs/pack-format.md and docs/height-codec.md describe it, without the program's code.

usage: read_pack.py PACK               lists the tiles, one per line
       read_pack.py PACK LEVEL/X/Y...  prints height tiles: samples in quanta, one row per line from the south, or `void`
       read_pack.py --check PACK       decodes every tile of heights

Python's standard library and libzstd (by ctypes); with libxxhash, every checksum is compared as well.
"""
import ctypes
import ctypes.util
import itertools
import struct
import sys

LAYERS = ["heights", "imagery", "rqt", "objects", "water", "models"]
CONSTANT = 1


def function(library, name, result, *arguments):
    path = ctypes.util.find_library(library)
    found = getattr(ctypes.CDLL(path), name) if path else None
    if found:
        found.restype, found.argtypes = result, arguments
    return found


SIZE, TEXT = ctypes.c_size_t, ctypes.c_char_p
ZSTD_DECOMPRESS = function("zstd", "ZSTD_decompress", SIZE, TEXT, SIZE, TEXT, SIZE)
XXH3 = function("xxhash", "XXH3_64bits", ctypes.c_uint64, TEXT, SIZE)


def expect(condition, what):
    if not condition:
        raise ValueError("damaged: " + what)


def unzstd(frame, size):
    plain = ctypes.create_string_buffer(size + 1)
    expect(ZSTD_DECOMPRESS(plain, size, frame, len(frame)) == size, "zstd frame")
    return plain.raw[:size]


def checked(data, checksum, what):
    expect(not XXH3 or XXH3(data, len(data)) == checksum, what + ": checksum")
    return data


def signed(value):
    return -(value >> 1) - 1 if value & 1 else value >> 1


def tile_of(key):
    """Layer, level, x and y of a key."""
    layer, number = key >> 59, key & (1 << 59) - 1
    level = -9
    while number >= 4 ** (level + 9):
        number -= 4 ** (level + 9)
        level += 1
    return layer, level, *(sum((number >> 2 * i + axis & 1) << i for i in range(30)) for axis in (0, 1))


class Columns:
    def __init__(self, data):
        self.data, self.at = data, 0

    def number(self):
        value = shift = 0
        while self.data[self.at] > 127:
            value |= (self.data[self.at] & 127) << shift
            self.at, shift = self.at + 1, shift + 7
        self.at += 1
        return value | self.data[self.at - 1] << shift

    def numbers(self, count):
        return [self.number() for _ in range(count)]


class Entry:
    """A tile: layer, level, x, y, flags, bytes, offset, checksum, minimum, maximum, error, filled."""
    def __str__(self):
        return (f"{LAYERS[self.layer]}/{self.level}/{self.x}/{self.y} flags {self.flags} min {self.minimum} "
                f"max {self.maximum} error {self.error:.9g} filled {self.filled} bytes {self.bytes}")


class Pack:
    def __init__(self, path):
        self.file = open(path, "rb")
        start = self.read(0, 16384)
        expect(start[:8] == b"\x89CAIRN\r\n", "magic")
        (version, self.size, _, self.quantum, body, self.major, self.minor, datum, self.count, _, metadata_at,
         metadata_bytes, metadata_sum, root_bytes, _, root_sum) = struct.unpack_from("<HHId32sdd40sQQQQQIIQ", start, 8)
        expect(version == 2, "version")
        checked(start[:248], struct.unpack_from("<Q", start, 248)[0], "header")
        checked(start[256:], root_sum, "root")
        self.id, self.body, self.datum = start[224:240].hex(), body.rstrip(b"\0").decode(), datum.rstrip(b"\0").decode()
        self.metadata = checked(self.read(metadata_at, metadata_bytes), metadata_sum, "metadata").decode()
        self.root = start[256:256 + root_bytes]

    def read(self, offset, count):
        self.file.seek(offset)
        data = self.file.read(count)
        expect(len(data) == count, f"{count} bytes at {offset}")
        return data

    def entries(self, page=None):
        """The tiles beneath a page, or all, in the order of the index."""
        page = page or self.root[4 + 32 * struct.unpack_from("<I", self.root)[0]:]
        height, _, rows, frame_bytes, column_bytes = struct.unpack_from("<BBHHH", page)
        columns = Columns(unzstd(page[8:8 + frame_bytes], column_bytes))
        sums = iter(struct.unpack(f"<{(len(page) - 8 - frame_bytes) // 8}Q", page[8 + frame_bytes:]))
        keys = list(itertools.accumulate(columns.numbers(rows)))
        if height == 0:
            yield from self.leaf(columns, keys, sums)
            return
        columns.numbers(rows)  # entries beneath
        end = 0
        for size in columns.numbers(rows):
            offset = end + signed(columns.number())
            end = offset + size
            yield from self.entries(checked(self.read(offset, size), next(sums), f"page at {offset}"))

    @staticmethod
    def leaf(columns, keys, sums):
        rows = [Entry() for _ in keys]
        for e, key in zip(rows, keys):
            e.layer, e.level, e.x, e.y = tile_of(key)
            e.flags, e.bytes, e.offset, e.checksum = columns.number(), 0, 0, 0
        stored = [e for e in rows if not e.flags & CONSTANT]
        for e in stored:
            e.bytes = columns.number()
        end = lowest = 0
        for e in stored:
            e.offset, e.checksum = end + signed(columns.number()), next(sums)
            end = e.offset + e.bytes
        for e in rows:
            e.minimum = lowest = lowest + signed(columns.number())
        for e in rows:
            e.maximum = e.minimum + signed(columns.number())
        for e in rows:
            e.error = struct.unpack_from("<f", columns.data, columns.at)[0]
            columns.at += 4
        for e in rows:
            e.filled = columns.number()
        expect(columns.at == len(columns.data), "columns of a leaf")
        return rows

    def heights(self, entry):
        """N rows of N samples in quanta, from the south; None where a sample is void."""
        n = self.size
        if entry.flags & CONSTANT:
            return [[entry.minimum] * n for _ in range(n)]
        block = checked(self.read(entry.offset, entry.bytes), entry.checksum, str(entry))
        codec, flags, step = struct.unpack_from("<BBH", block)
        expect(codec in (1, 2) and flags in (0, 1) and step > 0, "height block")
        code, mask = block[4:], None
        if flags & 1:
            length = struct.unpack_from("<I", code)[0]
            mask, code = unzstd(code[4:4 + length], n * n + 7 >> 3), code[4 + length:]
        rows = [[s * step for s in row] for row in (planes if codec == 1 else wavefront)(code, n)]
        for i in range(n * n if mask else 0):
            if mask[i >> 3] >> (i & 7) & 1:
                rows[i // n][i % n] = None
        return rows


def int_of(bits, value):
    return (value + (1 << bits - 1) & (1 << bits) - 1) - (1 << bits - 1)


def planes(code, n):
    data, rows = unzstd(code[1:], code[0] * n * n), [[0] * n]
    for r in range(n):
        rise, row = 0, []
        for c in range(n):
            rise += signed(sum(data[(p * n + r) * n + c] << 8 * p for p in range(code[0])))
            row.append(int_of(32, rise + rows[-1][c]))
        rows.append(row)
    return rows[1:]


class Bits:
    def __init__(self, data):
        self.value, self.left = int.from_bytes(data, "little"), 8 * len(data)

    def read(self, count):
        expect(self.left >= count, "header bits")
        value = self.value & (1 << count) - 1
        self.value >>= count
        self.left -= count
        return value

    def rice(self, low):
        quotient = 0
        while quotient < 20 and self.read(1):
            quotient += 1
        return self.read(17) if quotient == 20 else quotient << low | self.read(low)


def context(bits):
    """Raw bits, and for each slot the symbol, its frequency and where it starts."""
    raw, slots, last, symbol = bits.read(3), [], 128, 0
    while len(slots) < 1024:
        last = bits.rice(max(last.bit_length() - 2, 0))
        slots += [(symbol, last, len(slots))] * last
        symbol += 1
    expect(len(slots) == 1024, "frequencies")
    return raw, slots


TAPS = [(-2, 0), (-1, 0), (1, -1), (2, -1), (-1, -1), (0, -1), (-3, -1), (-2, -1), (0, -2), (1, -2), (-2, -2), (-1, -2)]
AROUND = [(-1, 0, 4), (-2, 0, 2), (0, -1, 4), (1, -1, 3), (-1, -1, 3), (2, -1, 1), (-2, -1, 1), (0, -2, 2),
          (1, -2, 1), (-1, -2, 1)]
LANES = [16 * half + lane for half in (0, 1) for odd in (0, 1) for lane in range(odd, 16, 2)]


def wavefront(code, n):
    form = code[0]
    if form == 0:
        return [[struct.unpack_from("<i", code, 1)[0]] * n for _ in range(n)]
    if form == 2:
        return planes(code[1:], n)
    expect(form == 1, "form")
    base, header, word_count, escape_count = struct.unpack_from("<iIII", code, 1)
    bits = Bits(code[17:17 + header])
    words = iter(struct.unpack_from(f"<{word_count}H", code, 17 + header))
    states = list(struct.unpack_from("<32I", code, 17 + header + 2 * word_count))
    escapes = iter(struct.unpack_from(f"<{escape_count}H", code, 145 + header + 2 * word_count))
    expect(len(code) == 145 + header + 2 * word_count + 2 * escape_count, "parts")
    weights = [int_of(16, bits.read(16)) for _ in range(12)]
    limits = [bits.read(15) for _ in range(7)]
    contexts = [context(bits) if bits.read(1) else None for _ in range(8)]

    width = max(n + 5, 97)
    plane, sizes = [0] * (width * (n + 1)), [0] * (width * (n + 1))  # rows -1 … n-1, three columns before each
    second, rice, last, slope = bits.read(1), bits.read(4), 0, 0
    for c in range(n):
        sample = int_of(16, last + slope + signed(bits.rice(rice)))
        slope = sample - last if second and c else 0
        plane[width + 3 + c] = last = sample
    for at in range(width):
        plane[width + at] = plane[at] = plane[width + min(max(at, 3), n + 2)]

    taps = [(weight, row * width + column) for weight, (column, row) in zip(weights, TAPS)]
    around = [(row * width + column, factor) for column, row, factor in AROUND]
    def place(travelled, lane):
        return (1 + travelled // width * 32 + lane if travelled >= 0 else n), travelled % width - 3

    for step in range((n + 30) // 32 * width + 93):
        values = {}
        for lane in LANES:
            row, column = place(step - 3 * lane, lane)
            if row >= n or not 0 <= column < n:
                continue
            at = (row + 1) * width + 3 + column
            activity = sum(factor * sizes[at + offset] for offset, factor in around)
            raw_bits, slots = contexts[sum(limit <= activity for limit in limits)]
            state = states[lane]
            raw, state = state & (1 << raw_bits) - 1, state >> raw_bits
            symbol, frequency, start = slots[state & 1023]
            state = frequency * (state >> 10) + (state & 1023) - start
            states[lane] = state << 16 | next(words) if state < 0x8000 else state
            values[lane] = None if symbol == 63 else symbol << raw_bits | raw
        for lane in range(32):
            row, column = place(step - 3 * lane, lane)
            if row >= n:
                continue
            at = (row + 1) * width + 3 + column
            if lane in values:
                value = values[lane] if values[lane] is not None else next(escapes)
                predicted = int_of(32, 2048 + sum(weight * plane[at + offset] for weight, offset in taps)) >> 12
                plane[at], sizes[at] = int_of(16, predicted + signed(value)), min((value + 1) // 2, 1023)
            elif column >= 0:
                plane[at] = plane[at - 1]
            else:  # the row's beginning: of the row below, or of the one below that
                plane[at] = plane[row * width + 3 - (width if column == -3 else 0)]
    expect(all(state == 0x8000 for state in states), "states")
    expect(next(words, None) is None and next(escapes, None) is None, "words")
    return [[base + s for s in plane[(r + 1) * width + 3:(r + 1) * width + 3 + n]] for r in range(n)]


def main(arguments):
    check = arguments[:1] == ["--check"]
    pack, wanted = Pack(arguments[check]), arguments[check + 1:]
    for entry in pack.entries():
        if not check and not wanted:
            print(entry)
        elif entry.layer == 0 and (check or f"{entry.level}/{entry.x}/{entry.y}" in wanted):
            rows = pack.heights(entry)
            for row in [] if check else rows:
                print(*("void" if s is None else s for s in row))


if __name__ == "__main__":
    if len(sys.argv) < 2 or sys.argv[1] in ("-h", "--help"):
        sys.exit(__doc__)
    try:
        main(sys.argv[1:])
    except (ValueError, OSError, struct.error, IndexError, StopIteration) as error:
        sys.exit(f"{sys.argv[-1]}: {error}")
