"""The solver of the rendered page: LMIs in plain JavaScript, modules as they stand."""
