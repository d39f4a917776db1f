"""Questions about many designs: maps, polytopes."""
