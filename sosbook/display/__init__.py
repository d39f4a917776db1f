"""What a notebook shows of an object: pictures and words in HTML, all escaped."""
