"""What the package finds on a computer: libraries, threads, a terminal."""
