"""Points inside affine blocks, in floats: phase one, centre, minimum."""
