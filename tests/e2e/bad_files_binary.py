# SPDX-License-Identifier: Apache-2.0
"""Bad images and databases that code makes, and the good ones they are told from."""
import os
import sqlite3
import struct
import zlib

from bad_files_made import Bad, text

WIDTH, HEIGHT = 160, 120  # of the good twin's camera


def chunk(kind, data, crc=None):
    body = kind + data
    return struct.pack(">I", len(data)) + body + struct.pack(">I", zlib.crc32(body) if crc is None else crc)


def zeros_compressed(megabytes, kind=zlib.MAX_WBITS):
    """A megabyte at a time: the memory of this process counts as the program's."""
    packer = zlib.compressobj(9, wbits=kind)
    return b"".join(packer.compress(bytes(1 << 20)) for _ in range(megabytes)) + packer.flush()


def ihdr(width=WIDTH, height=HEIGHT, bits=8, colour=0, interlace=0):
    return chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, bits, colour, 0, 0, interlace))


def png(width=WIDTH, height=HEIGHT, bits=8, colour=0, row=None, more=b"", interlace=0):
    """A gray image, every row 100 unless given."""
    rows = (b"\0" + (row or b"\x64" * (width * bits // 8))) * height
    return b"\x89PNG\r\n\x1a\n" + ihdr(width, height, bits, colour, interlace) + more + chunk(b"IDAT",
        zlib.compress(rows)) + chunk(b"IEND", b"")


def raw_png(*chunks):
    return b"\x89PNG\r\n\x1a\n" + b"".join(chunks) + chunk(b"IEND", b"")


def attribute(name, kind, data):
    return name + b"\0" + kind + b"\0" + struct.pack("<I", len(data)) + data


def exr_channel(name, kind=2, sampling=1):
    return name + b"\0" + struct.pack("<IBxxxII", kind, 0, sampling, sampling)


def exr(width=WIDTH, height=HEIGHT, channels=exr_channel(b"Y"), window=None, compression=0, version=2, body=None, order=0,
    more=b""):
    """Rows of 0.5, not compressed."""
    box = struct.pack("<4i", *(window or (0, 0, width - 1, height - 1)))
    head = (b"\x76\x2f\x31\x01" + struct.pack("<I", version) + attribute(b"channels", b"chlist", channels + b"\0") +
            attribute(b"compression", b"compression", bytes([compression])) + attribute(b"dataWindow", b"box2i", box) +
            attribute(b"displayWindow", b"box2i", box) + attribute(b"lineOrder", b"lineOrder", bytes([order])) +
            attribute(b"pixelAspectRatio", b"float", struct.pack("<f", 1)) + attribute(b"screenWindowCenter", b"v2f",
                bytes(8)) +
            attribute(b"screenWindowWidth", b"float", struct.pack("<f", 1)) + more + b"\0")
    if body is not None:
        return head + body
    row = struct.pack("<f", 0.5) * width
    first = len(head) + 8 * height
    offsets = b"".join(struct.pack("<Q", first + y * (8 + len(row))) for y in range(height))
    return head + offsets + b"".join(struct.pack("<iI", y, len(row)) + row for y in range(height))


def tiff(width=WIDTH, height=HEIGHT, bits=8, compression=1, data=None, next_directory=0, more=(), samples=1):
    data = b"\x64" * (WIDTH * HEIGHT) if data is None else data
    tags = sorted([(256, width), (257, height), (258, bits), (259, compression), (262, 1 if samples == 1 else 2), (277, samples), (278, height),
        (279, len(data)), *more])
    at = 8 + 2 + 12 * (len(tags) + 1) + 4
    tags = sorted(tags + [(273, at)])
    directory = struct.pack("<H", len(tags)) + b"".join(struct.pack("<HHII", tag, 4, 1, value) for tag, value in tags)
    return b"II*\0" + struct.pack("<I", 8) + directory + struct.pack("<I", next_directory) + data


def bmp(width=WIDTH, height=HEIGHT, bits=8, compression=0, data=None):
    data = b"\x64" * (WIDTH * HEIGHT) if data is None else data
    palette = b"".join(struct.pack("<I", gray * 0x010101) for gray in range(256))
    return (b"BM" + struct.pack("<III", 54 + len(palette) + len(data), 0, 54 + len(palette)) +
            struct.pack("<IiiHHIIIIII", 40, width, height, 1, bits, compression, 0, 0, 0, 0, 0) + palette + data)


def colours():
    """Of a set that takes one colour of its images."""
    size, row = 60_000, b"\x64" * WIDTH
    pixels = b"\x64" * (3 * WIDTH * HEIGHT)
    size_of_ppm = b"160 120\n255\n"
    cases = {
        "wrong_size.png": png(WIDTH + 1, colour=2, row=b"\x64" * 3 * (WIDTH + 1)), "rows_of_gray.png": png(colour=2),
        "cut.png": png(colour=6, row=row * 4)[:60], "palette_missing.png": png(colour=3),
        "palette_too_short.png": png(colour=3, more=chunk(b"PLTE", bytes(3))),
        "60000_by_60000.png": raw_png(ihdr(size, size, 16, 6), chunk(b"IDAT", b"\x78\x9c\x03\0\0\0\0\1")),
        "values_above_the_sensor.png": png(bits=16, colour=2, row=b"\xff\xff" * 3 * WIDTH),
        "gray_with_alpha.png": png(colour=4, row=row * 2),
        "planes.tif": tiff(samples=3, data=pixels, more=[(284, 2)]), "data_missing.tif": tiff(samples=3),
        "samples_4_billion.tif": tiff(samples=0xffffffff, data=pixels), "samples_65535.tif": tiff(samples=65535, data=pixels),
        "60000_by_60000.tif": tiff(size, size, samples=4, data=pixels),
        "data_missing.bmp": bmp(bits=24), "60000_by_60000.bmp": bmp(size, size, bits=32, data=pixels),
        "run_lengths.bmp": bmp(bits=24, compression=1, data=pixels), "masks_of_zero.bmp": bmp(bits=32, compression=3, data=pixels * 2),
        "of_16_bits.bmp": bmp(bits=16, data=pixels), "width_of_2_billion.bmp": bmp((1 << 31) - 1, bits=24, data=pixels),
        "cut.ppm": b"P6\n" + size_of_ppm + pixels[1:], "decimal.ppm": b"P3\n" + size_of_ppm + b"7 " * (3 * WIDTH * HEIGHT),
        "most_of_0.ppm": b"P6\n160 120\n0\n" + pixels, "wrong_size.ppm": b"P6\n161 120\n255\n" + pixels,
    }
    return [text(name, data, "." + name.rsplit(".", 1)[1]) for name, data in cases.items()]


def pngs():
    bomb = zeros_compressed(200)  # 200 KB
    row = b"\x64" * WIDTH
    whole = chunk(b"IDAT", zlib.compress((b"\0" + row) * HEIGHT))
    size = 60_000
    huge = raw_png(ihdr(size, size), chunk(b"IDAT", b"\x78\x9c\x03\0\0\0\0\1"))
    cases = {
        "wrong_size": png(WIDTH + 1), "coloured": png(colour=2, row=row * 3), "with_alpha": png(colour=4, row=row * 2),
        "palette": png(colour=3, more=chunk(b"PLTE", bytes(768))), "of_3_bits": png(bits=3, row=row),
       
        "colour_of_9": png(colour=9), "interlaced_of_7": png(interlace=7), "no_width": png(0, 4, row=b"\0"),
        "width_of_2_pow_31": raw_png(ihdr(1 << 31, 1)),
        "no_rows": raw_png(ihdr()), "two_heads": raw_png(ihdr(), ihdr()),
        "no_head": raw_png(chunk(b"IDAT", zlib.compress(row))),
        "wrong_checksum": raw_png(ihdr(), chunk(b"IDAT", zlib.compress((b"\0" + row) * HEIGHT), crc=1)),
        "rows_too_few": raw_png(ihdr(), chunk(b"IDAT", zlib.compress(b"\0" + row))),
        "rows_no_zlib": raw_png(ihdr(), chunk(b"IDAT", row)),
        "filter_of_9": raw_png(ihdr(), chunk(b"IDAT", zlib.compress((b"\x09" + row) * HEIGHT))),
        "chunk_of_2_GB": b"\x89PNG\r\n\x1a\n" + ihdr() + b"\x7f\xff\xff\xffIDAT",
        "chunk_unknown_but_needed": raw_png(ihdr(), chunk(b"ABCD", b"")),
        "cut": png()[:60], "text_alone": b"\x89PNG\r\n\x1a\n", "line_breaks_changed": png().replace(b"\r\n", b"\n", 1),
        "comment_of_200_MB": raw_png(ihdr(WIDTH + 1), chunk(b"zTXt", b"a\0\0" + bomb), whole),
        "profile_of_200_MB": raw_png(ihdr(WIDTH + 1), chunk(b"iCCP", b"a\0\0" + bomb), whole),
        "rows_of_200_MB": raw_png(ihdr(WIDTH + 1), chunk(b"IDAT", bomb)),
        "values_above_the_sensor": png(bits=16, row=b"\xff\xff" * WIDTH),
        "is_jpeg": b"\xff\xd8\xff\xe0" + bytes(20), "is_gif": b"GIF89a" + bytes(20),
    }
    return [text(name, data) for name, data in cases.items()] + [text("60000_by_60000", huge),
        text("60000_by_60000_all", huge, everywhere=True)]


def tiffs():
    cases = {
        "wrong_size.tif": tiff(WIDTH + 1), "no_width.tif": tiff(0), "width_4_billion.tif": tiff(0xffffffff, 0xffffffff),
        "of_64_bits.tif": tiff(bits=64),
        "compression_unknown.tif": tiff(compression=31337), "lzw_of_noise.tif": tiff(compression=5, data=b"\xaa\x55" * 500),
        "deflate_bomb.tif": tiff(60_000, 60_000, compression=8, data=zeros_compressed(20)),
        "data_missing.tif": tiff(data=b""), "directory_points_to_itself.tif": tiff(WIDTH + 1, next_directory=8),
        "directory_beyond.tif": b"II*\0\xff\xff\xff\x7f", "tags_65535.tif": b"II*\0\x08\0\0\0\xff\xff" + bytes(64),
        "planes_900.tif": tiff(more=[(284, 900)]),
        "floats.tif": tiff(bits=32, more=[(339, 3)], data=bytes(4 * WIDTH * HEIGHT)), "head_alone.tif": b"II*\0",
        "big_tiff_head.tif": b"II+\0\x08\0\0\0" + b"\xff" * 8,
        "60000_by_60000.tif": tiff(60_000, 60_000),
        "wrong_size.bmp": bmp(WIDTH - 4), "height_minus_2_billion.bmp": bmp(height=-(1 << 31)),
        "width_negative.bmp": bmp(-WIDTH), "of_13_bits.bmp": bmp(bits=13),
        "rle_of_noise.bmp": bmp(compression=1, data=b"\xaa\x00" * 100),
        "data_missing.bmp": bmp(data=b""), "60000_by_60000.bmp": bmp(60_000, 60_000, data=b""),
        "head_alone.bmp": b"BM" + bytes(12),
        "wrong_size.pgm": b"P5\n161 120\n255\n" + bytes(161 * 120),
        "maximum_zero.pgm": b"P5\n160 120\n0\n" + bytes(160 * 120),
        "maximum_100000.pgm": b"P5\n160 120\n100000\n" + bytes(160 * 120), "cut.pgm": b"P5\n160 120\n255\nabc",
        "size_1e9.pgm": b"P5\n1000000000 1000000000\n255\n", "size_overflows.pgm": b"P5\n99999999999999999999 1\n255\n",
        "size_negative.pgm": b"P2\n-1 -1\n255\n", "comment_without_end.pgm": b"P2\n#" + b"x" * 100000,
        "colour.ppm": b"P6\n160 120\n255\n" + bytes(3 * 160 * 120),
        "head_alone.pgm": b"P5", "head_alone.jpg": b"\xff\xd8\xff\xe0",
        "65500_by_65500.jpg": b"\xff\xd8\xff\xc0\0\x0b\x08\xff\xdc\xff\xdc\x01\x01\x11\0\xff\xda\0\x08\x01\x01\0\0\x3f\0",
        "head_alone.webp": b"RIFF\x24\0\0\0WEBPVP8L",
        "head_alone.jp2": b"\0\0\0\x0cjP  \r\n\x87\n",
        "head_alone.hdr": b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1000000 +X 1000000\n",
        "html.tif": b"<!DOCTYPE html><html>404</html>",
    }
    return [text(name, data, os.path.splitext(name)[1]) for name, data in cases.items()]


def exrs():
    thousand = b"".join(exr_channel(b"c%04d" % i) for i in range(1000))
    cases = {
        "wrong_size": exr(WIDTH + 1), "two_channels": exr(channels=exr_channel(b"A") + exr_channel(b"Y"), body=b""),
        "no_channels": exr(channels=b"", body=b""), "channel_of_type_9": exr(channels=exr_channel(b"Y", 9)),
        "channel_of_no_sampling": exr(channels=exr_channel(b"Y", sampling=0)),
        "channel_sampled_2": exr(channels=exr_channel(b"Y", sampling=2)),
        "channel_name_of_300": exr(channels=exr_channel(b"Y" * 300)),
        "window_backwards": exr(window=(10, 10, 0, 0)),
        "window_of_2_pow_32": exr(window=(-(1 << 31), -(1 << 31), (1 << 31) - 1, (1 << 31) - 1), body=b""),
        "window_of_60000": exr(window=(0, 0, 59_999, 59_999), body=b""),
        "channels_1000": exr(channels=thousand, body=b""),
        # OpenEXR adds the channels of a second list to those of the first
        "channels_1000_then_one": exr(channels=thousand, body=b"",
            more=attribute(b"channels", b"chlist", exr_channel(b"Y") + b"\0")),
        "channels_1000_of_20000": exr(channels=thousand, window=(0, 0, 19_999, 19_999), body=b""),
        "compression_of_99": exr(compression=99), "zip_of_rows": exr(compression=3), "version_of_77": exr(version=77),
        "tiled_without_tiles": exr(version=2 | 0x200), "deep_without_depth": exr(version=2 | 0x800),
        "parts_without_parts": exr(version=2 | 0x1000), "order_of_9": exr(order=9), "cut": exr()[:-1000],
        "head_alone": b"\x76\x2f\x31\x01\x02\0\0\0", "no_attributes": b"\x76\x2f\x31\x01\x02\0\0\0\0",
        # OpenEXR goes by the type and reads four bytes on; who goes by the size takes the zero for the end
        "float_of_no_bytes": exr(more=attribute(b"zoom", b"float", b"") + b"\0\0\x80?" + b"owner\0string\0\xff\xff\xff\x7f", body=b""),
        "attribute_of_4_GB": exr(more=b"comment\0string\0\xff\xff\xff\xff", body=b""),
        "attribute_of_2_GB": exr(more=b"comment\0string\0\xff\xff\xff\x7f", body=b""),
        "offsets_beyond": exr(body=b"\xff" * 8 * HEIGHT), "offsets_zero": exr(body=bytes(8 * HEIGHT)), "is_png": png(),
    }
    return [text(name, data) for name,
        data in cases.items()] + [text("channels_1000_of_20000_all", cases["channels_1000_of_20000"], everywhere=True)]


def patterns():
    size = 60_000
    return [text("of_the_camera", png()),
        text("60000_by_60000", raw_png(ihdr(size, size), chunk(b"IDAT", b"\x78\x9c\x03\0\0\0\0\1"))),
        text("one_pixel", png(1, 1)),
            text("coloured", png(64, 48, colour=2, row=bytes(3 * 64))), text("cut", png(64, 48)[:50]),
            text("transposed", png(48, 64))]


def database(*statements):
    def put(path):
        with sqlite3.connect(path) as db:
            for statement in statements:
                db.execute(statement)
        db.close()
    return put


def stores():
    """Databases of others, and ours with what does not belong there."""
    cases = [Bad("of_another_program", database("CREATE TABLE users (name TEXT)", "INSERT INTO users VALUES ('x')")),
             Bad("of_another_version", database("PRAGMA user_version = 999", "CREATE TABLE points (id INTEGER)")),
             Bad("of_another_application", database("PRAGMA application_id = 7", "CREATE TABLE points (id INTEGER)")),
             Bad("a_view_for_a_table", database("CREATE TABLE t (id)", "CREATE VIEW points AS SELECT id FROM t", "CREATE VIEW study AS SELECT id FROM t")),
             Bad("endless_view",
             database("CREATE VIEW points AS WITH RECURSIVE n(id) AS (SELECT 0 UNION ALL SELECT id + 1 FROM n) SELECT id FROM n"))]
    head = b"SQLite format 3\0"
    return cases + [text("head_alone", head), text("pages_of_3_bytes", head + b"\0\3" + bytes(2000)),
        text("head_and_noise", head + b"\x10\0\1\1\0\x40\x20\x20" + b"\xaa" * 5000)]


def opencv_bombs():
    return [text("zipped_200_MB", zeros_compressed(200, zlib.MAX_WBITS + 16), ".yml.gz")]


OWN = {"colour": colours, "png": pngs, "tiff": tiffs, "exr": exrs, "patterns": patterns, "study_store": stores, "opencv": opencv_bombs}


def own(reader):
    return OWN[reader]() if reader in OWN else []


def good(reader):
    pixels = b"\x64" * (3 * WIDTH * HEIGHT)
    images = {"colour": [(png(colour=2, row=b"\x64" * 3 * WIDTH), ".png"), (tiff(samples=3, data=pixels), ".tif"),
                         (bmp(bits=24, data=pixels), ".bmp"), (b"P6\n160 120\n255\n" + pixels, ".ppm")],
              "png": [(png(), "")], "exr": [(exr(), "")], "patterns": [(png(64, 48), "")],
              "tiff": [(tiff(), ".tif"), (bmp(), ".bmp"), (b"P5\n160 120\n255\n" + b"\x64" * (WIDTH * HEIGHT), ".pgm")]}
    return [text(f"good{suffix}", data, suffix, good=True) for data, suffix in images.get(reader, [])]
