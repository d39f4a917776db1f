"""The computer below the package: libraries, threads, files, a terminal."""
