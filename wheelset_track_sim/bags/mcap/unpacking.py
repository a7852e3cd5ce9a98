"""Unpack chunks within bounds: no more bytes than a chunk declares, and no more than the limits."""

from __future__ import annotations

from io import BytesIO

from lz4.frame import LZ4FrameDecompressor
from zstandard import ZstdDecompressor

COMPRESSIONS = (b"", b"lz4", b"zstd")
ZSTD = b"\x28\xb5\x2f\xfd"
"""Beginning of a zstd frame."""
LARGEST = 1 << 28
"""Largest chunk, record or index that is read, bytes."""
LARGEST_WINDOW = 1 << 27
"""Memory of the zstd decompressor, bytes."""


def unpacked(compression: bytes, packed: bytes, size: int) -> bytes:
    """Unpack the content of a chunk.

    Parameters
    ----------
    compression
        One of ``COMPRESSIONS``.
    packed
        Compressed bytes; one frame or several.
    size
        Bytes that the chunk declares. No more than one byte beyond them is unpacked.

    Raises
    ------
    ValueError
        The content has another size. The libraries raise errors of their own for bytes that are not compressed.
    """
    if compression == b"zstd":
        decompressor = ZstdDecompressor(max_window_size=LARGEST_WINDOW)
        with decompressor.stream_reader(BytesIO(packed), read_across_frames=True) as stream:
            found = stream.read(size + 1)
    elif compression == b"lz4":
        found = _lz4(packed, size + 1)
    else:
        found = packed
    if len(found) != size:
        amount = "more" if len(found) > size else f"{len(found)} bytes"
        raise ValueError(f"it declares {size} bytes and unpacks to {amount}")
    return found


def unpacked_message(packed: bytes | memoryview, most: int) -> bytes:
    """Unpack a message that rosbag2 has compressed by itself (``--compression-mode message``).

    Such a file does not say so in its records, but no CDR message begins as a zstd frame does (``ZSTD``). Raises
    ValueError for more than ``most`` bytes.
    """
    decompressor = ZstdDecompressor(max_window_size=LARGEST_WINDOW)
    with decompressor.stream_reader(BytesIO(packed), read_across_frames=True) as stream:
        found = stream.read(most + 1)
    if len(found) > most:
        raise ValueError(f"a message unpacks to more than {most} bytes")
    return found


def _lz4(packed: bytes, most: int) -> bytes:
    """The first ``most`` bytes of lz4 frames."""
    parts, left = [], most
    while packed and left:
        frame = LZ4FrameDecompressor()
        part = frame.decompress(packed, max_length=left)
        parts.append(part)
        left -= len(part)
        if not frame.eof:
            break
        packed = frame.unused_data or b""
    return b"".join(parts)
