"""The robot in three dimensions: meshes, camera, footprints."""
