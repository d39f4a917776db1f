"""Pictures and words of an object for a notebook, in HTML, all escaped."""
