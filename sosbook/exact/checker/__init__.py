"""What checks proofs with standard Python alone."""
