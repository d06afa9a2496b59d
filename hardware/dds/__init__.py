"""The robot's own wire: types, bytes and checksums of its DDS topics, and how to read and write them."""
