"""Questions about many designs: maps, polytopes, bounds, regions."""
