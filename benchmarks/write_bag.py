"""Writes a bag of 200 MB as ros2 bag record would: build/readers/venv/bin/python benchmarks/write_bag.py FOLDER [zstd]"""

import sys

import numpy
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

SECOND = 10**9
BEGIN = 1_700_000_000 * SECOND
compressed = sys.argv[2:] == ["zstd"]

types = get_typestore(Stores.ROS2_JAZZY)
number, image = "std_msgs/msg/Float32", "sensor_msgs/msg/CompressedImage"
header = types.types["std_msgs/msg/Header"](stamp=types.types["builtin_interfaces/msg/Time"](sec=0, nanosec=0), frame_id="camera")
chance = numpy.random.default_rng(1)
levels, size = (16, 194_000) if compressed else (256, 97_000)  # 200 MB either way

writer = Writer(sys.argv[1], version=9, storage_plugin=StoragePlugin.MCAP)
if compressed:
    writer.set_compression(CompressionMode.STORAGE, CompressionFormat.ZSTD)
with writer as bag:
    visitor = bag.add_connection("/visitor", number, typestore=types)
    camera = bag.add_connection("/camera", image, typestore=types)
    visit = types.serialize_cdr(types.types[number](data=-1.0), number)
    for n in range(100_000):
        t = BEGIN + n * SECOND // 100
        bag.write(visitor, t, visit)
        if n % 50 == 0:
            picture = types.types[image](header=header, format="jpeg", data=chance.integers(0, levels, size, dtype=numpy.uint8))
            bag.write(camera, t, types.serialize_cdr(picture, image))
