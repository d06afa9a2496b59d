"""The robot's own wire: types, bytes and checksums of its DDS topics, and what a participant needs to read and write them."""
