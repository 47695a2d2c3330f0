"""Packs and unpacks arrays as glTF's EXT_meshopt_compression stores them: version 0 of meshoptimizer's vertex codec, its index sequences, and two of its
filters. The format is https://github.com/KhronosGroup/glTF/tree/main/extensions/2.0/Vendor/EXT_meshopt_compression."""

import json
import struct

import numpy as np

EXTENSION = "EXT_meshopt_compression"
TAIL = 32
"""Bytes behind the packed rows, at least."""


def rows(array):
    """Rows of 4, 8 or 12 bytes: the change of each byte from row to row, with 0, 2, 4 or 8 bits in groups of 16 rows."""
    array = np.ascontiguousarray(array)
    data = array.view(np.uint8).reshape(len(array), -1)
    count, stride = data.shape
    change = np.diff(data, axis=0, prepend=data[:1]).view(np.int8)
    zigzag = ((change.astype(np.int16) << 1) ^ (change.astype(np.int16) >> 7)).astype(np.uint8)
    block = min(8192 // stride & ~15, 256)
    out = [b"\xa0"]
    for first in range(0, count, block):
        part = zigzag[first : first + block]
        part = np.concatenate([part, np.zeros((-len(part) % 16, stride), np.uint8)])
        for column in part.T:
            out.append(_column(column.reshape(-1, 16)))
    out.append(bytes(max(TAIL - stride, 0)) + data[0].tobytes())
    return b"".join(out)


def _column(groups):
    """One byte of the rows of a block: two bits for the width of each group, then the groups."""
    cost = np.stack([np.where(groups.any(1), 99, 0), 4 + (groups >= 3).sum(1), 8 + (groups >= 15).sum(1), np.full(len(groups), 16)])
    width = cost.argmin(0)
    head = np.zeros((len(groups) + 3) // 4 * 4, np.uint8)
    head[: len(groups)] = width
    out = [(head.reshape(-1, 4) << np.array([0, 2, 4, 6], np.uint8)).sum(1).astype(np.uint8).tobytes()]
    two, four = np.minimum(groups, 3).reshape(-1, 4, 4), np.minimum(groups, 15).reshape(-1, 8, 2)
    two = (two << np.array([6, 4, 2, 0], np.uint8)).sum(2).astype(np.uint8)
    four = (four << np.array([4, 0], np.uint8)).sum(2).astype(np.uint8)
    for k, w in enumerate(width):
        if w == 1:
            out += [two[k].tobytes(), groups[k][groups[k] >= 3].tobytes()]
        elif w == 2:
            out += [four[k].tobytes(), groups[k][groups[k] >= 15].tobytes()]
        elif w == 3:
            out.append(groups[k].tobytes())
    return b"".join(out)


def sequence(indices):
    """Indices, each as the difference from one of two running ones."""
    out, last, current = bytearray(b"\xd1"), [0, 0], 0
    for index in np.asarray(indices).reshape(-1).tolist():
        current ^= abs(index - last[current]) >= 30
        change = index - last[current]
        last[current] = index
        value = ((2 * change if change >= 0 else -2 * change - 1) << 1) | current
        while value > 127:
            out.append(value & 127 | 128)
            value >>= 7
        out.append(value)
    return bytes(out) + bytes(4)


def steps(values, exponent):
    """The filter EXPONENTIAL: floats as multiples of 2 ** exponent."""
    whole = np.round(np.asarray(values, float) / 2.0**exponent).astype(np.int32)
    return whole & 0xFFFFFF | exponent << 24


def octahedral(normals, bits):
    """The filter OCTAHEDRAL: unit vectors, for 16-bit numbers."""
    n = np.asarray(normals, float)
    n = n / np.abs(n).sum(1, keepdims=True)
    folded = (1 - np.abs(n[:, [1, 0]])) * np.where(n[:, :2] >= 0, 1, -1)
    flat = np.where(n[:, 2:] >= 0, n[:, :2], folded)
    out = np.zeros((len(n), 4), np.int16)
    out[:, :2], out[:, 2] = np.round(flat * (2 ** (bits - 1) - 1)), 2 ** (bits - 1) - 1
    return out


def unpacked(file):
    """The bytes of a .glb file without the extension, for programs that do not read it."""
    length = int.from_bytes(file[12:16], "little")
    gltf, packed = json.loads(file[20 : 20 + length]), file[28 + length :]
    data = bytearray()
    for view in gltf["bufferViews"]:
        content, extension = packed[view.get("byteOffset", 0) :][: view["byteLength"]], view.pop("extensions", {}).get(EXTENSION)
        if extension:
            content = packed[extension["byteOffset"] :][: extension["byteLength"]]
            count, stride = extension["count"], extension["byteStride"]
            content = _unpacked_rows(content, count, stride) if extension["mode"] == "ATTRIBUTES" else _unpacked_sequence(content, count, stride)
            content = FILTERS[extension.get("filter", "NONE")](content).tobytes()
        view["buffer"], view["byteOffset"], view["byteLength"] = 0, len(data), len(content)
        data += content + bytes(-len(content) % 4)
    gltf["buffers"] = [{"byteLength": len(data)}]
    for names in (gltf["extensionsUsed"], gltf["extensionsRequired"]):
        names.remove(EXTENSION)
    text = json.dumps(gltf).encode()
    text += b" " * (-len(text) % 4)
    body = struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(data), 0x004E4942) + data
    return struct.pack("<III", 0x46546C67, 2, 12 + len(body)) + body


def _unpacked_rows(content, count, stride):
    out, last = np.empty((count, stride), np.uint8), np.frombuffer(content[-stride:], np.uint8)
    block, at = min(8192 // stride & ~15, 256), 1
    spread = {bits: [bytes(b >> s & (1 << bits) - 1 for s in range(8 - bits, -1, -bits)) for b in range(256)] for bits in (2, 4)}
    for first in range(0, count, block):
        rows = out[first : first + block]
        groups = (len(rows) + 15) // 16
        for k in range(stride):
            head, column = content[at : at + (groups + 3) // 4], bytearray()
            at += len(head)
            for g in range(groups):
                width = head[g // 4] >> g % 4 * 2 & 3
                bits = (0, 2, 4, 8)[width]
                part = content[at : at + 2 * bits]
                at += len(part)
                if width in (1, 2):
                    part = bytearray(b"".join(map(spread[bits].__getitem__, part)))
                    for i in [i for i, value in enumerate(part) if value == (1 << bits) - 1]:
                        part[i], at = content[at], at + 1
                column += part or bytes(16)
            zigzag = np.frombuffer(bytes(column[: len(rows)]), np.uint8)
            rows[:, k] = last[k] + np.cumsum((zigzag >> 1) ^ -(zigzag & 1), dtype=np.uint8)
        last = rows[-1]
    return out


def _unpacked_sequence(content, count, stride):
    each = np.frombuffer(content[1:], np.uint8)
    ends = np.flatnonzero(each < 128)[:count]
    starts = np.concatenate([[0], ends[:-1] + 1])
    value = sum((each[np.minimum(starts + k, ends)].astype(np.int64) & 127) * (starts + k <= ends) << 7 * k for k in range(5))
    change, which = value >> 2 ^ -(value >> 1 & 1), value & 1
    for one in (0, 1):
        change[which == one] = np.cumsum(change[which == one])
    return change.astype(f"<u{stride}")


def _floats(rows):
    whole = rows.view("<i4")
    return np.ldexp((whole << 8 >> 8).astype(np.float32), whole >> 24)


def _normals(rows):
    n = rows.view("<i2").astype(float)
    n[:, :2] /= n[:, 2:3]
    n[:, 2] = 1 - np.abs(n[:, :2]).sum(1)
    n[:, :2] -= np.copysign(np.maximum(-n[:, 2:3], 0), n[:, :2])
    n[:, :3] /= np.linalg.norm(n[:, :3], axis=1, keepdims=True)
    return np.round(n * [32767, 32767, 32767, 1]).astype("<i2")


FILTERS = {"NONE": lambda content: content, "EXPONENTIAL": _floats, "OCTAHEDRAL": _normals}
